"""Text that a person or another program wrote: any usual encoding, separator and decimal sign."""

import csv
import io
import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pandas as pd

from mammosim.core.errors import MammosimError

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


def given_table(path: str | Path, *, error: type[MammosimError], columns: Iterable[str]) -> pd.DataFrame:
    """The rows of a `.csv` by commas, semicolons or tabs; names and text without blanks around them.

    Where columns are not separated by commas, a number may have a decimal comma. columns: what its header
    should have, for the message. Raises `error` where there is no text, no row, or a quotation mark is open.
    """
    text = given_text(path)
    if not text.strip("\0 \r\n\t"):
        raise error(f"{path} is empty; its first line should be: {','.join(columns)}")
    separator = _separator(text)
    try:
        table = pd.read_csv(
            io.StringIO(text),
            sep=separator,
            keep_default_na=False,
            na_values=[""],
            index_col=False,
            skipinitialspace=True,
            quoting=csv.QUOTE_MINIMAL,
        )
    except (pd.errors.ParserError, ValueError) as wrong:
        raise error(
            f"{path} is no table: {' '.join(str(wrong).split())}; give columns {','.join(columns)}"
        ) from None
    table.columns = [str(name).strip().strip("#").strip() for name in table.columns]
    for name in [name for name in table.columns if not pd.api.types.is_numeric_dtype(table[name])]:
        table[name] = [_cell(value, separator) for value in table[name]]
    if table.empty:
        raise error(f"{path} has a header and no rows; was it cut off? save it again")
    return table


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


def _cell(value: object, separator: str) -> object:
    """Text without blanks around it, a decimal comma as a point."""
    if not isinstance(value, str):
        return value
    comma = separator != "," and DECIMAL_COMMA.match(value)
    return value.strip().replace(",", ".") if comma else value.strip()
