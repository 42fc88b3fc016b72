"""Our photon transport beside AAPM report 195, case 3."""

import _stage

from mammosim.figures.dose_routes import report195
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(table: str, out: str) -> None:
    write_figure(report195(read_table(table)), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.input.table, snakemake.output[0])
