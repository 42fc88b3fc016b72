"""Force, area and pressure on the way of every strategy."""

import _stage

from mammosim.core.errors import MissingResult
from mammosim.figures.strategies import Marks, curves
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table
from mammosim.io.tabulated import tabulated


def main(table: str, out: str) -> None:
    rows = read_table(table)
    if rows.empty:
        raise MissingResult("no strategy pressed any breast; the table of compressions says why")
    practice = tabulated("published_mammography").set_index(["source", "quantity"])
    force = practice.loc["de Groot 2015", "force"]
    marks = Marks(
        force_n=(force.low, force.high),
        force_source="practice",
        pressure_kpa=practice.loc["de Groot 2015", "standardised pressure"]["mean"],
        pressure_source="10 kPa, de Groot",
    )
    write_figure(curves(rows, marks), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.input.table, snakemake.output[0])
