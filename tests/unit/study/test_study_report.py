import re

import numpy as np
import pandas as pd
import pytest

from mammosim.core.errors import ConfigurationError
from mammosim.study.report.pages import Listing, Picture, Section, cell, heading, paragraphs, quoted, report

NUMBERS = {"sweep.small.1.nipple_left_mm": 12.345, "sweep.small.0.5.nipple_left_mm": None}
TABLE = pd.DataFrame({"volunteer": ["small"], "nipple_left_mm": [12.345], "outcome": ["<failed>"]})


def page() -> str:
    sections = (
        Section("Summary", "The error is {sweep.small.1.nipple_left_mm:.1f} mm, **small**.\n\nSecond."),
        Section("The sweep", "", (Picture(b"\x89PNG", "Error."), Listing(TABLE, "Rows."))),
        Section("Again", "", (Picture(b"<svg/>", "More.", "svg"),)),
    )
    return report("Mammosim", sections, numbers=NUMBERS, subtitle="A study", footer="made here")


def test_the_page_is_whole_without_a_network():
    assert not re.findall(r'(?:src|href)="(?!data:|#)', page())
    assert "@import" not in page()
    assert "url(" not in page()


def test_every_section_is_in_the_table_of_contents():
    for anchor in ("summary", "the-sweep", "again"):
        assert f'href="#{anchor}"' in page()
        assert f'id="{anchor}"' in page()


def test_figures_and_tables_are_numbered_through():
    assert [*re.findall(r"<b>(Figure \d|Table \d)\.", page())] == ["Figure 1", "Table 1", "Figure 2"]


def test_texts_quote_numbers_of_the_results_in_the_asked_format():
    assert "The error is 12.3 mm, <strong>small</strong>." in page()
    both = "{sweep.small.1.nipple_left_mm:.1f} and {sweep.small.0.5.nipple_left_mm:.1f} mm"
    assert quoted(both, NUMBERS) == "12.3 and – mm"


def test_a_sentence_without_any_of_its_numbers_is_left_out():
    absent = "It is off by {sweep.small.0.5.nipple_left_mm:.1f} mm, e.g. there."
    assert quoted(f"One is known. {absent} Another one, too.", NUMBERS).split() == [
        "One",
        "is",
        "known.",
        "Another",
        "one,",
        "too.",
    ]
    assert len(paragraphs(quoted(f"First.\n\n{absent}\n\nLast.", NUMBERS))) == 2


def test_a_number_that_the_results_do_not_have_is_rejected():
    with pytest.raises(ConfigurationError, match=r"sweep\.large.*there are: sweep\.small"):
        quoted("{sweep.large.1.nipple_left_mm}", NUMBERS)


def test_text_cannot_break_the_page():
    assert "&lt;failed&gt;" in page()
    assert str(paragraphs("a < b `c`")[0]) == "a &lt; b <code>c</code>"


def test_headings_name_units_and_cells_have_four_digits():
    assert heading("nipple_left_mm") == "nipple left (mm)"
    assert heading("relative_change") == "relative change"
    assert heading("smallest_J") == "smallest J"
    assert heading("kerma_ugy_per_mas") == "kerma (µGy/mAs)"
    assert heading("mgy_per_mas") == "mGy/mAs"
    assert heading("hvl_behind_mm_al") == "hvl behind (mm Al)"
    assert heading("energy_mj") == "energy (mJ)"
    assert [cell(v) for v in (np.nan, 0.012345, 12345.6, True, 3)] == ["–", "0.01235", "12,346", "yes", "3"]


def test_a_page_is_the_same_every_time():
    assert page() == page()
