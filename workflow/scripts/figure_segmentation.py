"""Tissues over the image of one position, with their overlap with the truth where that is known."""

import _stage
import numpy as np

from mammosim.figures.volunteers import segmentation
from mammosim.io.fiducials import read_fiducials
from mammosim.io.figures import write_figure
from mammosim.io.images import read_image, read_labels
from mammosim.io.tables import read_table


def main(files: dict[str, str], dice: list[str], behind_mm: float, out: str) -> None:
    point = read_fiducials(files["fiducials"]).point("nipple_left") + np.array([0.0, behind_mm, 0.0])
    overlap = read_table(dice[0]) if dice else None
    figure = segmentation(read_image(files["image"]), read_labels(files["labels"]), overlap, point=point)
    write_figure(figure, out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        inputs = {name: snakemake.input[name] for name in ("image", "labels", "fiducials")}
        main(inputs, list(snakemake.input.dice), snakemake.params.behind_mm, snakemake.output[0])
