"""The ways to the stress-free shape, compared on digital volunteers."""

import _stage

from mammosim.figures.unloading import unloading
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(table: str, out: str) -> None:
    write_figure(unloading(read_table(table)), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.input.table, snakemake.output[0])
