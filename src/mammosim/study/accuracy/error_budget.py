"""The error of the whole chain at today's settings, by parameters, and the step that lowers it most.

E^2 = sum_k e_k^2; a step of parameter k to the value v leaves E'^2 = E^2 - e_k^2 + e_kv^2 and takes
t_kv - t_k more.
"""

# ASSUME: errors of different parameters are independent, so that they add as squares.

from typing import Any

import numpy as np
import pandas as pd

from mammosim.chain.quantities import QUANTITIES
from mammosim.core.errors import ConfigurationError
from mammosim.study.accuracy.trial import CHAIN, CONVERGED

COLUMNS = ["quantity", "stage", "parameter", "value", "error", "share_percent", "total_error", "limits",
           "step_to", "error_after", "seconds_more", "fall_per_second", "next"]  # fmt: skip
LEAST_SECONDS = 0.05  # differences of time below this mean nothing


def budget(table: pd.DataFrame) -> pd.DataFrame:
    """COLUMNS: a row per quantity and parameter that it depends on, the largest share first.

    table: study.accuracy.errors.accuracy. step_to: the value of the parameter that lowers the total error
    most per second, empty where none does; limits, next: that with the largest share, that of the best step.
    Raises ConfigurationError where a parameter lacks today's value.
    """
    parts = [
        _of(quantity, rows)
        for quantity, rows in table[table.parameter != CHAIN].groupby("quantity", sort=False)
    ]
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=COLUMNS)


def _of(quantity: str, rows: pd.DataFrame) -> pd.DataFrame:
    """The budget of one quantity."""
    rows = rows[(rows.outcome == CONVERGED) & rows.error.notna()]
    lacking = sorted(set(rows.parameter) - set(rows.parameter[rows.today]))
    if lacking:
        raise ConfigurationError(
            f"today's value of the parameter {lacking[0]} has no error of {quantity}: try it, or another one"
        )
    today = rows[rows.today].set_index("parameter")
    E2 = float((today.error**2).sum())
    found = []
    for parameter, row in today.iterrows():
        share = 100 * row.error**2 / E2 if E2 else 0.0
        line = {
            "quantity": quantity,
            "stage": row.stage,
            "parameter": parameter,
            "value": row.value,
            "error": row.error,
        }
        # ASSUME: a coarser value that came nearer than today's did so by luck.
        step = best_step(_finer(rows, str(parameter)), row, E2)
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


def _finer(rows: pd.DataFrame, parameter: str) -> pd.DataFrame:
    """The values of a parameter after today's, which stand from draft to reference."""
    values = rows[rows.parameter == parameter]
    return values[values.today.cumsum() > 0]


def best_step(values: pd.DataFrame, today: pd.Series, E2: float) -> dict[str, Any]:
    """The columns step_to to fall_per_second of one parameter; empty where no value lowers the error."""
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


def numbers(table: pd.DataFrame, shares: pd.DataFrame, presets: pd.DataFrame) -> dict[str, Any]:
    """accuracy.parameters, .trials, .failed, .seconds, .limits and .next: a phrase per quantity, .presets.

    table: of accuracy.errors; shares: of accuracy.error_budget; presets: of accuracy.presets.
    """
    varied = table[table.parameter != CHAIN]
    each = varied.groupby(["parameter", "value"])
    values = {
        "parameters": int(varied.parameter.nunique()),
        "trials": int(each.ngroups),
        "failed": int((each.outcome.first() != CONVERGED).sum()),
        "seconds": float((each.seconds.max() * each.repeats.max()).sum()),
        "chain_seconds": float(table.seconds[table.parameter == CHAIN].max()),
        "limits": "; ".join(map(_limiting, shares[shares.limits].itertuples())) or "none",
        "next": "; ".join(map(_step, shares[shares["next"]].itertuples())) or "none",
        "presets": "; ".join(_preset(*each) for each in presets.groupby("preset", sort=False)) or "none",
    }
    return {f"accuracy.{name}": value for name, value in values.items()}


def _limiting(row: Any) -> str:
    words = QUANTITIES[row.quantity].words
    return (
        f"{words} ({row.quantity} {row.total_error:.2g} in all): {row.parameter.replace('_', ' ')} "
        f"with {row.share_percent:.0f} % of the square"
    )


def _step(row: Any) -> str:
    return (
        f"{row.quantity}: {row.parameter.replace('_', ' ')} {row.value} to {row.step_to}, "
        f"from {row.total_error:.2g} to {row.error_after:.2g} for {row.seconds_more:+.1f} s"
    )


def _preset(name: str, rows: pd.DataFrame) -> str:
    whole = rows[rows.parameter == CHAIN]
    if (whole.outcome != CONVERGED).any():
        return f"{name}: {whole.outcome.iloc[0]}"
    errors = ", ".join(f"{q} {e:.2g}" for q, e in zip(whole["quantity"], whole.error))
    return f"{name}: {errors}, about {whole.seconds.iloc[0]:.0f} s"
