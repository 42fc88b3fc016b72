"""From a layout, the nested plain values of a file of sections, to the sections of a page."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd

from mammosim.core.errors import ConfigurationError
from mammosim.io.missing import missing_rows
from mammosim.study.report.pages import Listing, Picture, Section

Part = Mapping[str, Any]


@dataclass(frozen=True)
class Contents:
    """What there is to show: pictures, name -> bytes of a PNG; tables, name -> DataFrame."""

    pictures: Mapping[str, bytes]
    tables: Mapping[str, pd.DataFrame]


def sections(
    parts: Iterable[Part],
    contents: Contents,
    *,
    pages: Mapping[str, Part] | None = None,
    made: Collection[str] = (),
) -> tuple[Section, ...]:
    """One section per part; in the place of a part {page: name}, the sections of that page.

    pages: the layouts of the results that are made on demand, by the name of their target; one that is not
    among those made is a line that names its command.
    Raises ConfigurationError for a page without layout.
    """
    found: list[Section] = []
    for part in parts:
        if "page" not in part:
            found.append(section(part, contents))
            continue
        layout = _layout(part["page"], pages or {})
        if part["page"] in made:
            found += sections(layout["sections"], contents)
        else:
            found.append(Section(layout["title"], f"Made on demand, by `snakemake {part['page']}`: not yet."))
    return tuple(found)


def section(part: Part, contents: Contents) -> Section:
    """One section: the pictures whose names begin with the words listed, and its tables.

    A table that is not there is left out: a study without digital volunteers has no scores.
    """
    blocks: list[Picture | Listing] = []
    for prefix, caption in part.get("figures", {}).items():
        for name, data in contents.pictures.items():
            if name == prefix or name.startswith(f"{prefix}_"):
                what = name.removeprefix(prefix).strip("_").replace("_", " ")
                blocks.append(Picture(data, caption.format(what=what)))
    for name, table in part.get("tables", {}).items():
        if name in contents.tables:
            blocks.append(Listing(_shown(contents.tables[name], table.get("columns")), table["caption"]))
    return Section(part["title"], part.get("text", ""), tuple(blocks))


def _shown(frame: pd.DataFrame, columns: list[str] | None) -> pd.DataFrame:
    """The listed columns of a table, or all of it; and the reasons where results are missing."""
    if columns is None:
        return frame
    reasons = ["outcome"] if missing_rows(frame).any() else []
    return frame[[name for name in dict.fromkeys([*columns, *reasons]) if name in frame]]


def _layout(name: str, pages: Mapping[str, Part]) -> Part:
    if name not in pages:
        raise ConfigurationError(f"no layout of a page {name!r}; there are: {', '.join(sorted(pages))}")
    return pages[name]
