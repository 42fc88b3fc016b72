"""What was aimed at beside what was measured, and the program that did best."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

OURS = "mammosim"


def judged(measured: float, aim: Mapping[str, Any]) -> dict[str, Any]:
    """measured, goal in words, met; aim: has `at_least` or `at_most`. Not met where nothing was measured."""
    at_least = "at_least" in aim
    goal = aim["at_least"] if at_least else aim["at_most"]
    met = measured >= goal if at_least else measured <= goal
    words = f"{'at least' if at_least else 'at most'} {goal:g}"
    return {"measured": measured, "goal": words, "met": bool(met)}


def best(table: pd.DataFrame, column: str) -> tuple[str, float]:
    """The program with the smallest value, and it; 'none' and nan where there is no row."""
    rows = table[table[column].notna()]
    if rows.empty:
        return "none", np.nan
    row = rows.loc[rows[column].idxmin()]
    return str(row.program), float(row[column])


def only(rows: pd.DataFrame, column: str) -> float:
    """The value of the first row, nan where there is none."""
    return float(rows[column].iloc[0]) if len(rows) else np.nan


def counts(aims: pd.DataFrame, where: list[str], *, prefix: str) -> dict[str, Any]:
    """How many aims there are and were met, and which were missed; where: columns that say of what."""
    missed = ["what", *where]
    words = [", ".join(row) for row in aims.loc[~aims.met.astype(bool), missed].astype(str).to_numpy()]
    return {
        f"{prefix}.aims": len(aims),
        f"{prefix}.aims_met": int(aims.met.sum()),
        f"{prefix}.aims_missed": "; ".join(words) or "none",
    }
