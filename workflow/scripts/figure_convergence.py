"""The residual of the fixed point at every iteration."""

import _log

from mammosim.figures.deformation import convergence
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(table: str, tolerance_mm: float, out: str) -> None:
    rows = read_table(table)
    rows = rows[rows.method == "fixed_point"]
    histories = {str(volunteer): part for volunteer, part in rows.groupby("volunteer")}
    write_figure(convergence(histories, tolerance_mm=tolerance_mm), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.table, snakemake.params.tolerance_mm, snakemake.output[0])
