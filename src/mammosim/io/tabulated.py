"""Borrowed numbers: tables with their units in the column names and their sources in comment lines."""

from pathlib import Path

import pandas as pd

from mammosim.core.errors import ConfigurationError

FOLDER = Path(__file__).parent / "data"


def tabulated(name: str, *, folder: Path = FOLDER) -> pd.DataFrame:
    """One row per record of the table `name`.csv; lines that start with `#` name the source.

    Raises ConfigurationError when there is no such table.
    """
    path = folder / f"{name}.csv"
    if not path.is_file():
        known = ", ".join(sorted(table.stem for table in folder.glob("*.csv"))) or "none yet"
        raise ConfigurationError(f"no table {name!r} in {folder}; choose one of: {known}")
    return pd.read_csv(path, comment="#", skipinitialspace=True, keep_default_na=False, na_values=[""])


def sources(name: str, *, folder: Path = FOLDER) -> tuple[str, ...]:
    """The comment lines of a table, in its order, without their `#`: where each number comes from."""
    lines = (folder / f"{name}.csv").read_text(encoding="utf-8").splitlines()
    return tuple(line.lstrip("# ").rstrip() for line in lines if line.startswith("#"))
