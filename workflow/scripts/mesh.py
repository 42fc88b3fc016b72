"""Quadratic tetrahedra of one segmented position, moved into the reference frame, with a quality table."""

import _stage
import numpy as np

from mammosim.chain.breast import scanned_mesh
from mammosim.io.fiducials import read_fiducials
from mammosim.io.images import read_labels
from mammosim.io.meshes import write_mesh
from mammosim.io.tables import write_table
from mammosim.io.transforms import read_transform
from mammosim.meshing.quality import quality


def main(files: dict[str, str], volunteer: str, position: str, settings: dict) -> None:
    chest = read_fiducials(files["fiducials"]).of_kind("chest")
    mesh = scanned_mesh(read_labels(files["labels"]), chest, settings)
    table = quality(mesh)
    table.insert(0, "volunteer", volunteer)
    table.insert(1, "position", position)
    write_table(table, files["quality"])
    to_reference = read_transform(files["transform"])
    write_mesh(mesh.moved_to(np.ascontiguousarray(to_reference(mesh.points))), files["mesh"])


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(
            dict(snakemake.input.items()) | dict(snakemake.output.items()),
            snakemake.wildcards.v,
            snakemake.wildcards.p,
            snakemake.params.settings,
        )
