"""The mesh of one position: its skin, and its tissues on a cut through the left nipple."""

import _stage
import numpy as np

from mammosim.figures.surfaces import mesh_with_tissues
from mammosim.io.fiducials import read_fiducials
from mammosim.io.figures import write_figure
from mammosim.io.meshes import read_mesh


def main(mesh: str, fiducials: str, out: str) -> None:
    points = read_fiducials(fiducials)
    nipples = np.array([points.point(name) for name in ("nipple_left", "nipple_right")])
    write_figure(mesh_with_tissues(read_mesh(mesh), cut_x_mm=nipples[0, 0], nipples=nipples), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.input.mesh, snakemake.input.fiducials, snakemake.output[0])
