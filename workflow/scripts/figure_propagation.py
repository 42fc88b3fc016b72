"""What the interval of the moduli means for nipple, force and dose."""

import _stage

from mammosim.figures.propagation import propagation
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table


def main(table: str, out: str) -> None:
    write_figure(propagation(read_table(table)), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.input.table, snakemake.output[0])
