"""Small tables and settings as plain values, read without pandas: what a start of the workflow needs."""

import csv
from collections.abc import Hashable
from pathlib import Path

from mammosim.core.errors import ConfigurationError


def read_plain(path: str | Path) -> list[dict[str, str]]:
    """The rows of a table as text: a `.csv` by commas, else by tabs. `#` begins a comment.

    Raises ConfigurationError where there is no such file, or no text in it.
    """
    separator = "," if Path(path).suffix == ".csv" else "\t"
    try:
        return _rows(path, separator)
    except OSError as error:
        raise ConfigurationError(f"{path} cannot be read: {error.strerror}; give a table") from None
    except UnicodeDecodeError as error:
        byte = error.object[error.start]
        raise ConfigurationError(f"{path}: byte {byte:#04x} is no UTF-8; save the table as UTF-8") from None


def _rows(path: str | Path, separator: str) -> list[dict[str, str]]:
    with Path(path).open(encoding="utf-8-sig", newline="") as file:
        cut = (line.split("#")[0] if separator == "\t" else line for line in file)
        lines = (line for line in cut if line.strip() and not line.startswith("#"))
        return list(csv.DictReader(lines, delimiter=separator, skipinitialspace=True))


def repeated(keys: list[Hashable]) -> list[Hashable]:
    """Those that stand more than once, each once."""
    return list(dict.fromkeys(key for n, key in enumerate(keys) if key in keys[:n]))
