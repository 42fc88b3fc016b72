"""A figure that a rule draws is asked for by a page, whose text has its caption (docs/extend.md)."""

import re

import pytest

PLACE = re.compile(r"\{\w+\}")


@pytest.fixture
def drawn(repository) -> list[str]:
    """Names of figures in the tables DRAWN and PICTURED, with {} for every wildcard."""
    text = (repository / "workflow/rules/drawn.smk").read_text()
    names = re.findall(r'^    "([\w{}]+)": \(["\n]', text, re.M)
    return [PLACE.sub("{}", name) for name in names]


def test_every_figure_is_asked_for_by_a_page(repository, drawn):
    rules = [path for path in (repository / "workflow/rules").glob("*.smk") if path.name != "drawn.smk"]
    asked = PLACE.sub("{}", "".join(path.read_text() for path in rules))
    assert len(drawn) > 30
    assert [name for name in drawn if f'"{name}"' not in asked] == []


def test_every_figure_has_a_caption(repository, drawn):
    texts = "".join(path.read_text() for path in (repository / "workflow/report").glob("*.yaml"))
    captions = set(re.findall(r"^ +(\w+): ", texts, re.M))
    assert [name for name in drawn if name.replace("_{}", "") not in captions] == []
