"""From a layout, the nested plain values of a file of sections, to the sections of a page."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace

import pandas as pd

from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import Settings
from mammosim.io.missing import missing_rows
from mammosim.study.report.explorer import Exploration, Explorer, explorer
from mammosim.study.report.pages import Listing, Picture, Section
from mammosim.study.report.texts import FORMULA, NUMBER, Sources, cited_keys


@dataclass(frozen=True)
class Contents:
    """What there is to show: pictures and tables by name.

    csv: name -> path from the page of the file of a table; anchors: name -> the column to whose rows texts
    link.
    """

    pictures: Mapping[str, Picture]
    tables: Mapping[str, pd.DataFrame]
    csv: Mapping[str, str] = field(default_factory=dict)
    anchors: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class TablePart(Settings):
    """A table to show: its caption and the columns to show, by default all."""

    caption: str
    columns: tuple[str, ...] | None = None


@dataclass(frozen=True)
class Part(Settings):
    """A section to be: title, text, captions of pictures by the beginning of their names, tables by name,
    and which of these stand behind a slider.

    Or, with nothing but `page`, the place of the sections of a page that is made on demand, by its target.
    needs: the stage or question without which it says nothing.
    Raises ConfigurationError for a section without title, a page with one, a caption that names anything but
    {what}.
    """

    title: str = ""
    text: str = ""
    figures: Mapping[str, str] = field(default_factory=dict)
    explore: Mapping[str, Exploration] = field(default_factory=dict)
    tables: Mapping[str, TablePart] = field(default_factory=dict)
    page: str = ""
    needs: str = ""

    def __post_init__(self) -> None:
        super().__post_init__()
        if bool(self.title) == bool(self.page):
            raise ConfigurationError("a section has either a title or the name of a page; give one of them")
        for name, caption in self.figures.items():
            named = set(NUMBER.findall(FORMULA.sub("", caption)))
            if named - {("what", "")}:
                raise ConfigurationError(f"figures.{name} may name {{what}} only, not as {caption!r}")

    @property
    def texts(self) -> tuple[str, ...]:
        """Everything in it that may cite."""
        explored = [each.caption for each in self.explore.values()]
        return (
            self.text,
            *self.figures.values(),
            *explored,
            *(each.caption for each in self.tables.values()),
        )


@dataclass(frozen=True)
class Layout(Settings):
    """A file of sections: what stands on a page, from top to bottom."""

    sections: tuple[Part, ...]
    title: str = ""
    subtitle: str = ""


def require_sources(layout: Layout, sources: Sources, *, file: str) -> None:
    """Raise ConfigurationError, naming the file of the layout, where it cites what is no source."""
    for part in layout.sections:
        for key in cited_keys(part.texts):
            if key not in sources:
                near = ", ".join(sorted(name for name in sources if name[:3] == key[:3])) or "none alike"
                raise ConfigurationError(
                    f"{file} cites [@{key}] in {part.title!r}, which the bibliography does not have; "
                    f"add it, or choose of: {near}"
                )


def sources_section(found: tuple[Section, ...], listed: pd.DataFrame) -> tuple[Section, ...]:
    """The sources that sections cite, of all that are listed (column key), as one more section, if any."""
    captions = [block.caption for each in found for block in each.blocks]
    cited = set(cited_keys([*(each.text for each in found), *captions]))
    rows = listed[listed.key.isin(cited)]
    return () if rows.empty else (Section("Sources", "", (Listing(rows, "What is cited.", "", "key"),)),)


def sections(
    layout: Layout,
    contents: Contents,
    *,
    pages: Mapping[str, Layout] | None = None,
    made: Collection[str] = (),
    lacking: Collection[str] = (),
) -> tuple[Section, ...]:
    """One section per part of a layout; in the place of a page, the sections of that page.

    pages: the layouts of the results that are made on demand, by the name of their target; one that is not
    among those made is a line that names its command.
    lacking: what no volunteer's data allow; parts that need one of these are left out.
    Raises ConfigurationError for a page without layout.
    """
    found: list[Section] = []
    for part in (part for part in layout.sections if part.needs not in lacking):
        if not part.page:
            found.append(section(part, contents))
            continue
        page = _page(part.page, pages or {})
        if part.page in made:
            found += sections(page, contents)
        else:
            found.append(Section(page.title, f"Made on demand, by `snakemake {part.page}`: not yet."))
    return tuple(found)


def titles(layout: Layout, pages: Iterable[Layout] = ()) -> list[str]:
    """Titles of all sections that a page may have, whatever is lacking; pages: those that it may include."""
    return [part.title for each in (layout, *pages) for part in each.sections if part.title]


def section(part: Part, contents: Contents) -> Section:
    """One section: the pictures whose names begin with the words listed, and its tables.

    A table that is not there is left out: a study without digital volunteers has no scores.
    """
    blocks: list[Picture | Listing | Explorer] = []
    for prefix, caption in part.figures.items():
        for name, picture in contents.pictures.items():
            if name == prefix or name.startswith(f"{prefix}_"):
                what = name.removeprefix(prefix).strip("_").replace("_", " ")
                blocks.append(replace(picture, caption=caption.replace("{what}", what)))
    found = [explorer(contents.tables[n], each) for n, each in part.explore.items() if n in contents.tables]
    blocks += [each for each in found if each is not None]
    for name, table in part.tables.items():
        if name in contents.tables:
            rows = _shown(contents.tables[name], table.columns)
            csv, anchors = contents.csv.get(name, ""), contents.anchors.get(name, "")
            blocks.append(Listing(rows, table.caption, csv, anchors))
    return Section(part.title, part.text, tuple(blocks))


def _shown(frame: pd.DataFrame, columns: tuple[str, ...] | None) -> pd.DataFrame:
    """The listed columns of a table, or all of it; and the reasons where results are missing."""
    if columns is None:
        return frame
    reasons = ["outcome"] if missing_rows(frame).any() else []
    return frame[[name for name in dict.fromkeys([*columns, *reasons]) if name in frame]]


def _page(name: str, pages: Mapping[str, Layout]) -> Layout:
    if name not in pages:
        raise ConfigurationError(f"no layout of a page {name!r}; there are: {', '.join(sorted(pages))}")
    return pages[name]
