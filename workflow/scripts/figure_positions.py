"""One volunteer as scanned, in every position."""

import _stage

from mammosim.core.positions import gravity_vector
from mammosim.figures.volunteers import positions
from mammosim.io.fiducials import read_fiducials
from mammosim.io.figures import write_figure
from mammosim.io.images import read_image


def main(images: list[str], fiducials: list[str], gravity: dict[str, str], out: str) -> None:
    figure = positions(
        dict(zip(gravity, map(read_image, images))),
        dict(zip(gravity, map(read_fiducials, fiducials))),
        {position: gravity_vector(text) for position, text in gravity.items()},
    )
    write_figure(figure, out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(
            snakemake.input.images,
            snakemake.input.fiducials,
            snakemake.params.gravity,
            snakemake.output[0],
        )
