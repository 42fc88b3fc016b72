"""All published models with their scores, and the numbers that the page quotes."""

import _log

from mammosim.io.tables import read_those_there, write_numbers, write_table
from mammosim.study.models.rows import numbers, table


def main(rows: list[str], scores: list[str], out: str, facts: str) -> None:
    found = table(read_those_there(rows), read_those_there(scores) if scores else None)
    write_table(found, out)
    write_numbers(numbers(found), facts)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.rows, snakemake.input.scores, snakemake.output.table, snakemake.output.numbers)
