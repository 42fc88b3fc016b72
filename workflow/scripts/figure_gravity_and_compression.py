"""Moduli fitted under gravity beside those used under compression."""

import _stage

from mammosim.figures.literature import gravity_and_compression
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table
from mammosim.io.tabulated import tabulated
from mammosim.study.identification.published import beside


def main(fitted: str, ratios: str, out: str) -> None:
    rows = beside(tabulated("published_biomechanics"), read_table(fitted))
    write_figure(gravity_and_compression(rows, read_table(ratios)), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.input.fitted, snakemake.input.ratios, snakemake.output[0])
