"""The report: sections.yaml says which figures and tables stand where; numbers come from the results."""

from pathlib import Path

import _log
import pandas as pd
import yaml

from mammosim.core.settings import read
from mammosim.figures.status import time_and_memory
from mammosim.io.atomic import replacing
from mammosim.io.figures import png_of
from mammosim.io.tables import read_json, read_rows, read_table
from mammosim.io.tabulated import tabulated
from mammosim.study.jobs.completeness import completeness_sentence
from mammosim.study.report.answer_words import short_table
from mammosim.study.report.layout import Contents, Layout, sections
from mammosim.study.report.pages import Listing, Section, report
from mammosim.study.report.questions import Questions
from mammosim.study.report.summary import entries


def main(files: dict, title: str, out: str) -> None:
    layout = layout_of(files["text"])
    pages = {Path(path).stem: layout_of(path) for path in files["page_texts"]}
    of_pages = {kind: [p for p in files["pages"] if p.endswith(kind)] for kind in (".csv", ".png", ".json")}
    numbers = read_json(files["numbers"])
    for path in of_pages[".json"]:
        numbers |= read_json(path)
    pictures = {Path(path).stem: Path(path).read_bytes() for path in files["pictures"] + of_pages[".png"]}
    pictures["cost"] = png_of(time_and_memory(benchmarks(Path("results/benchmarks"))))
    frames, made = tables(files, of_pages[".csv"]), [Path(path).stem for path in of_pages[".json"]]
    told = {"pages": pages, "made": made, "lacking": snakemake.params.lacking}
    asked = read(
        Questions, yaml.safe_load(Path(files["questions"]).read_text()), Path(files["questions"]).name
    )
    frames["questions"] = asked.table(
        sections(layout, Contents({}, {}), **told), {p: pages[p].title for p in pages}, made
    )
    if len(frames["answer_strategies"]):
        frames["answer_short"] = short_table(frames["answer_strategies"])
    shown = sections(layout, Contents(pictures, frames), **told)
    first = completeness(
        read_rows(files["missing"]), read_rows(files["not_planned"]), snakemake.params.volunteers
    )
    shown = (shown[0], first, *shown[1:])
    with replacing(out) as temporary:
        temporary.write_text(report(title, shown, numbers=numbers, subtitle=layout.subtitle))


def layout_of(file: str) -> Layout:
    """The layout that a file of workflow/report describes."""
    return read(Layout, yaml.safe_load(Path(file).read_text()), Path(file).name)


def completeness(missing: pd.DataFrame, not_planned: pd.DataFrame, volunteers: list[str]) -> Section:
    """What is missing and why, what the data of a volunteer do not allow, and the page of each."""
    pages = ", ".join(f"[{v}](../women/{v}/what.html)" for v in volunteers)
    listings = [
        Listing(missing, "What is missing, and which tables and figures lack it."),
        Listing(not_planned, "What was not planned, since the data of a volunteer do not allow it."),
    ]
    return Section(
        "What is missing",
        f"{completeness_sentence(missing)}\n\nWhat was done for each volunteer: {pages}.",
        tuple(each for each in listings if not each.frame.empty),
    )


def tables(files: dict, of_pages: list[str]) -> dict[str, pd.DataFrame]:
    """Every table by name: those of the study, of its pages, and of what made them."""
    frames = {Path(path).stem: read_rows(path) for path in files["tables"] + of_pages}
    made = read_json(files["provenance"])
    frames["quality"] = read_table(files["quality"])
    frames["assumptions"] = pd.DataFrame(made["assumptions"])
    frames["versions"] = pd.DataFrame(made["packages"].items(), columns=["package", "version"])
    frames["sources"] = pd.DataFrame(entries(Path(files["bibliography"]).read_text()))
    frames["published"] = tabulated("published_biomechanics")
    return frames


def benchmarks(folder: Path) -> pd.DataFrame:
    """What Snakemake measured of every job so far."""
    parts = [pd.read_table(path).assign(rule=path.parent.name) for path in sorted(folder.glob("*/*.tsv"))]
    return pd.concat(parts, ignore_index=True)


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        dict(snakemake.input.items()),
        f"mammosim: {', '.join(snakemake.params.volunteers)}",
        snakemake.output[0],
    )
