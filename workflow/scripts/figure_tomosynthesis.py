"""Slices of one breast, and how far its lesion is seen above and below its own slice."""

import _stage
import numpy as np

from mammosim.core.labels import Label
from mammosim.figures.radiograph import tomosynthesis
from mammosim.io.figures import write_figure
from mammosim.io.images import read_image, read_labels
from mammosim.io.tables import read_table


def main(files: dict[str, str], side: str, out: str) -> None:
    labels = read_labels(files["phantom"])
    lesion = labels.grid.points(np.argwhere(labels.values == Label.LESION).astype(float)).mean(axis=0)
    slices = {name: read_image(files[name]) for name in ("filtered_backprojection", "sart")}
    write_figure(tomosynthesis(slices, read_table(files["profiles"]), lesion, side=side), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(dict(snakemake.input.items()), snakemake.wildcards.side, snakemake.output[0])
