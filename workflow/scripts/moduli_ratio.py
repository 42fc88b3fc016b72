"""How much stiffer tissues are under compression than under gravity: a row per tissue that has both."""

import _stage

from mammosim.io.tables import read_table, write_table
from mammosim.io.tabulated import tabulated
from mammosim.study.identification.published import beside, ratios


def main(fitted: str, out: str) -> None:
    write_table(ratios(beside(tabulated("published_biomechanics"), read_table(fitted))), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.input.fitted, snakemake.output[0])
