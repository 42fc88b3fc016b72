"""The error of the whole chain at today's settings, by knobs, and the step that lowers it most per second.

E^2 = sum_k e_k^2; a step of knob k to the value v leaves E'^2 = E^2 - e_k^2 + e_kv^2 and takes t_kv - t_k
more.
"""

# ASSUME: errors of different knobs are independent, so that they add as squares.

from typing import Any

import numpy as np
import pandas as pd

from mammosim.core.errors import ConfigurationError
from mammosim.study.accuracy.presets import CHAIN
from mammosim.study.accuracy.trial import OK

COLUMNS = ["quantity", "stage", "knob", "value", "error", "share_percent", "total_error", "limits", "step_to",
           "error_after", "seconds_more", "fall_per_second", "next"]  # fmt: skip
LEAST_SECONDS = 0.05  # differences of time below this are not told apart


def budget(table: pd.DataFrame) -> pd.DataFrame:
    """COLUMNS: a row per quantity and knob that it depends on, the largest share first.

    table: study.accuracy.errors.accuracy. step_to: the value of the knob that lowers the total error most per
    second, empty where none does; limits, next: the knob with the largest share, and that of the best step.
    Raises ConfigurationError where a knob lacks today's value.
    """
    parts = [
        _of(quantity, rows) for quantity, rows in table[table.knob != CHAIN].groupby("quantity", sort=False)
    ]
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=COLUMNS)


def _of(quantity: str, rows: pd.DataFrame) -> pd.DataFrame:
    """The budget of one quantity."""
    rows = rows[(rows.outcome == OK) & rows.error.notna()]
    lacking = sorted(set(rows.knob) - set(rows.knob[rows.today]))
    if lacking:
        raise ConfigurationError(
            f"today's value of the knob {lacking[0]} has no error of {quantity}: it was refused, or not tried"
        )
    today = rows[rows.today].set_index("knob")
    E2 = float((today.error**2).sum())
    found = []
    for knob, row in today.iterrows():
        share = 100 * row.error**2 / E2 if E2 else 0.0
        line = {
            "quantity": quantity,
            "stage": row.stage,
            "knob": knob,
            "value": row.value,
            "error": row.error,
        }
        # ASSUME: a coarser value that came nearer than today's did so by chance.
        step = best_step(_finer(rows, str(knob)), row, E2)
        found.append(line | {"share_percent": share, "total_error": np.sqrt(E2)} | step)
    if not found:
        return pd.DataFrame(columns=COLUMNS)
    table = pd.DataFrame(found).sort_values(
        "share_percent", ascending=False, kind="stable", ignore_index=True
    )
    gain = table.fall_per_second.fillna(0)
    table["limits"] = (table.index == 0) & (table.error > 0)
    table["next"] = (table.index == gain.idxmax()) & (gain > 0)
    return table[COLUMNS]


def _finer(rows: pd.DataFrame, knob: str) -> pd.DataFrame:
    """The values of a knob after today's, which stand from draft to reference."""
    values = rows[rows.knob == knob]
    return values[values.today.cumsum() > 0]


def best_step(values: pd.DataFrame, today: pd.Series, E2: float) -> dict[str, Any]:
    """The columns step_to to fall_per_second of one knob; empty where no value lowers the error."""
    left = np.sqrt(np.maximum(E2 - today.error**2 + values.error**2, 0))
    fall, more = np.sqrt(E2) - left, values.seconds - today.seconds
    # ASSUME: what is as fast within the spread of the repeats costs that spread.
    spread = np.maximum(values.seconds_spread + today.seconds_spread, LEAST_SECONDS)
    gain = fall / np.maximum(more, spread)
    if not (fall > 0).any():
        return {"step_to": None, "error_after": np.nan, "seconds_more": np.nan, "fall_per_second": np.nan}
    best = gain.idxmax()
    return {
        "step_to": values.value[best],
        "error_after": float(left[best]),
        "seconds_more": float(more[best]),
        "fall_per_second": float(gain[best]),
    }
