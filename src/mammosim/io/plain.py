"""Small tables and settings as plain values, read without pandas: what a start of the workflow needs."""

import csv
import re
from collections.abc import Hashable, Sequence
from pathlib import Path

from mammosim.core.errors import ConfigurationError

COMMENT = re.compile(r"(?:^|(?<=\s))#")  # what stands in a word, as in scans/#1, is none


def read_plain(path: str | Path) -> list[dict[str, str]]:
    """The rows of a table as text without blanks around it: a `.csv` by commas, else by tabs.

    `#` begins a comment at the beginning of a line, or after a blank or tab where tabs separate.
    Raises ConfigurationError where there is no such file, nothing in it, a column stands twice, or a row has
    more or fewer cells than there are columns.
    """
    separator = "," if Path(path).suffix.lower() == ".csv" else "\t"
    try:
        return _rows(path, separator)
    except OSError as error:
        raise ConfigurationError(f"{path} cannot be read: {error.strerror}; give a table") from None
    except csv.Error as error:
        raise ConfigurationError(f"{path}: {error}; close what a quotation mark opens") from None
    except UnicodeDecodeError as error:
        byte = error.object[error.start]
        raise ConfigurationError(f"{path}: byte {byte:#04x} is no UTF-8; save the table as UTF-8") from None


def tabulated_plain(name: str) -> list[dict[str, str]]:
    """The rows of the table `io/data/{name}.csv` as text; its comment lines `#` name the source."""
    return read_plain(Path(__file__).parent / "data" / f"{name}.csv")


def _rows(path: str | Path, separator: str) -> list[dict[str, str]]:
    if not Path(path).stat().st_size:
        raise ConfigurationError(f"{path} is empty, 0 bytes; its first line names the columns: copy it again")
    with Path(path).open(encoding="utf-8-sig", newline="") as file:
        cut = (COMMENT.split(line)[0] if separator == "\t" else line for line in file)
        lines = (line for line in cut if line.strip() and not line.startswith("#"))
        cells = csv.reader(lines, delimiter=separator, skipinitialspace=True, strict=True)
        columns, *rows = [[cell.strip() for cell in line] for line in cells] or [[]]
    if twice := repeated(columns):
        raise ConfigurationError(f"{path}: column {twice[0]!r} stands twice; name each column once")
    for n, row in enumerate(rows, 1):
        if len(row) != len(columns):
            by = "commas" if separator == "," else "tabs"
            raise ConfigurationError(
                f"{path}: row {n} ({' '.join(row[:2])}) has {len(row)} of {len(columns)} cells; "
                f"separate them by {by} and leave none out"
            )
    return [dict(zip(columns, row)) for row in rows]


def repeated(keys: Sequence[Hashable]) -> list[Hashable]:
    """Those that stand more than once, each once."""
    return list(dict.fromkeys(key for n, key in enumerate(keys) if key in keys[:n]))
