"""How `make docs` builds the site: these pages and READMEs as they are, formulas as MathML, no network."""

import re
import sys
from pathlib import Path
from typing import Any

from latex2mathml.converter import convert

HOME = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(HOME / "src"), str(HOME / "docs")]

from generated import GENERATED, cited  # noqa: E402

project = "mammosim"
author = copyright = "The mammosim authors"
extensions = ["myst_parser"]
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
root_doc = "docs/index"
include_patterns = [
    "README.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "config/README.md",
    "workflow/*/README.md",
    "docs/**.md",
]
exclude_patterns = [".*", "results", "smoke", "robust", "site", "src", "tests", "tools", "mine", "real"]
html_theme = "furo"
html_title = "mammosim"
html_math_renderer = "mathml"
html_copy_source = False
html_static_path = ["static"]
html_css_files = ["site.css"]
templates_path: list[str] = []


def write_formula(translator: Any, node: Any, *, display: str) -> None:
    """A formula as MathML, which browsers draw without a script."""
    from docutils.nodes import SkipNode

    translator.body.append(convert(node.astext(), display=display))
    raise SkipNode


def prepare(app: Any, name: str, source: list[str]) -> None:
    """Citations, in brackets or bare, become links; what stands in the code is written into its page."""
    for mark, text in GENERATED.items():
        if mark in source[0]:
            source[0] = source[0].replace(mark, text(HOME))
    source[0] = re.sub(r"(?<!`)\[((?:;? ?@\w+)+)\]", lambda found: f"({cited(HOME, found[1])})", source[0])
    source[0] = re.sub(r"(?<= )@[a-z]+[12]\d{3}\b", lambda found: cited(HOME, found[0]), source[0])


def setup(app: Any) -> None:
    """Called by Sphinx."""
    app.connect("source-read", prepare)
    app.add_html_math_renderer(
        "mathml",
        (lambda t, node: write_formula(t, node, display="inline"), None),
        (lambda t, node: write_formula(t, node, display="block"), None),
    )
