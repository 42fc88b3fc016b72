"""Moduli in the literature and in this study."""

import _log

from mammosim.figures.literature import moduli
from mammosim.io.figures import write_figure
from mammosim.io.tabulated import tabulated


def main(here: dict[str, tuple[float, float]], out: str) -> None:
    write_figure(moduli(tabulated("published_biomechanics"), here), out)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.params.here, snakemake.output[0])
