"""Results that are missing, because a stage found none: the file in their place gives the reason.

A table (`.csv`) then has one row with the keys of the job and `outcome`, which begins with PREFIX; any other
file is the JSON object {"missing": reason}. Whoever reads such a file gets MissingResult with that reason.
"""

import json
from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from mammosim.core.errors import DamagedTable, MissingResult, TableError
from mammosim.io.atomic import replacing

PREFIX = "missing: "
KEY = "missing"
START = f'{{"{KEY}": '
AGAIN = "delete it and run the stage that makes it, or copy it again"


def write_missing(path: str | Path, reason: str, *, job: Mapping[str, object] | None = None) -> None:
    """Say in the place of a result why it is not there. job: what tells a table's rows apart."""
    with replacing(path) as temporary:
        if Path(path).suffix == ".csv":
            row = pd.DataFrame([{**(job or {}), "outcome": f"{PREFIX}{reason}"}])
            row.to_csv(temporary, index=False, lineterminator="\n")
        else:
            temporary.write_text(json.dumps({KEY: reason}, ensure_ascii=False) + "\n", encoding="utf-8")


def require_there(path: str | Path) -> None:
    """Raise MissingResult when the file, which is no table, says that its result is missing.

    Raises TableError when it cannot be opened, DamagedTable when it is the cut or damaged half of such
    a word.
    """
    try:
        with Path(path).open("rb") as file:
            head = file.read(len(START))
        if head != START.encode():
            return
        reason = json.loads(Path(path).read_text(encoding="utf-8"))[KEY]
    except OSError as error:
        raise TableError(f"{path} cannot be read: {error.strerror}; run the stage that makes it") from None
    except (ValueError, KeyError, TypeError) as error:  # of JSON or of UTF-8
        raise DamagedTable(
            f"{path} should say why a result is missing, and is cut short or damaged "
            f"({' '.join(str(error).split())}); {AGAIN}"
        ) from None
    raise MissingResult(str(reason))


def missing_rows(table: pd.DataFrame) -> pd.Series:
    """Which rows (n,) bool of a table stand in the place of a result that is missing."""
    if "outcome" not in table:
        return pd.Series(False, index=table.index)
    return table["outcome"].astype(str).str.startswith(PREFIX)


def reason_of(outcome: str) -> str:
    """Why a result is missing."""
    return outcome.removeprefix(PREFIX)
