"""All breasts with other moduli, and the numbers that the page quotes."""

import _log
import pandas as pd

from mammosim.io.tables import read_table, write_numbers, write_table
from mammosim.study.identification.softening import numbers


def main(rows: list[str], table: str, facts: str) -> None:
    found = pd.concat([read_table(path) for path in rows], ignore_index=True)
    write_table(found, table)
    write_numbers(numbers(found), facts)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.rows, snakemake.output.table, snakemake.output.numbers)
