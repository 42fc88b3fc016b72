"""The page on which the bodies of all women are turned and cut."""

import _log
import _pages

from mammosim.figures.style import TISSUE_COLOURS
from mammosim.io.atomic import replacing
from mammosim.study.report.view import page


def main(volunteers: list[str], provenance: str, out: str) -> None:
    text = page(
        "mammosim: bodies in 3D", volunteers, colours=TISSUE_COLOURS, footer=_pages.footer(provenance)
    )
    with replacing(out) as temporary:
        temporary.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(snakemake.params.volunteers, snakemake.input.provenance, snakemake.output[0])
