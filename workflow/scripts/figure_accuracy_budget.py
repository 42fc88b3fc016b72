"""The error of the whole chain at today's settings, knob by knob, and the best next step."""

import _log

from mammosim.figures.accuracy import budget
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(table: str, out: str) -> None:
    write_figure(budget(read_table(table)), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.table, snakemake.output[0])
