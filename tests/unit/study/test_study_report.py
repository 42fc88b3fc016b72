import json
import re
from io import BytesIO

import numpy as np
import pandas as pd
import pytest
from markupsafe import escape
from PIL import Image

from mammosim.core.errors import ConfigurationError
from mammosim.core.marks import literal
from mammosim.study.report.pages import (
    Listing,
    Picture,
    Section,
    alternative,
    cell,
    heading,
    report,
    size_words,
)
from mammosim.study.report.texts import paragraphs, quoted, words

NUMBERS = {"sweep.small.1.nipple_left_mm": 12.345, "sweep.small.0.5.nipple_left_mm": None}
TABLE = pd.DataFrame({"volunteer": ["small"], "nipple_left_mm": [12.345], "outcome": ["<failed>"]})


def page() -> str:
    sections = (
        Section("Summary", "The error is {sweep.small.1.nipple_left_mm:.1f} mm, **small**.\n\nSecond."),
        Section("The sweep", "", (Picture(b"\x89PNG", "Error."), Listing(TABLE, "Rows."))),
        Section("Again", "", (Picture(b"<svg/>", "More.", "svg"),)),
    )
    return report("Mammosim", sections, numbers=NUMBERS, subtitle="A study", footer={"Command": "made here"})


def test_the_page_is_whole_without_a_network():
    assert not re.findall(r'(?:src|href)="(?!data:|#)', page())
    assert "@import" not in page()
    assert "url(" not in page()


def test_a_figure_beside_the_page_is_referenced_with_its_size_in_print():
    data = BytesIO()
    Image.new("RGB", (300, 150)).save(data, "png", dpi=(150, 150))
    shown = Picture(data.getvalue(), "Error [@a1]. More.", path="figures/a.png", vector="figures/a.pdf")
    html = report("M", (Section("S", "", (shown,)),), numbers={}, sources={"a1": "Adams 2001"})
    (image,) = re.findall(r"<img src=[^>]*>", html)
    assert 'src="figures/a.png" alt="Error."' in image
    assert 'loading="lazy"' in image
    assert 'width="192" height="96"' in image  # 2 by 1 inches of 96 pixels
    assert 'href="figures/a.pdf"' in html
    assert "of figures behind the first screen" in html


def test_a_long_table_stands_on_the_page_in_its_first_rows_and_whole_for_its_script():
    rows = pd.DataFrame({"label": ["</script><img src=x onerror=alert(1)>"] * 5000, "force_n": range(5000)})
    section = Section("S", "", (Listing(rows, "All.", "rows.csv"),))
    html = report("M", (section,), numbers={}, scripts="scripts")
    assert html.count("<tr>") == 1 + 12
    assert "<img src=x" not in html
    (data,) = re.findall(r'<script type="application/json">(.*?)</script>', html, re.S)
    assert json.loads(data)[4999] == ["</script><img src=x onerror=alert(1)>", "4999"]
    assert 'href="rows.csv"' in html
    assert report("M", (section,), numbers={}).count("<tr>") == 1 + 5000, "without the scripts it is whole"


def test_citations_lead_to_the_entries_and_formulas_are_mathml():
    sources = {"a1": "Adams & Eve 2001", "b2": "Cain 2002"}
    assert str(words("Known [@a1; @b2].", sources)) == (
        'Known (<a href="#source-a1">Adams &amp; Eve 2001</a>; <a href="#source-b2">Cain 2002</a>).'
    )
    assert str(words("As in [@b2].", sources)) == 'As in <a href="#source-b2">Cain 2002</a>.'
    assert str(words("As [@a1].")) == "As [@a1]."
    with pytest.raises(ConfigurationError, match=r"\[@a2\] is not in the bibliography"):
        words("As [@a2].", sources)
    assert "<mfrac>" in words(r"$\frac{1}{2}$")
    listing = Listing(pd.DataFrame({"key": ["a1"], "title": ["T"]}), "Sources.", anchors="key")
    assert 'id="source-a1"' in report("M", (Section("S", "", (listing,)),), numbers={})


def test_a_formula_is_plain_mathml_and_keeps_its_braces():
    for latex, written in (
        (r"\href{javascript:alert(1)}{x}", "href"),
        (r"\text{<script>alert(1)</script>}", "script"),
    ):
        with pytest.raises(ConfigurationError, match=f"writes .*{written}"):
            words(f"${latex}$")
    assert (
        quoted(r"$\frac{mu}{2}$ is {sweep.small.1.nipple_left_mm:.0f}.", NUMBERS) == r"$\frac{mu}{2}$ is 12."
    )


@pytest.mark.parametrize(
    "written",
    [
        "costs $5, not $6",
        r"$\frac$ and \$5",
        "[x](javascript:window.ran=1)",
        "see [@nobody2000]",
        "**bold**, `code` and a * b",
        "{force} of {x:3}",
        "a\\b\\\\c",
        "two\n\nlines",
        "</script> \N{RIGHT-TO-LEFT OVERRIDE}e\N{COMBINING ACUTE ACCENT}",
    ],
)
def test_what_a_person_has_written_is_read_as_it_stands(written):
    shown = str(escape(" ".join(written.split())))
    assert str(words(literal(written), {})) == shown
    # The same as a part of a text, and as a number that a text quotes.
    assert str(words(quoted(f"Of **{literal(written)}**.", {}), {})) == f"Of <strong>{shown}</strong>."
    numbers = {"headline.answer": f"**Of** {literal(written)}"}
    assert str(paragraphs(quoted("{headline.answer}", numbers), {})[0]) == f"<strong>Of</strong> {shown}"


def test_every_section_is_in_the_table_of_contents():
    for anchor in ("summary", "the-sweep", "again"):
        assert f'href="#{anchor}"' in page()
        assert f'id="{anchor}"' in page()


def test_a_title_in_any_script_has_a_place_of_its_own():
    html = report("M", (Section("Ответ"), Section("Größe, mm")), numbers={})
    for anchor in ("ответ", "größe-mm"):
        assert f'href="#{anchor}"' in html
        assert f'id="{anchor}"' in html
    assert cell("[Ответ](#ответ)") == '<a href="#ответ">Ответ</a>'


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
    assert heading("hvl_mm_al") == "hvl (mm Al)"
    assert [cell(v) for v in (np.nan, 0.012345, 12345.6, True, 3)] == ["–", "0.01235", "12,346", "yes", "3"]


def test_a_page_says_what_it_weighs():
    assert [size_words(size) for size in (1_499, 999_400, 1e6, 2_350_000)] == [
        "1 kB",
        "999 kB",
        "1.0 MB",
        "2.4 MB",
    ]


def test_a_picture_that_is_not_seen_is_told_by_the_first_sentence_of_its_caption():
    caption = "Dose of **each** breast [@a1]; $x$ in `mm`. Bars: intervals. Dashed: the limit."
    assert alternative(Picture(b"", caption)) == "Dose of each breast;"


@pytest.mark.parametrize(
    ("rows", "anchors", "cells", "paged"),
    [
        (12, "", "plain", False),
        (13, "", "plain", True),
        (13, "name", "plain", False),
        (13, "", "[linked](#there)", False),
    ],
)
def test_a_long_table_is_paged_unless_a_text_or_a_cell_links(rows, anchors, cells, paged):
    listing = Listing(pd.DataFrame({"name": [cells] * rows}), "All.", anchors=anchors)
    assert listing.paged is paged


@pytest.mark.parametrize(("letters", "kind"), [(30, "label"), (31, ""), (60, ""), (61, "prose")])
def test_sentences_have_a_column_of_their_own_and_labels_one_line(letters, kind):
    assert Listing(pd.DataFrame({"why": ["short", "x" * letters]}), "Rows.").kinds == [kind]


def test_a_number_of_many_digits_is_short_and_truth_is_no_number():
    assert [cell(v) for v in (999_999_999.0, 1e9, -1e300, np.inf, -np.inf, np.True_)] == [
        "999,999,999",
        "1e+09",
        "-1e+300",
        "inf",
        "-inf",
        "yes",
    ]
    frame = pd.DataFrame({"level": [True, False], "dose_mgy": [1.0, 2.0], "strategy": ["a", "b"]})
    assert Listing(frame, "Rows.").kinds == ["label", "number", "label"]


def test_a_page_is_the_same_every_time():
    assert page() == page()
