"""A finished table behind a slider: columns against one column, a line for each breast, read between rows."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd
from markupsafe import Markup

from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import Settings


@dataclass(frozen=True)
class Exploration(Settings):
    """What of a table stands behind a slider.

    x: the column that the slider moves along; y: columns to choose from; by: columns that tell lines apart;
    logarithmic: whether x is drawn so. Raises ConfigurationError without a y, or without a by.
    """

    caption: str
    x: str
    y: tuple[str, ...]
    by: tuple[str, ...]
    logarithmic: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.y or not self.by:
            raise ConfigurationError("y and by name at least one column each")


@dataclass(frozen=True)
class Explorer:
    """An exploration of the rows of a table."""

    frame: pd.DataFrame
    shown: Exploration

    @property
    def caption(self) -> str:
        """The caption of the exploration."""
        return self.shown.caption

    def json(self, heading: Any) -> Markup:
        """What its script reads, as JSON in a script element. heading: a column's name in words."""
        lines = [
            _line(" ".join(map(str, keys)), rows, self.shown)
            for keys, rows in self.frame.groupby(list(self.shown.by), sort=False)
        ]
        names = {name: heading(name) for name in self.shown.y if name in self.frame}
        data = {"x": heading(self.shown.x), "y": names, "lines": lines, "logarithmic": self.shown.logarithmic}
        return Markup(json.dumps(data, ensure_ascii=False).replace("<", "\\u003c"))


def explorer(frame: pd.DataFrame, shown: Exploration) -> Explorer | None:
    """The explorer of a table; None where the table lacks columns or has no two rows of one line."""
    columns = [shown.x, *shown.by]
    if not set(columns) <= set(frame) or not any(name in frame for name in shown.y):
        return None
    rows = frame.dropna(subset=columns)
    return Explorer(rows, shown) if len(rows) and rows.groupby(list(shown.by)).size().max() > 1 else None


def _line(name: str, rows: pd.DataFrame, shown: Exploration) -> Mapping[str, object]:
    """One line: its name, x in ascending order, and y with None where there is no number."""
    ordered = rows.sort_values(shown.x)
    values = {name: ordered[name] for name in shown.y if name in ordered}
    numbers = {name: [None if pd.isna(v) else float(v) for v in column] for name, column in values.items()}
    return {"name": name, "x": ordered[shown.x].astype(float).tolist(), "y": numbers}
