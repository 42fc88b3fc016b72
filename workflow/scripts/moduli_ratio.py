"""How much stiffer tissues are under compression than under gravity: a row per tissue that has both."""

import _log

from mammosim.io.tables import read_table, write_table
from mammosim.io.tabulated import tabulated
from mammosim.study.published import beside, ratios


def main(fitted: str, out: str) -> None:
    write_table(ratios(beside(tabulated("published_biomechanics"), read_table(fitted))), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.input.fitted, snakemake.output[0])
