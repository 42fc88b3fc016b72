"""Overlap of each tissue with the truth."""

import _stage

from mammosim.imaging.overlap import dice
from mammosim.io.tables import write_table
from mammosim.io.written import read_labels


def main(labels: str, truth: str, volunteer: str, position: str, out: str) -> None:
    table = dice(read_labels(labels), read_labels(truth))
    table.insert(0, "volunteer", volunteer)
    table.insert(1, "position", position)
    write_table(table, out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(
            snakemake.input.labels,
            snakemake.input.truth,
            snakemake.wildcards.w,
            snakemake.wildcards.p,
            snakemake.output[0],
        )
