"""The moduli of all virtual patients, how often each was found, and the numbers that the page quotes."""

import _log
import pandas as pd

from mammosim.io.missing import missing_rows
from mammosim.io.tables import read_rows, read_those_there, write_numbers, write_table
from mammosim.study.identification.scores import by_tissue, numbers

COLUMNS = ["seed", "side", "tissue", "true_kpa", "fitted_kpa", "low_kpa", "high_kpa", "inside_95", "seconds"]


def main(rows: list[str], table: str, tissues: str, facts: str) -> None:
    moduli = read_those_there(rows)
    every = pd.concat([read_rows(path) for path in rows], ignore_index=True)
    gone = every[missing_rows(every)]
    reasons = ["volunteer", "outcome"] if len(gone) else []
    write_table(pd.concat([moduli, gone]).reindex(columns=[*COLUMNS, "identifiable", *reasons]), table)
    write_table(by_tissue(moduli), tissues)
    write_numbers(numbers(moduli), facts)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    out = snakemake.output
    main(snakemake.input.rows, out.table, out.tissues, out.numbers)
