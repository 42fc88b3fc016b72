"""The report: sections.yaml says which figures and tables stand where; numbers come from the results."""

from pathlib import Path

import _benchmarks
import _log
import _pages
import _strict_yaml
import pandas as pd

from mammosim.core.settings import read
from mammosim.figures.status import time_and_memory
from mammosim.io.atomic import replacing
from mammosim.io.figures import write_figure
from mammosim.io.tables import read_json, read_rows, read_table
from mammosim.io.tabulated import tabulated
from mammosim.study.jobs.completeness import completeness_sentence
from mammosim.study.report.answer_words import short_table
from mammosim.study.report.layout import Contents, sections, titles
from mammosim.study.report.pages import Listing, Section, report
from mammosim.study.report.questions import Questions

LINKS = (
    ("Bodies in 3D", "view.html"),
    ("Tables and figures: this folder", "."),
    ("Versions, settings and assumptions", "provenance.json"),
)


def main(files: dict, title: str, out: dict[str, str]) -> None:
    listed, sources = _pages.bibliography(files["bibliography"])
    layout = _pages.layout_of(files["text"], sources)
    pages = {Path(path).stem: _pages.layout_of(path, sources) for path in files["page_texts"]}
    of_pages = {kind: [p for p in files["pages"] if p.endswith(kind)] for kind in (".csv", ".png", ".json")}
    numbers = read_json(files["numbers"])
    for path in of_pages[".json"]:
        numbers |= read_json(path)
    jobs = _benchmarks.benchmarks(Path("results/benchmarks"))
    write_figure(time_and_memory(jobs), out["cost"])
    csv = [*files["tables"], *of_pages[".csv"]]
    frames, made = tables(files, csv) | {"sources": listed}, [Path(path).stem for path in of_pages[".json"]]
    told = {"pages": pages, "made": made, "lacking": snakemake.params.lacking}
    asked = read(Questions, _strict_yaml.read(files["questions"], "questions.yaml"), "questions.yaml")
    whole = titles(layout, pages.values())
    frames["questions"] = asked.table(
        sections(layout, Contents({}, {}), **told), {p: pages[p].title for p in pages}, made, whole
    )
    if len(frames["answer_strategies"]):
        frames["answer_short"] = short_table(frames["answer_strategies"])
    contents = Contents(
        _pages.beside([*files["pictures"], *of_pages[".png"], out["cost"]], out["page"]),
        frames,
        _pages.csv_beside(csv, out["page"]) | {"quality": "../checked/all.csv"},
        {"sources": "key"},
    )
    shown = sections(layout, contents, **told)
    first = completeness(
        read_rows(files["missing"]), read_rows(files["not_planned"]), snakemake.params.volunteers
    )
    page = report(
        title,
        (shown[0], first, *shown[1:]),
        numbers=numbers,
        subtitle=layout.subtitle,
        footer=_pages.footer(files["provenance"], jobs),
        sources=sources,
        links=LINKS,
        scripts="scripts",
    )
    with replacing(out["page"]) as temporary:
        temporary.write_text(page, encoding="utf-8")


def completeness(missing: pd.DataFrame, not_planned: pd.DataFrame, volunteers: list[str]) -> Section:
    """What is missing and why, what the data of a volunteer do not allow, and the page of each."""
    pages = ", ".join(f"[{v}](../women/{v}/what.html)" for v in volunteers)
    listings = [
        Listing(missing, "What is missing, and which tables and figures lack it.", "missing.csv"),
        Listing(
            not_planned,
            "What was not planned, since the data of a volunteer do not allow it.",
            "not_planned.csv",
        ),
    ]
    return Section(
        "What is missing",
        f"{completeness_sentence(missing)}\n\nWhat was done for each volunteer: {pages}.",
        tuple(each for each in listings if not each.frame.empty),
    )


def tables(files: dict, paths: list[str]) -> dict[str, pd.DataFrame]:
    """Every table by name: those of the study, of its pages, and of what made them."""
    frames = {Path(path).stem: read_rows(path) for path in paths}
    made = read_json(files["provenance"])
    frames["quality"] = read_table(files["quality"])
    frames["assumptions"] = pd.DataFrame(made["assumptions"])
    frames["versions"] = pd.DataFrame(made["packages"].items(), columns=["package", "version"])
    frames["published"] = tabulated("published_biomechanics")
    return frames


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    main(
        dict(snakemake.input.items()),
        f"mammosim: {', '.join(snakemake.params.volunteers)}",
        {name: str(path) for name, path in snakemake.output.items()},
    )
