"""Largest memory of the job of every value of every knob."""

import _log

from mammosim.figures.accuracy import memory
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(table: str, out: str) -> None:
    write_figure(memory(read_table(table)), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.table, snakemake.output[0])
