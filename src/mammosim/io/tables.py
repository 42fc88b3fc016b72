"""Tidy tables as CSV and small nested values as JSON, written atomically, floats at full precision."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mammosim.io.atomic import replacing


def read_table(path: str | Path) -> pd.DataFrame:
    """One row per record, one column per quantity (unit in its name); only an empty cell is missing."""
    return pd.read_csv(path, keep_default_na=False, na_values=[""])


def read_commented(path: str | Path) -> pd.DataFrame:
    """As read_table, of a table whose first lines begin with `#` and say where it comes from."""
    with Path(path).open(encoding="utf-8") as lines:
        head = next((number for number, line in enumerate(lines) if not line.startswith("#")), 0)
    return pd.read_csv(path, skiprows=head, keep_default_na=False, na_values=[""])


def write_table(frame: pd.DataFrame, path: str | Path) -> None:
    """Write the columns without the index; every float reads back as the same number."""
    with replacing(path) as temporary:
        frame.to_csv(temporary, index=False, lineterminator="\n")


def read_json(path: str | Path) -> Any:
    """Nested dicts, lists, strings and numbers."""
    return json.loads(Path(path).read_text(encoding="utf-8"))


def write_json(values: Any, path: str | Path) -> None:
    """Write in the order given. Raises ValueError for nan or infinity, which JSON does not have."""
    text = json.dumps(values, indent=1, ensure_ascii=False, allow_nan=False, default=_plain)
    with replacing(path) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")


def _plain(value: Any) -> Any:
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} has no place in JSON; give dicts, lists, strings and numbers")
