"""How much tissue and skin lies above the marks of every measure, by every strategy."""

import _log

from mammosim.figures.strategies import amounts
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(table: str, out: str) -> None:
    write_figure(amounts(read_table(table)), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.table, snakemake.output[0])
