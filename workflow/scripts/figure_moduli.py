"""Moduli in the literature and in this study, with the intervals of its fits."""

import _stage

from mammosim.figures.literature import moduli
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_table
from mammosim.io.tabulated import tabulated
from mammosim.study.identification.published import beside


def main(fitted: str, here: dict[str, tuple[float, float]], out: str) -> None:
    rows = beside(tabulated("published_biomechanics"), read_table(fitted))
    write_figure(moduli(rows, here), out)


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(snakemake.input.fitted, snakemake.params.here, snakemake.output[0])
