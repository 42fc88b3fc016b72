"""The page of one result that is made on demand, laid out by a file of sections of its own."""

from pathlib import Path

import _log
import yaml

from mammosim.core.settings import read
from mammosim.io.atomic import replacing
from mammosim.io.tables import read_json, read_rows
from mammosim.study.report.layout import Contents, Layout, sections
from mammosim.study.report.pages import report


def main(files: dict, target: str, out: str) -> None:
    layout = read(Layout, yaml.safe_load(Path(files["text"]).read_text()), files["text"])
    contents = Contents(
        {Path(path).stem: Path(path).read_bytes() for path in files["pictures"]},
        {Path(path).stem: read_rows(path) for path in files["tables"]},
    )
    page = report(
        f"mammosim: {layout.title.lower()}",
        sections(layout, contents),
        numbers=read_json(files["numbers"]),
        subtitle=layout.subtitle,
        footer=f"made by snakemake {target}",
    )
    with replacing(out) as temporary:
        temporary.write_text(page)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(dict(snakemake.input.items()), snakemake.rule, snakemake.output[0])
