"""Names that the pages list are those of the code."""

import re
from importlib import import_module, util

import pytest

from mammosim.io.label_codes import presets
from mammosim.study.campaigns.campaign import ASKED

DOTTED = re.compile(r"`((?:core|io|imaging|xray|chain|study|figures|mechanics)(?:\.\w+)+)`")
PATH = re.compile(r"`((?:config|docs|examples|tests|tools|workflow)/[\w/.]+)`")


def quoted(text: str, start: str, end: str) -> set[str]:
    """Words in backticks between two phrases."""
    return set(re.findall(r"`(\w+)`", text.split(start, 1)[1].split(end, 1)[0]))


def names_something(name: str) -> bool:
    """Whether it is a module of the package, or stands in one."""
    module, _, last = f"mammosim.{name}".rpartition(".")
    return util.find_spec(module) is not None and (
        hasattr(import_module(module), last) or util.find_spec(f"{module}.{last}") is not None
    )


def test_whatever_a_recipe_names_is_there(repository):
    text = (repository / "docs/extend.md").read_text()
    names = set(DOTTED.findall(text))
    assert len(names) > 20
    assert {name for name in names if not names_something(name)} == set()
    made = {"config/scenes/bending.yaml"}
    assert {path for path in set(PATH.findall(text)) - made if not (repository / path).exists()} == set()


def test_a_campaign_may_ask_what_its_page_lists(repository):
    text = (repository / "config/README.md").read_text()
    assert quoted(text, "- `asked`:", ". `strain`") == set(ASKED)


@pytest.mark.parametrize(
    ("page", "start", "end"),
    [
        ("config/README.md", "It names a preset", "or a file"),
        ("docs/data.md", "what its codes mean", "or a file"),
    ],
)
def test_the_pages_list_the_presets_of_codes(repository, page, start, end):
    """But for the program's own, and that of Duke, which are parts of other maps."""
    listed = quoted((repository / page).read_text(), start, end)
    assert listed == set(presets()) - {"mammosim", "duke"}
