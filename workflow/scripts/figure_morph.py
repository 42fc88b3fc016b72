"""Prone, supine, prone morphed onto supine, and the mean that unloading starts from."""

import _stage

from mammosim.figures.deformation import morph
from mammosim.io.fiducials import read_fiducials
from mammosim.io.figures import write_figure
from mammosim.io.meshes import read_mesh, read_point_data
from mammosim.io.tables import read_table

SHAPES = ("prone", "supine", "morphed", "mean")


def main(files: dict[str, str], out: str) -> None:
    shapes = {name: read_mesh(files[name]) for name in SHAPES}
    x, _, z = read_fiducials(files["fiducials"]).point("nipple_left")
    distance = read_point_data(files["morphed"], "distance_mm")
    write_figure(morph(shapes, distance, read_table(files["history"]), x_mm=x, z_mm=z), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(dict(snakemake.input.items()), snakemake.output[0])
