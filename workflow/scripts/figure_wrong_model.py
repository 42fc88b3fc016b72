"""Errors of a woman whom the fit's model cannot describe, beside those of her twin."""

import _log

from mammosim.figures.validation import wrong_model
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(table: str, out: str) -> None:
    write_figure(wrong_model(read_table(table)), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.table, snakemake.output[0])
