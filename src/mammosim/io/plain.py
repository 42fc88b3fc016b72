"""Small tables and settings as plain values, read without pandas: what a start of the workflow needs."""

import csv
from collections.abc import Hashable, Mapping
from pathlib import Path
from typing import Any


def read_plain(path: str | Path) -> list[dict[str, str]]:
    """The rows of a table as text: a `.csv` by commas, else by tabs. `#` begins a comment."""
    separator = "," if Path(path).suffix == ".csv" else "\t"
    with Path(path).open(encoding="utf-8-sig", newline="") as file:
        cut = (line.split("#")[0] if separator == "\t" else line for line in file)
        lines = (line for line in cut if line.strip() and not line.startswith("#"))
        return list(csv.DictReader(lines, delimiter=separator, skipinitialspace=True))


def not_finite(values: Any, name: str = "") -> list[str]:
    """Dotted names of all numbers in nested values that are not finite."""
    if isinstance(values, Mapping):
        return [
            each for key, value in values.items() for each in not_finite(value, f"{name}.{key}".lstrip("."))
        ]
    if isinstance(values, (list, tuple)):
        return [each for n, value in enumerate(values) for each in not_finite(value, f"{name}[{n}]")]
    odd = isinstance(values, float) and (values != values or values in (float("inf"), float("-inf")))
    return [name] if odd else []


def repeated(keys: list[Hashable]) -> list[Hashable]:
    """Those that stand more than once, each once."""
    return list(dict.fromkeys(key for n, key in enumerate(keys) if key in keys[:n]))
