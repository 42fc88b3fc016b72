"""What was done with one woman's data, and what could not be."""

from pathlib import Path

import _pages
import _stage
import pandas as pd

from mammosim.io.atomic import replacing
from mammosim.io.figures import missing_reason
from mammosim.io.tables import read_rows
from mammosim.study.jobs.completeness import missing_results
from mammosim.study.report.done import Done, done_sections
from mammosim.study.report.pages import report

KINDS = ("images", "labels", "strokes", "listed")


def main(volunteer: str, rows: list[dict], told: dict, pictures: list[str], out: str) -> None:
    tables = {
        name: pd.concat(map(read_rows, paths), ignore_index=True) for name, paths in told["tables"].items()
    }
    given = [
        {"position": row["position"]}
        | {kind: row["files"].get(kind, "") for kind in KINDS}
        | {**row["how"], "codes": row["codes"]["codes"]}
        for row in rows
    ]
    why = {path: missing_reason(path) for path in pictures}
    done = Done(
        volunteer,
        tables,
        pictures={Path(path).stem: Path(path).read_bytes() for path in pictures if why[path] is None},
        files=told["tables"],
        missing=missing_results(tables, {Path(path).stem: reason for path, reason in why.items()}),
        given=pd.DataFrame(given),
        modelled=told["modelled"],
        home=str(Path(out).parent),
    )
    sections = done_sections(done, told["planned"], told["gains"], thickness=told["thickness"])
    page = report(
        f"mammosim: {volunteer}",
        sections,
        numbers={},
        subtitle="What was done with her data, and what was not.",
        footer=_pages.made_by(f"snakemake results/women/{volunteer}/what.html"),
    )
    with replacing(out) as temporary:
        temporary.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    with _stage.run(snakemake):
        main(
            snakemake.wildcards.v,
            snakemake.params.rows,
            snakemake.params.told,
            list(snakemake.input.pictures),
            snakemake.output[0],
        )
