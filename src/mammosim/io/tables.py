"""Tidy tables as CSV and small nested values as JSON, written atomically, floats at full precision."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mammosim.core.errors import MissingResult
from mammosim.io.atomic import replacing
from mammosim.io.missing import missing_rows, reason_of, require_there

NAMES = ("volunteer", "position", "side", "strategy", "moduli", "method", "tissue", "name")
# Significant digits of the study's tables: they are the same on every processor (docs/decisions/machines.md).
HOLDING_DIGITS = 5


def read_table(path: str | Path) -> pd.DataFrame:
    """One row per record, one column per quantity (unit in its name); only an empty cell is missing.

    Rows in the place of results that are missing are left out, and so is the column `outcome` where nothing
    else stands in it. Raises MissingResult when there is no other row.
    """
    rows = read_rows(path)
    gone = missing_rows(rows)
    if not gone.any():
        return rows
    if gone.all():
        raise MissingResult(reason_of(rows.outcome.iloc[0]))
    there = rows[~gone].reset_index(drop=True)
    return there.drop(columns="outcome") if there.outcome.isna().all() else there


def read_rows(path: str | Path) -> pd.DataFrame:
    """As read_table, with the rows of results that are missing. Columns of NAMES hold text, even '007'."""
    return pd.read_csv(path, keep_default_na=False, na_values=[""], dtype=dict.fromkeys(NAMES, str))


def read_those_there(paths: Iterable[str | Path]) -> pd.DataFrame:
    """The rows of all tables that are not missing. Raises MissingResult when every one is."""
    found, why = [], None
    for path in paths:
        try:
            found.append(read_table(path))
        except MissingResult as error:
            why = error
    if not found and why is not None:
        raise why
    return pd.concat(found, ignore_index=True)


def read_if_there(path: str | Path) -> pd.DataFrame:
    """As read_table, without rows and columns where the result is missing."""
    try:
        return read_table(path)
    except MissingResult:
        return pd.DataFrame()


def read_commented(path: str | Path) -> pd.DataFrame:
    """As read_table, of a table whose first lines begin with `#` and say where it comes from."""
    with Path(path).open(encoding="utf-8") as lines:
        head = next((number for number, line in enumerate(lines) if not line.startswith("#")), 0)
    return pd.read_csv(path, skiprows=head, keep_default_na=False, na_values=[""])


def write_table(frame: pd.DataFrame, path: str | Path, *, digits: int | None = None) -> None:
    """Write the columns without the index; every float reads back as the same number.

    digits: significant digits that floats are rounded to, where fewer are meant.
    """
    shape = None if digits is None else f"%.{digits}g"
    with replacing(path) as temporary:
        frame.to_csv(temporary, index=False, lineterminator="\n", float_format=shape)


def read_json(path: str | Path) -> Any:
    """Nested dicts, lists, strings and numbers. Raises MissingResult when the result is missing."""
    require_there(path)
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
