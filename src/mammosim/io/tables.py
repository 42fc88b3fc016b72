"""Tidy tables as CSV and small nested values as JSON, written atomically, floats at full precision."""

import csv
import json
from collections.abc import Iterable, Mapping
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mammosim.core.errors import DamagedTable, MissingResult, TableError
from mammosim.io.atomic import replacing
from mammosim.io.missing import AGAIN, missing_rows, reason_of, require_there

NAMES = ("volunteer", "position", "side", "strategy", "moduli", "method", "tissue", "name")
# Significant digits of the study's tables: they are the same on every processor (docs/decisions/machines.md).
HOLDING_DIGITS = 5


def read_table(path: str | Path, *, may_be_empty: bool = False, by_hand: bool = False) -> pd.DataFrame:
    """One row per record, one column per quantity (unit in its name); only an empty cell is missing.

    Rows in the place of results that are missing are left out, and so is the column `outcome` where nothing
    else stands in it. by_hand: see read_rows. Raises MissingResult when there is no other row, DamagedTable
    (by_hand: TableError) as read_rows, and for a table without rows unless it may be empty.
    """
    rows = read_rows(path, by_hand=by_hand)
    if rows.empty and not may_be_empty:
        raise _damaged(by_hand)(f"{path} has columns and no rows; {AGAIN}")
    gone = missing_rows(rows)
    if not gone.any():
        return rows
    if gone.all():
        raise MissingResult(reason_of(rows.outcome.iloc[0]))
    there = rows[~gone].reset_index(drop=True)
    return there.drop(columns="outcome") if there.outcome.isna().all() else there


def read_rows(path: str | Path, *, by_hand: bool = False, names: Iterable[str] = NAMES) -> pd.DataFrame:
    """As read_table, with the rows of results that are missing.

    by_hand: a person wrote it, whose last line may have no end; names: columns that hold text, even '007'.
    Raises DamagedTable (by_hand: TableError) when the table is gone, cut short or damaged: no header, no end
    of its last line, a row with more or fewer cells than there are columns, a quotation mark without its
    fellow, no UTF-8.
    """
    try:
        text = Path(path).read_bytes()
    except OSError as error:
        raise _damaged(by_hand)(f"{path} cannot be read: {error.strerror}; {AGAIN}") from None
    _require_whole(text, path, by_hand)
    kinds = dict.fromkeys(names, str)
    try:
        return pd.read_csv(BytesIO(text), keep_default_na=False, na_values=[""], dtype=kinds)
    except ValueError as error:  # a quotation mark without its fellow, or bytes that are no UTF-8
        why = " ".join(str(error).split())
        raise _damaged(by_hand)(f"{path} is damaged ({why}); {AGAIN}") from None


def _require_whole(text: bytes, path: str | Path, by_hand: bool) -> None:
    damaged = _damaged(by_hand)
    if not text.strip():
        raise damaged(f"{path} is empty; {AGAIN}")
    cells = _cells(text)
    if not (by_hand or text.endswith(b"\n")):
        raise damaged(f"{path} ends early, in row {cells.size - 1}; {AGAIN}")
    if (wrong := np.flatnonzero(cells != cells[0])).size:
        row = int(wrong[0])
        raise damaged(f"{path}: row {row} has {cells[row]} of {cells[0]} cells; {AGAIN}")


def _damaged(by_hand: bool) -> type[TableError]:
    """What a person wrote is mended by that person; what the study wrote is made again."""
    return TableError if by_hand else DamagedTable


def _cells(text: bytes) -> np.ndarray:
    """How many cells each line has that is not empty, the header's first."""
    if b'"' in text or b"\n\n" in text or b"\r" in text:
        lines = csv.reader(StringIO(text.decode("utf-8-sig", "replace"), newline=""))
        return np.array([len(line) for line in lines if line])
    characters = np.frombuffer(text.rstrip(b"\n"), np.uint8)
    ends, commas = (np.flatnonzero(characters == ord(mark)) for mark in "\n,")
    return 1 + np.diff(np.searchsorted(commas, ends), prepend=0, append=commas.size)


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
        return read_table(path, may_be_empty=True)
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
    """Nested dicts, lists, strings and numbers.

    Raises MissingResult when the result is missing, DamagedTable when the file is cut short or damaged.
    """
    require_there(path)
    try:
        return json.loads(Path(path).read_text(encoding="utf-8"))
    except ValueError as error:  # of JSON, or of UTF-8
        raise DamagedTable(f"{path} is cut short or damaged: no JSON ({error}); {AGAIN}") from None


def write_json(values: Any, path: str | Path) -> None:
    """Write in the order given. Raises ValueError for nan or infinity, which JSON does not have."""
    text = json.dumps(values, indent=1, ensure_ascii=False, allow_nan=False, default=_plain)
    with replacing(path) as temporary:
        temporary.write_text(text + "\n", encoding="utf-8")


def write_numbers(numbers: Mapping[str, Any], path: str | Path) -> None:
    """What the texts of a page quote, by name: None for what is no finite number, which a text leaves out."""
    write_json({name: _known(value) for name, value in numbers.items()}, path)


def _known(value: Any) -> Any:
    number = isinstance(value, (float, np.floating))
    return None if value is None or (number and not np.isfinite(value)) else value


def _plain(value: Any) -> Any:
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} has no place in JSON; give dicts, lists, strings and numbers")
