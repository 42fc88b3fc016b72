"""The residual of every method that iterates towards the stress-free shape."""

import _stage

from mammosim.core.errors import MissingResult
from mammosim.figures.deformation import convergence
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(table: str, tolerance_mm: float, out: str) -> None:
    rows = read_table(table)
    if rows.max_mm.isna().all():
        raise MissingResult("no method that iterates found a stress-free shape; their table says why")
    write_figure(convergence(rows, tolerance_mm=tolerance_mm), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.input.table, snakemake.params.tolerance_mm, snakemake.output[0])
