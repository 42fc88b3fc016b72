"""A digital volunteer in one position: how she lies in the scanner, and her shape under gravity there."""

import _log

from mammosim.core.tissues import tissues_by_label
from mammosim.digital.anatomy import make_anatomy
from mammosim.digital.body import Loaded
from mammosim.digital.loading import load_truth
from mammosim.digital.motion import gravity_in_body, motion
from mammosim.io.fiducials import write_fiducials
from mammosim.io.meshes import read_mesh, write_mesh
from mammosim.io.transforms import write_transform


def main(files: dict[str, str], position: str, woman: dict, tissues: dict, moving: dict) -> None:
    anatomy, mesh = make_anatomy(woman), read_mesh(files["rest"])
    moved = motion(position, **moving)
    loaded = load_truth(
        anatomy,
        mesh,
        gravity_in_body(position, moved),
        tissues=tissues_by_label(tissues["tissues"]),
        skin_youngs_modulus_kpa=tissues["skin"]["youngs_modulus_kpa"],
        skin_poisson_ratio=tissues["skin"]["poisson_ratio"],
    )
    write_transform(moved, files["motion"])
    write_fiducials(Loaded(anatomy, moved, mesh, loaded.points).fiducials(), files["points"])
    write_mesh(mesh.moved_to(loaded.points), files["mesh"])


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        {"rest": snakemake.input.mesh} | dict(snakemake.output.items()),
        snakemake.wildcards.p,
        snakemake.params.woman,
        snakemake.params.tissues,
        {
            "largest_deg": snakemake.params.rotation_deg,
            "largest_mm": snakemake.params.translation_mm,
            "stream": (snakemake.params.seed, snakemake.wildcards.w),
        },
    )
