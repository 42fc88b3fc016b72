"""Every hard case as a line: expected and happened, error against its bound, seconds."""

import _log

from mammosim.figures.hard_cases import hard_cases
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(table: str, out: str) -> None:
    write_figure(hard_cases(read_table(table)), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.table, snakemake.output[0])
