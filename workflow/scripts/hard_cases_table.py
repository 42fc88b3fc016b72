"""The table of all hard cases; unexpected outcomes are named in the log and on the terminal."""

import logging
import sys

import _log
import pandas as pd

from mammosim.io.tables import read_table, write_numbers, write_table
from mammosim.study.hard_cases.cases import numbers, unexpected


def main(rows: list[str], table: str, facts: str) -> None:
    cases = pd.concat([read_table(path) for path in rows], ignore_index=True)
    write_table(cases, table)
    write_numbers(numbers(cases), facts)
    logging.info("%d hard cases", len(cases))
    for line in unexpected(cases):
        logging.error(line)
        sys.stderr.write(f"{line}\n")


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.rows, snakemake.output.table, snakemake.output.numbers)
