"""A layout becomes sections: what is there is shown, what is made on demand says how."""

import pandas as pd
import pytest

from mammosim.core.errors import ConfigurationError
from mammosim.study.report.layout import Contents, sections
from mammosim.study.report.pages import Listing, Picture

CONTENTS = Contents(
    {"sweep": b"s", "mesh_large_prone": b"m", "mesher": b"x"},
    {"sweep": pd.DataFrame({"volunteer": ["small"], "nipple_mm": [1.0]})},
)
PAGES = {"cases": {"title": "Cases", "sections": [{"title": "Every case", "text": "{cases.total}"}]}}


def test_a_figure_is_shown_for_every_picture_that_begins_with_its_name():
    (only,) = sections([{"title": "Mesh", "figures": {"mesh": "Elements of {what}."}}], CONTENTS)
    assert only.blocks == (Picture(b"m", "Elements of large prone."),)


def test_a_table_shows_the_columns_listed_and_is_left_out_where_it_is_absent():
    tables = {
        "sweep": {"caption": "Rows.", "columns": ["nipple_mm"]},
        "scores": {"caption": "Of digital ones."},
    }
    (only,) = sections([{"title": "Sweep", "tables": tables}], CONTENTS)
    (listing,) = only.blocks
    assert isinstance(listing, Listing)
    assert list(listing.frame) == ["nipple_mm"]


def test_a_page_stands_in_its_place_once_it_was_made():
    parts = [{"title": "First"}, {"page": "cases"}, {"title": "Last"}]
    shown = sections(parts, CONTENTS, pages=PAGES, made=["cases"])
    assert [part.title for part in shown] == ["First", "Every case", "Last"]


def test_a_page_not_made_yet_names_its_command():
    (only,) = sections([{"page": "cases"}], CONTENTS, pages=PAGES)
    assert only.title == "Cases"
    assert "`snakemake cases`" in only.text


def test_a_page_without_layout_is_refused():
    with pytest.raises(ConfigurationError, match="'peers'; there are: cases"):
        sections([{"page": "peers"}], CONTENTS, pages=PAGES)
