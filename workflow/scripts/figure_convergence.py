"""The residual of every method that iterates towards the stress-free shape."""

import _stage

from mammosim.figures.deformation import convergence
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(table: str, tolerance_mm: float, out: str) -> None:
    write_figure(convergence(read_table(table), tolerance_mm=tolerance_mm), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.input.table, snakemake.params.tolerance_mm, snakemake.output[0])
