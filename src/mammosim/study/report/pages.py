"""A page: sections with pictures and tables as HTML that reads from a file, without a network."""

import base64
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib import resources
from io import BytesIO

import numpy as np
import pandas as pd
from jinja2 import Environment, StrictUndefined
from markupsafe import Markup
from PIL import Image, UnidentifiedImageError

from mammosim.io.figures import DPI
from mammosim.study.report.explorer import Explorer
from mammosim.study.report.summary import Numbers
from mammosim.study.report.texts import Sources, anchor_of, paragraphs, quoted, words

# How the end of a column's name reads as a unit.
UNITS: Mapping[str, str] = {
    "mm": "mm", "mm2": "mm²", "mm3": "mm³", "kpa": "kPa", "n": "N", "mn": "mN", "uj": "µJ", "g": "g",
    "mgy": "mGy", "ugy": "µGy", "mas": "mAs", "kev": "keV", "deg": "°", "percent": "%", "s": "s", "mb": "MB",
    "mj": "mJ", "ev": "eV",
}  # fmt: skip
LINK = re.compile(r"\[([^\]]+)\]\((#[\w-]+|[a-z0-9_]+\.html)\)")
MEDIA = {"png": "image/png", "svg": "image/svg+xml"}
SCREEN_DPI = 96  # a pixel of CSS is 1/96 inch
LONG = 1e9  # numbers from which their digits are not written out
SHORT = 12  # rows of a table that is shown whole
PROSE, LABEL = 60, 30  # letters: more of a cell is a sentence, up to so many stay on one line
KB, MB = 1e3, 1e6


@dataclass(frozen=True)
class Picture:
    """A figure: the bytes of its file, 'png' or 'svg', and a caption.

    path: of the file from the page, '' where the page holds it; vector: of its vector file, '' of none.
    """

    data: bytes
    caption: str
    kind: str = "png"
    path: str = ""
    vector: str = ""

    @property
    def source(self) -> str:
        """Where the picture is: its path, or its bytes as a data URI."""
        return self.path or f"data:{MEDIA[self.kind]};base64,{base64.b64encode(self.data).decode()}"

    @property
    def size(self) -> tuple[int, int] | None:
        """Width and height in pixels of CSS at the size of print; None where the file does not say."""
        try:
            with Image.open(BytesIO(self.data)) as image:
                dpi = image.info.get("dpi", (DPI, DPI))[0]
                return round(image.width * SCREEN_DPI / dpi), round(image.height * SCREEN_DPI / dpi)
        except (UnidentifiedImageError, OSError):
            return None


@dataclass(frozen=True)
class Listing:
    """A table with a caption; units are read off the column names.

    csv: path from the page of the file that has all of it, '' of none; anchors: the column whose values name
    its rows, to which texts link; a table with anchors is shown whole.
    """

    frame: pd.DataFrame
    caption: str
    csv: str = ""
    anchors: str = ""

    @property
    def headings(self) -> list[str]:
        """Column names in words, with units."""
        return [heading(str(column)) for column in self.frame.columns]

    @cached_property
    def rows(self) -> list[list[str]]:
        """Cells as text: numbers to four significant digits, a dash where there is none."""
        return [[cell(value) for value in row] for row in self.frame.itertuples(index=False)]

    @property
    def kinds(self) -> list[str]:
        """Of each column: number, prose where a cell is a sentence, label where all are short, else ''.

        A column of sentences needs a width of its own, labels stay on one line.
        """
        kinds = []
        for place, column in enumerate(self.frame.columns):
            longest = max((len(row[place]) for row in self.rows), default=0)
            dtype = self.frame[column].dtype
            number = pd.api.types.is_numeric_dtype(dtype) and not pd.api.types.is_bool_dtype(dtype)
            text = "prose" if longest > PROSE else "label" if longest <= LABEL else ""
            kinds.append("number" if number else text)
        return kinds

    @property
    def paged(self) -> bool:
        """Whether it is too long to be shown whole; one with links is never paged, whose cells are text."""
        linked = any(isinstance(text, Markup) for row in self.rows for text in row)
        return len(self.frame) > SHORT and not self.anchors and not linked

    @property
    def first(self) -> int:
        """How many rows stand on the page where no script runs, if it is paged."""
        return SHORT

    @property
    def json(self) -> Markup:
        """All cells as JSON that can stand in a script element."""
        return Markup(json.dumps(self.rows, ensure_ascii=False).replace("<", "\\u003c"))

    def anchor_of(self, row: int) -> str:
        """The id of a row."""
        return anchor_of(str(self.frame[self.anchors].iloc[row]))


@dataclass(frozen=True)
class Section:
    """A title, paragraphs of text separated by blank lines, and pictures, tables and explorers below.

    In the text, {name} or {name:.1f} stands for a number of numbers.json; `x` is code, **x** is bold,
    [x](path) a link, $x$ a formula and [@key] a citation.
    """

    title: str
    text: str = ""
    blocks: tuple[Picture | Listing | Explorer, ...] = ()

    @property
    def anchor(self) -> str:
        """Where the table of contents points to."""
        return re.sub(r"[\W_]+", "-", self.title.lower()).strip("-")


def report(
    title: str,
    sections: tuple[Section, ...],
    *,
    numbers: Numbers,
    subtitle: str = "",
    footer: Mapping[str, str] | None = None,
    sources: Sources | None = None,
    links: Sequence[tuple[str, str]] = (),
    scripts: str = "",
) -> str:
    """The page.

    footer: what made it, name -> words; sources: what texts may cite; links: (words, path) below the title;
    scripts: path from the page of the folder that `scripts.write_scripts` has filled: long tables are paged,
    where they would be shown whole without it.
    Raises ConfigurationError when a text names a number that the results do not have, or cites what is not
    among the sources.
    """
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    page = environment.from_string(template("report.html.j2"))
    figures, tables = _numbered(sections, Picture), _numbered(sections, Listing)
    html = page.render(
        title=title,
        subtitle=subtitle,
        footer=(footer or {}).items(),
        links=links,
        scripts=scripts,
        style=Markup(template("page.css")),
        script=Markup(template("page.js")),
        sections=[(section, paragraphs(quoted(section.text, numbers), sources)) for section in sections],
        number_of=lambda block: figures.get(id(block)) or tables.get(id(block)),
        is_picture=lambda block: isinstance(block, Picture),
        is_explorer=lambda block: isinstance(block, Explorer),
        explored=Markup(template("explorer.js")) if _numbered(sections, Explorer) else "",
        heading=heading,
        words=lambda text: words(text, sources),
        alternative=alternative,
        weight=WEIGHT,
    )
    before, _, after = html.rpartition(WEIGHT)
    return f"{before}{weight(html, sections)}{after}"


WEIGHT = "@weight@"  # in the place of words that can be had of the finished page only


def template(name: str) -> str:
    """The text of a template of this package."""
    return resources.files("mammosim.study.report").joinpath("templates", name).read_text(encoding="utf-8")


def weight(html: str, sections: Sequence[Section]) -> str:
    """What a page weighs, in words."""
    beside = [b for each in sections for b in each.blocks if isinstance(b, Picture) and b.path]
    page = size_words(len(html.encode()))
    if not beside:
        return page
    return f"{page}, and {size_words(sum(len(b.data) for b in beside))} of figures behind the first screen"


def size_words(size: float) -> str:
    """A number of bytes in kB or MB."""
    return f"{size / MB:.1f} MB" if size >= MB else f"{size / KB:.0f} kB"


def alternative(picture: Picture) -> str:
    """What stands for a picture that is not seen: the first sentence of its caption, without marks."""
    first = re.split(r"(?<=[.;])\s", picture.caption, maxsplit=1)[0]
    return re.sub(r"[`*$]|\s*\[@[^\]]*\]", "", first)


def _numbered(sections: tuple[Section, ...], kind: type) -> dict[int, int]:
    blocks = [block for section in sections for block in section.blocks if isinstance(block, kind)]
    return {id(block): number for number, block in enumerate(blocks, start=1)}


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
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:,.0f}" if 1000 <= abs(value) < LONG else f"{value:.4g}"
    return str(value)
