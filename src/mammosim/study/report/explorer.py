"""A finished table behind a slider: columns against one column, a line for each breast, read between rows."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
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
    """The explorer of a table; None where the table lacks columns or has no two rows of one line.

    A row whose place on the axis is no finite number, or not above 0 on a logarithmic one, is left out.
    """
    if not {shown.x, *shown.by} <= set(frame) or not any(name in frame for name in shown.y):
        return None
    x = _finite(frame[shown.x])
    rows = frame[x.notna() & ((x > 0) | (not shown.logarithmic))].dropna(subset=list(shown.by))
    return Explorer(rows, shown) if len(rows) and rows.groupby(list(shown.by)).size().max() > 1 else None


def _line(name: str, rows: pd.DataFrame, shown: Exploration) -> Mapping[str, object]:
    """One line: its name, x in ascending order, and y with None where there is no finite number."""
    x = _finite(rows[shown.x]).sort_values()
    values = {name: _finite(rows[name][x.index]) for name in shown.y if name in rows}
    numbers = {name: [None if pd.isna(v) else v for v in column] for name, column in values.items()}
    return {"name": name, "x": x.tolist(), "y": numbers}


def _finite(column: pd.Series) -> pd.Series:
    """The numbers of a column as floats, NaN where there is none: JSON has no infinity."""
    numbers = pd.to_numeric(column, errors="coerce").astype(float)
    return numbers.where(np.isfinite(numbers))
