"""Prone and supine as measured, the stress-free shape of the fit, and supine as the fit predicts it."""

import _stage
import numpy as np

from mammosim.figures.deformation import stress_free
from mammosim.io.fiducials import read_fiducials
from mammosim.io.figures import write_figure
from mammosim.io.meshes import read_mesh

SHAPES = {
    "prone": "measured prone",
    "supine": "measured supine",
    "stress_free": "stress-free",
    "predicted": "supine from stress-free",
}


def main(files: dict[str, str], out: str) -> None:
    shapes = {name: read_mesh(files[key]) for key, name in SHAPES.items()}
    known = {name: mesh for name, mesh in shapes.items() if np.isfinite(mesh.points).all()}
    x, _, z = read_fiducials(files["fiducials"]).point("nipple_left")
    write_figure(stress_free(known, x_mm=x, z_mm=z), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(dict(snakemake.input.items()), snakemake.output[0])
