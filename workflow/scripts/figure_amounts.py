"""How much tissue and skin lies above the marks of every measure, by every strategy."""

import _stage

from mammosim.core.errors import MissingResult
from mammosim.figures.strategies import amounts
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(table: str, out: str) -> None:
    rows = read_table(table)
    if rows.empty:
        raise MissingResult("no strategy pressed any breast; the table of compressions says why")
    write_figure(amounts(rows), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.input.table, snakemake.output[0])
