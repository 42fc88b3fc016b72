"""The measured shape and its stress-free estimates, with the truth where a scoring rule gives it."""

from contextlib import suppress

import _stage

from mammosim.core.errors import MissingResult
from mammosim.core.mesh import TetMesh
from mammosim.figures.deformation import stress_free
from mammosim.io.fiducials import read_fiducials
from mammosim.io.figures import write_figure
from mammosim.io.meshes import read_mesh
from mammosim.io.transforms import read_transform


def true_shape(mesh: str, motion: str) -> TetMesh:
    """The true stress-free shape in the reference frame."""
    truth = read_mesh(mesh)
    return truth.moved_to(read_transform(motion)(truth.points))


def main(shapes: dict[str, TetMesh], fiducials: str, out: str) -> None:
    x, _, z = read_fiducials(fiducials).point("nipple_left")
    write_figure(stress_free(shapes, x_mm=x, z_mm=z), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        found = {"measured": read_mesh(snakemake.input.measured)}
        for method, path in zip(snakemake.params.methods, snakemake.input.shapes):
            with suppress(MissingResult):  # the table of methods says why
                found[method.replace("_", " ")] = read_mesh(path)
        if snakemake.input.get("truth"):
            found["truth"] = true_shape(snakemake.input.truth, snakemake.input.motion)
        main(found, snakemake.input.fiducials, snakemake.output[0])
