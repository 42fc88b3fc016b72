"""Error in one quantity against processor time of every knob, with the Pareto front and today's setting."""

import _log

from mammosim.figures.accuracy import accuracy
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(table: str, quantity: str, out: str) -> None:
    write_figure(accuracy(read_table(table), quantity), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.table, snakemake.wildcards.quantity, snakemake.output[0])
