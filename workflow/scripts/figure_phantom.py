"""Slices through the voxels of one compressed breast."""

import _stage

from mammosim.figures.radiograph import phantom_slices
from mammosim.io.figures import write_figure
from mammosim.io.images import read_labels


def main(labels: str, out: str) -> None:
    write_figure(phantom_slices(read_labels(labels)), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.input.labels, snakemake.output[0])
