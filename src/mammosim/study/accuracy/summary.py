"""What the page of accuracy says in words."""

from typing import Any

import pandas as pd

from mammosim.chain.quantities import QUANTITIES
from mammosim.study.accuracy.presets import CHAIN
from mammosim.study.accuracy.trial import OK


def numbers(table: pd.DataFrame, shares: pd.DataFrame, presets: pd.DataFrame) -> dict[str, Any]:
    """accuracy.knobs, .trials, .refused, .seconds, .limits and .next: a phrase per quantity, .presets.

    table: of accuracy.errors; shares: of accuracy.error_budget; presets: of accuracy.preset_tables.
    """
    turned = table[table.knob != CHAIN]
    each = turned.groupby(["knob", "value"])
    values = {
        "knobs": int(turned.knob.nunique()),
        "trials": int(each.ngroups),
        "refused": int((each.outcome.first() != OK).sum()),
        "seconds": float((each.seconds.max() * each.repeats.max()).sum()),
        "chain_seconds": float(table.seconds[table.knob == CHAIN].max()),
        "limits": "; ".join(map(_limiting, shares[shares.limits].itertuples())) or "none",
        "next": "; ".join(map(_step, shares[shares["next"]].itertuples())) or "none",
        "presets": "; ".join(_preset(*each) for each in presets.groupby("preset", sort=False)) or "none",
    }
    return {f"accuracy.{name}": value for name, value in values.items()}


def _limiting(row: Any) -> str:
    words = QUANTITIES[row.quantity].words
    return (
        f"{words} ({row.quantity} {row.total_error:.2g} in all): {row.knob.replace('_', ' ')} "
        f"with {row.share_percent:.0f} % of the square"
    )


def _step(row: Any) -> str:
    return (
        f"{row.quantity}: {row.knob.replace('_', ' ')} {row.value} to {row.step_to}, "
        f"from {row.total_error:.2g} to {row.error_after:.2g} for {row.seconds_more:+.1f} s"
    )


def _preset(name: str, rows: pd.DataFrame) -> str:
    whole = rows[rows.knob == CHAIN]
    if (whole.outcome != OK).any():
        return f"{name}: {whole.outcome.iloc[0]}"
    errors = ", ".join(f"{q} {e:.2g}" for q, e in zip(whole["quantity"], whole.error))
    return f"{name}: {errors}, about {whole.seconds.iloc[0]:.0f} s"
