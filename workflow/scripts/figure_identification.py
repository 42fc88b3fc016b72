"""The search by hand, the way of the fit, and the moduli with their intervals."""

import _stage

from mammosim.figures.identification import identification
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(files: dict[str, str], prior: dict, out: str) -> None:
    grid, history, moduli = (read_table(files[name]) for name in ("grid", "history", "moduli"))
    write_figure(identification(grid, history, moduli, prior), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(dict(snakemake.input.items()), snakemake.params.prior, snakemake.output[0])
