"""A page that is made on demand: its figures and tables lie beside it, and it lists what it cites."""

import json
import re

import pytest

from mammosim.core.errors import ConfigurationError

LAYOUT = """
title: Cases
subtitle: Which cases.
sections:
  - title: Every case
    text: "{cases.total:d} cases, as [@KEY]."
    figures: {cases: "All of them."}
    tables: {cases: {caption: "Every case."}}
"""
BIBLIOGRAPHY = """@book{carter2009,
  author = {Carter, Timothy},
  title = {Modelling},
  year = {2009}
}
@book{eiben2014,
  author = {Eiben, Bj{\\"o}rn},
  title = {Unloading},
  year = {2014}
}
"""


@pytest.fixture
def made(script, tmp_path):
    """made(key): the text of the page that cites a key."""
    study = tmp_path / "results/study"
    (study / "figures").mkdir(parents=True)
    (study / "figures/cases.png").write_bytes(b"\x89PNG")
    (study / "figures/cases.pdf").write_bytes(b"%PDF")
    (study / "cases.csv").write_text("case,force_n\na,1.5\n")
    (study / "cases.json").write_text(json.dumps({"cases.total": 3}))
    (tmp_path / "references.bib").write_text(BIBLIOGRAPHY)

    def page(key: str, layout: str = LAYOUT) -> str:
        (tmp_path / "cases.yaml").write_text(layout.replace("KEY", key))
        files = {
            **{"text": str(tmp_path / "cases.yaml"), "numbers": str(study / "cases.json")},
            **{"tables": [str(study / "cases.csv")], "pictures": [str(study / "figures/cases.png")]},
            **{"bibliography": str(tmp_path / "references.bib"), "scripts": []},
        }
        script("page").main(files, "cases", str(study / "cases.html"))
        return (study / "cases.html").read_text(encoding="utf-8")

    return page


def test_files_are_named_from_the_page_and_what_is_cited_is_listed(made):
    page = made("eiben2014")
    named = set(re.findall(r'(?:src|href)="([^"#]+)"', page))
    assert {"figures/cases.png", "figures/cases.pdf", "cases.csv"} <= named
    assert 'id="source-eiben2014"' in page
    assert "Eiben, Björn" in page
    assert "carter2009" not in page
    assert "snakemake cases" in page


def test_a_key_that_is_not_in_the_bibliography_is_named_with_the_file(made):
    with pytest.raises(ConfigurationError, match=r"cases\.yaml cites \[@carter2010\].*carter2009"):
        made("carter2010")


@pytest.mark.parametrize(
    ("layout", "words"),
    [
        ("", r"cases\.yaml = None has no keys"),
        (
            "title: A\ntitle: B\nsections: []\n",
            r"cases\.yaml, line 2: 'title' is given twice, in lines 1 and 2",
        ),
        ("title: A\nsections:\n\t- {title: B}\n", r"cases\.yaml, line 3: a tab; indent by blanks"),
        (
            "title: A\nsections: []\ncolour: red\n",
            r"cases\.yaml has no key 'colour'; choose one of: sections",
        ),
        ("title: A\nsections: [{title: B, page: c}]\n", r"cases\.yaml\.sections\[0\]: a section has either"),
    ],
)
def test_a_layout_that_cannot_be_meant_is_rejected_in_one_line(made, layout, words):
    with pytest.raises(ConfigurationError, match=words) as caught:
        made("eiben2014", layout)
    assert "\n" not in str(caught.value)


def test_a_layout_of_another_system_is_read(made):
    assert made("eiben2014", "\ufeff" + LAYOUT.replace("\n", "\r\n")).count("<table") == 2
