"""The page of one result that is made on demand, laid out by a file of sections of its own."""

from pathlib import Path

import _log
import _pages

from mammosim.io.atomic import replacing
from mammosim.io.tables import read_json, read_rows
from mammosim.study.report.layout import Contents, sections, sources_section
from mammosim.study.report.pages import report


def main(files: dict, target: str, out: str) -> None:
    listed, sources = _pages.bibliography(files["bibliography"])
    layout = _pages.layout_of(files["text"], sources)
    contents = Contents(
        _pages.beside(files["pictures"], out),
        {Path(path).stem: read_rows(path) for path in files["tables"]},
        _pages.csv_beside(files["tables"], out),
    )
    shown = sections(layout, contents)
    page = report(
        f"mammosim: {layout.title.lower()}",
        (*shown, *sources_section(shown, listed)),
        numbers=read_json(files["numbers"]),
        subtitle=layout.subtitle,
        footer=_pages.made_by(f"snakemake {target}"),
        sources=sources,
        scripts="scripts",
    )
    with replacing(out) as temporary:
        temporary.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(dict(snakemake.input.items()), snakemake.rule, snakemake.output[0])
