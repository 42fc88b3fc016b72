"""A virtual patient in one position: her motion into the scanner frame, and her shape under gravity there."""

import _log

from mammosim.core.settings import read
from mammosim.core.tissues import TissueTable
from mammosim.digital.anatomy import make_anatomy
from mammosim.digital.body import Loaded
from mammosim.digital.constitution import Constitution
from mammosim.digital.loading import gravity_in_body, load_truth, motion
from mammosim.digital.patient import VirtualPatient
from mammosim.io.fiducials import write_fiducials
from mammosim.io.meshes import read_mesh, write_mesh
from mammosim.io.tables import read_json
from mammosim.io.transforms import write_transform


def main(files: dict[str, str], position: str, tissues: dict, moving: dict) -> None:
    patient = VirtualPatient.read(read_json(files["woman"]))
    anatomy, mesh = make_anatomy(patient), read_mesh(files["rest"])
    moved = motion(position, **moving)
    constitution = Constitution.of(patient, read(TissueTable, tissues, "digital.tissues"))
    loaded = load_truth(anatomy, mesh, gravity_in_body(position, moved), constitution=constitution)
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
