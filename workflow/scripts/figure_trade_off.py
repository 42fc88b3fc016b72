"""Dose, exposure, scatter and contrast of every strategy against compressed thickness."""

import _stage

from mammosim.figures.trade_off import trade_off
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(table: str, out: str) -> None:
    write_figure(trade_off(read_table(table)), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.input.table, snakemake.output[0])
