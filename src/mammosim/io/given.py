"""Text that a person or another program wrote: any usual encoding, separator and decimal sign."""

import csv
import io
import json
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mammosim.core.errors import MammosimError
from mammosim.io.plain import COMMENT

ENCODINGS = {b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
SEPARATORS = (";", "\t", ",")
DECIMAL_COMMA = re.compile(r"^\s*[+-]?\d*,\d+([eE][+-]?\d+)?\s*$")


def given_text(path: str | Path) -> str:
    """The text of a file in UTF-8, with or without byte order mark, UTF-16 with one, else in Latin-1."""
    data = Path(path).read_bytes()
    try:
        return data.decode(ENCODINGS.get(data[:2], "utf-8-sig"))
    except UnicodeDecodeError:
        return data.decode("latin-1")


def given_json(path: str | Path, *, error: type[MammosimError]) -> Any:
    """The values of a JSON file. Raises `error`, with line and column, where it is none."""
    try:
        return json.loads(given_text(path))
    except json.JSONDecodeError as wrong:
        raise error(
            f"{path}: line {wrong.lineno}, column {wrong.colno}: no JSON ({wrong.msg}); was it cut off? "
            "export it again"
        ) from None


def given_table(
    path: str | Path, *, error: type[MammosimError], columns: Iterable[str], comments: bool = False
) -> pd.DataFrame:
    """The rows of a `.csv` by commas, semicolons or tabs; names and text without blanks around them.

    Where columns are not separated by commas, a number may have a decimal comma. columns: what its header
    should have, for the message; comments: what follows a `#` is none of it, as in io.plain. Raises `error`
    where there is no text, no row, or a quotation mark is open.
    """
    text = given_text(path)
    if comments:
        text = "\n".join(COMMENT.split(line)[0] for line in text.splitlines())
    if not text.strip("\0 \r\n\t,;"):
        raise error(f"{path} is empty; its first line should be: {','.join(columns)}")
    table = pd.read_csv(
        io.StringIO(_tidy(text, path, error)), keep_default_na=False, na_values=[""], index_col=False
    )
    if table.empty:
        raise error(f"{path} has a header and no rows; was it cut off? save it again")
    return table


def _tidy(text: str, path: str | Path, error: type[MammosimError]) -> str:
    """The same table by commas with decimal points, without blanks around cells and empty cells at the end.

    Raises `error` where a row has more cells than the header, or a quotation mark is open.
    """
    separator = _separator(text)
    try:
        rows = [
            [_cell(cell, separator) for cell in row]
            for row in csv.reader(io.StringIO(text), delimiter=separator, skipinitialspace=True, strict=True)
            if any(row)
        ]
    except csv.Error as wrong:
        raise error(f"{path} is no table: {wrong}; close what a quotation mark opens") from None
    header = [name.lstrip("#").strip() for name in rows[0]]
    width = 1 + max((n for n, name in enumerate(header) if name), default=0)
    for number, row in enumerate(rows[1:], 1):
        if any(row[width:]):
            raise error(
                f"{path}: row {number} has {len(row)} cells and the header {width}; name each column, and "
                "write decimal points where commas separate"
            )
    tidy = io.StringIO()
    csv.writer(tidy, lineterminator="\n").writerows([header[:width], *(row[:width] for row in rows[1:])])
    return tidy.getvalue()


def ends_whole(path: str | Path) -> bool:
    """Whether the last line of a text file has its end: a file that was cut off has none."""
    return given_text(path).endswith(("\n", "\r"))


def numbers(table: pd.DataFrame, columns: Iterable[str]) -> np.ndarray:
    """Numbers (n, k) of some columns, NaN where a cell holds none."""
    found: np.ndarray = table[list(columns)].apply(pd.to_numeric, errors="coerce").to_numpy(float)
    return found


def _separator(text: str) -> str:
    """What stands most often in the first line; a comma where nothing does."""
    head = next(line for line in text.splitlines() if line.strip())
    return max(SEPARATORS[::-1], key=head.count)


def _cell(cell: str, separator: str) -> str:
    """Without blanks around it, a decimal comma as a point."""
    comma = separator != "," and DECIMAL_COMMA.match(cell)
    return cell.strip().replace(",", ".") if comma else cell.strip()
