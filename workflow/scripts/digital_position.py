"""A digital volunteer in one position: how she lies in the scanner, and her shape under gravity there."""

import _log

from mammosim.digital.anatomy import make_anatomy
from mammosim.digital.body import Loaded
from mammosim.digital.constitution import Constitution
from mammosim.digital.loading import load_truth
from mammosim.digital.motion import gravity_in_body, motion
from mammosim.io.fiducials import write_fiducials
from mammosim.io.meshes import read_mesh, write_mesh
from mammosim.io.tables import read_json
from mammosim.io.transforms import write_transform


def main(files: dict[str, str], position: str, tissues: dict, moving: dict) -> None:
    woman = read_json(files["woman"])
    anatomy, mesh = make_anatomy(woman), read_mesh(files["rest"])
    moved = motion(position, **moving)
    made_of = Constitution.from_parameters(woman, tissues)
    loaded = load_truth(anatomy, mesh, gravity_in_body(position, moved), made_of=made_of)
    write_transform(moved, files["motion"])
    write_fiducials(Loaded(anatomy, moved, mesh, loaded.points).fiducials(), files["points"])
    write_mesh(mesh.moved_to(loaded.points), files["mesh"])


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    files = {"rest": snakemake.input.mesh, "woman": snakemake.input.woman}
    main(
        files | dict(snakemake.output.items()),
        snakemake.wildcards.p,
        snakemake.params.tissues,
        snakemake.params.moving | {"stream": (snakemake.params.seed, snakemake.wildcards.w)},
    )
