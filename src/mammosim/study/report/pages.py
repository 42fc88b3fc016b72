"""The report: sections with pictures and tables, rendered as one HTML page that needs nothing else."""

import base64
import re
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources

import pandas as pd
from jinja2 import Environment, StrictUndefined
from markupsafe import Markup, escape

from mammosim.core.errors import ConfigurationError
from mammosim.study.report.summary import Numbers

# How the end of a column's name reads as a unit.
UNITS: Mapping[str, str] = {
    "mm": "mm", "mm2": "mm²", "mm3": "mm³", "kpa": "kPa", "n": "N", "mn": "mN", "uj": "µJ", "g": "g",
    "mgy": "mGy", "ugy": "µGy", "mas": "mAs", "kev": "keV", "deg": "°", "percent": "%", "s": "s", "mb": "MB",
    "mj": "mJ", "ev": "eV",
}  # fmt: skip
NUMBER = re.compile(r"\{([a-zA-Z][^{}:]*)(?::([^{}]+))?\}")
LINK = re.compile(r"\[([^\]]+)\]\((#[a-z0-9-]+|[a-z0-9_]+\.html)\)")
SENTENCE = re.compile(r"(?<=[.:?])(\s+)(?=[A-Z*])")
MEDIA = {"png": "image/png", "svg": "image/svg+xml"}


@dataclass(frozen=True)
class Picture:
    """A figure: the bytes of its file, 'png' or 'svg', and a caption."""

    data: bytes
    caption: str
    kind: str = "png"

    @property
    def source(self) -> str:
        """The picture as a data URI."""
        return f"data:{MEDIA[self.kind]};base64,{base64.b64encode(self.data).decode()}"


@dataclass(frozen=True)
class Listing:
    """A table with a caption; units are read off the column names."""

    frame: pd.DataFrame
    caption: str

    @property
    def headings(self) -> list[str]:
        """Column names in words, with units."""
        return [heading(str(column)) for column in self.frame.columns]

    @property
    def rows(self) -> list[list[str]]:
        """Cells as text: numbers to four significant digits, a dash where there is none."""
        return [[cell(value) for value in row] for row in self.frame.itertuples(index=False)]

    @property
    def numeric(self) -> list[bool]:
        """Which columns hold numbers."""
        return [pd.api.types.is_numeric_dtype(self.frame[column]) for column in self.frame.columns]


@dataclass(frozen=True)
class Section:
    """A title, paragraphs of text separated by blank lines, and pictures and tables below.

    In the text, {name} or {name:.1f} stands for a number of numbers.json; `x` is code, **x** is bold, and
    [x](path) a link.
    """

    title: str
    text: str = ""
    blocks: tuple[Picture | Listing, ...] = ()

    @property
    def anchor(self) -> str:
        """Where the table of contents points to."""
        return re.sub(r"[^a-z0-9]+", "-", self.title.lower()).strip("-")


def report(
    title: str,
    sections: tuple[Section, ...],
    *,
    numbers: Numbers,
    subtitle: str = "",
    footer: str = "",
) -> str:
    """The page. Raises ConfigurationError when a text names a number that the results do not have."""
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    page = environment.from_string(template("report.html.j2"))
    figures, tables = _numbered(sections, Picture), _numbered(sections, Listing)
    return page.render(
        title=title,
        subtitle=subtitle,
        footer=footer,
        sections=[(section, paragraphs(quoted(section.text, numbers))) for section in sections],
        number_of=lambda block: figures.get(id(block)) or tables.get(id(block)),
        is_picture=lambda block: isinstance(block, Picture),
    )


def template(name: str) -> str:
    """The text of a template of this package."""
    return resources.files("mammosim.study.report").joinpath("templates", name).read_text(encoding="utf-8")


def _numbered(sections: tuple[Section, ...], kind: type) -> dict[int, int]:
    blocks = [block for section in sections for block in section.blocks if isinstance(block, kind)]
    return {id(block): number for number, block in enumerate(blocks, start=1)}


def quoted(text: str, numbers: Numbers) -> str:
    """The text with each {name:format} replaced by that number, or by a dash where there is none.

    A sentence all of whose numbers are None is left out.
    """

    def value(match: re.Match[str]) -> str:
        name, shape = match[1], match[2] or ""
        if name not in numbers:
            near = [known for known in numbers if known.split(".")[0] == name.split(".")[0]]
            raise ConfigurationError(
                f"the report quotes {name!r}, which the results do not have; there are: {', '.join(near[:8])}"
            )
        number = numbers[name]
        return "–" if number is None else format(number, shape)

    def told(sentence: str) -> bool:
        names = [match[1] for match in NUMBER.finditer(sentence)]
        return not names or any(numbers.get(name, 0) is not None for name in names)

    return NUMBER.sub(value, "".join(part for part in SENTENCE.split(text) if told(part)))


def paragraphs(text: str) -> list[Markup]:
    """Paragraphs of HTML from plain text with `code`, **bold** and [words](path)."""
    found = []
    for part in re.split(r"\n\s*\n", text.strip()):
        html = str(escape(" ".join(part.split())))
        html = re.sub(r"`([^`]+)`", r"<code>\1</code>", html)
        html = re.sub(r"\[([^\]]+)\]\(([^()\s]+)\)", r'<a href="\2">\1</a>', html)
        found.append(Markup(re.sub(r"\*\*([^*]+)\*\*", r"<strong>\1</strong>", html)))
    return [part for part in found if part]


def heading(column: str) -> str:
    """'nipple_left_mm' as 'nipple left (mm)'."""
    name, unit = _unit(column.split("_"))
    return f"{' '.join(name)} ({unit})" if name and unit else " ".join(name) or unit


def _unit(words: list[str]) -> tuple[list[str], str]:
    """The words of a name without those of its unit, and this: a unit, one `per` another, or mm of Al."""
    if len(words) > 2 and words[-2] == "per" and {words[-3], words[-1]} <= UNITS.keys():
        return words[:-3], f"{UNITS[words[-3]]}/{UNITS[words[-1]]}"
    if words[-2:] == ["mm", "al"]:
        return words[:-2], "mm Al"
    return (words[:-1], UNITS[words[-1]]) if len(words) > 1 and words[-1] in UNITS else (words, "")


def cell(value: object) -> str:
    """A value of a table as text; one that is all [words](#anchor) or [words](page.html) as a link."""
    if pd.isna(value):
        return "–"
    if isinstance(value, str) and (link := LINK.fullmatch(value)):
        return Markup('<a href="{}">{}</a>').format(link[2], link[1])
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.4g}"
    return str(value)
