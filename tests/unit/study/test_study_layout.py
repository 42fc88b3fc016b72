"""A layout becomes sections: what is there is shown, what is made on demand says how."""

from pathlib import Path

import pandas as pd
import pytest
import yaml

from mammosim.chain.allowed import QUESTIONS, REPORTED
from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import read
from mammosim.study.report.layout import Contents, Layout, require_sources, sources_section
from mammosim.study.report.layout import sections as sections_of
from mammosim.study.report.pages import Listing, Picture, Section

FOLDER = Path(__file__).parents[3] / "workflow/report"
CONTENTS = Contents(
    {name: Picture(name.encode(), "") for name in ("sweep", "mesh_large_prone", "mesher")},
    {"sweep": pd.DataFrame({"volunteer": ["small"], "nipple_mm": [1.0]})},
    csv={"sweep": "sweep.csv"},
)
CASES = {"title": "Cases", "sections": [{"title": "Every case", "text": "{cases.total}"}]}
PAGES = {"cases": read(Layout, CASES, "cases.yaml")}


def sections(parts, contents, **pages):
    return sections_of(read(Layout, {"sections": parts}, "sections.yaml"), contents, **pages)


def test_a_figure_is_shown_for_every_picture_that_begins_with_its_name():
    (only,) = sections([{"title": "Mesh", "figures": {"mesh": "Elements of {what}."}}], CONTENTS)
    assert only.blocks == (Picture(b"mesh_large_prone", "Elements of large prone."),)


def test_a_formula_in_a_caption_keeps_its_braces():
    (only,) = sections([{"title": "M", "figures": {"mesh": "$\\frac{a}{b}$ of {what}."}}], CONTENTS)
    assert only.blocks[0].caption == "$\\frac{a}{b}$ of large prone."


def test_what_is_cited_is_in_the_bibliography_or_the_file_is_named():
    layout = read(Layout, {"sections": [{"title": "Fit", "text": "As [@mira2018; @mirra2018]."}]}, "s.yaml")
    require_sources(layout, {"mira2018": "", "mirra2018": ""}, file="s.yaml")
    with pytest.raises(
        ConfigurationError, match=r"s\.yaml cites \[@mirra2018\] in 'Fit'.*choose of: mira2018"
    ):
        require_sources(layout, {"mira2018": "", "carter2009": ""}, file="s.yaml")


def test_a_page_by_itself_lists_what_it_cites_and_no_more():
    listed = pd.DataFrame({"key": ["a1", "b2"], "title": ["A", "B"]})
    (found,) = sources_section((Section("Fit", "As [@b2]."),), listed)
    assert found.blocks[0].rows == [["b2", "B"]]
    assert sources_section((Section("Fit", "As known."),), listed) == ()


def test_a_table_shows_the_columns_listed_and_is_left_out_where_it_is_absent():
    tables = {
        "sweep": {"caption": "Rows.", "columns": ["nipple_mm"]},
        "scores": {"caption": "Of digital ones."},
    }
    (only,) = sections([{"title": "Sweep", "tables": tables}], CONTENTS)
    (listing,) = only.blocks
    assert isinstance(listing, Listing)
    assert list(listing.frame) == ["nipple_mm"]
    assert listing.csv == "sweep.csv"


def test_a_page_stands_in_its_place_once_it_was_made():
    parts = [{"title": "First"}, {"page": "cases"}, {"title": "Last"}]
    shown = sections(parts, CONTENTS, pages=PAGES, made=["cases"])
    assert [part.title for part in shown] == ["First", "Every case", "Last"]


def test_a_page_not_made_yet_names_its_command():
    (only,) = sections([{"page": "cases"}], CONTENTS, pages=PAGES)
    assert only.title == "Cases"
    assert "`snakemake cases`" in only.text


def test_a_section_of_what_nobodys_data_allow_is_left_out():
    parts = [{"title": "First"}, {"title": "Fit", "needs": "fit"}, {"page": "cases", "needs": "fit"}]
    assert [part.title for part in sections(parts, CONTENTS, pages=PAGES)] == ["First", "Fit", "Cases"]
    assert [part.title for part in sections(parts, CONTENTS, pages=PAGES, lacking=["fit"])] == ["First"]


def test_every_section_needs_what_is_reported_where_it_cannot_be():
    """A word that nothing else knows would never leave a section out."""
    needed = {
        part.get("needs") for part in yaml.safe_load((FOLDER / "sections.yaml").read_text())["sections"]
    }
    assert needed <= {None, "truth", *REPORTED, *QUESTIONS}


def test_a_page_without_layout_is_rejected():
    with pytest.raises(ConfigurationError, match="'peers'; there are: cases"):
        sections([{"page": "peers"}], CONTENTS, pages=PAGES)


@pytest.mark.parametrize(
    ("part", "words"),
    [
        ({"titel": "Mesh"}, r"sections\.yaml\.sections\[1\] has no key 'titel'; did you mean 'title'"),
        ({"text": "Cells."}, r"sections\[1\]: a section has either a title or the name of a page"),
        (
            {"title": "Mesh", "page": "cases"},
            r"sections\[1\]: a section has either a title or the name of a page",
        ),
        ({"title": "Mesh", "tables": {"mesh": {"columns": ["cells"]}}}, r"\[1\]\.tables\.mesh lacks caption"),
        ({"title": "Mesh", "figures": {"mesh": "Of {who}."}}, r"\[1\]: figures\.mesh may name \{what\} only"),
        ("Mesh", r"sections\[1\] = 'Mesh' has no keys"),
    ],
)
def test_a_part_that_cannot_be_meant_is_rejected_with_its_file_and_section(part, words):
    with pytest.raises(ConfigurationError, match=words):
        sections([{"title": "First"}, part], CONTENTS)


@pytest.mark.parametrize("file", sorted(FOLDER.glob("*.yaml")), ids=lambda file: file.stem)
def test_every_layout_of_the_study_is_read(file):
    layout = read(Layout, yaml.safe_load(file.read_text()), file.name)
    assert len(layout.sections) >= 1
    assert layout.subtitle
