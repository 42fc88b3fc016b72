"""Nipple error and displacement against the modulus of the breast."""

import _stage

from mammosim.figures.deformation import sweep
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(table: str, out: str) -> None:
    write_figure(sweep(read_table(table)), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.input.table, snakemake.output[0])
