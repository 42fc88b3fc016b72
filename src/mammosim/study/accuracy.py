"""What accuracy costs: error against the reference and processor time of every value of every knob.

With v and r the answers of a value and of the reference in n and m repeats:

    noise^2 = var v / n + var r / m,  or var(v - r) / n of repeats with the same random streams
    bias^2  = max(|mean v - mean r|^2 - noise^2, 0)
    error   = bias of a deterministic knob,  (var v + bias^2)^(1/2) of a random one
    error ~ size^p,  seconds ~ size^-q
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from mammosim.core.errors import ConfigurationError
from mammosim.study.quantities import quantities
from mammosim.study.trial import ANSWERS, OK

KEY = ["stage", "knob", "value", "quantity"]
COLUMNS = [*KEY, "error", "seconds", "memory_mb", "noise", "seconds_spread", "repeats", "size", "random",
           "today", "reference", "outcome", "settings"]  # fmt: skip
ABOVE_NOISE = 2.0  # errors that many times the noise are fitted
ORDERS = ["stage", "knob", "quantity", "order", "order_se", "exponent", "exponent_se", "points"]


def accuracy(rows: pd.DataFrame) -> pd.DataFrame:
    """COLUMNS of the rows of study.trial.Trial, a line per knob, value and quantity, in their order.

    error and noise in the unit of the quantity's name; NaN where the value or the reference was refused, or
    there is no other value. seconds: median of the repeats; seconds_spread: half their range.
    Raises ConfigurationError for a knob without reference.
    """
    rows = rows.assign(value=[v if isinstance(v, str) else f"{v:g}" for v in rows.value])
    found = []
    for (knob, quantity), of_knob in rows.groupby(["knob", "quantity"], sort=False):
        reference = of_knob[of_knob.reference]
        alone = of_knob.value.nunique() == 1 and not of_knob.reference.any()
        if reference.empty and not alone:
            raise ConfigurationError(
                f"the knob {knob} lacks the row of its reference for {quantity}; make it"
            )
        for _, of_value in of_knob.groupby("value", sort=False):
            found.append(_line(of_value, reference))
    return pd.DataFrame(found, columns=COLUMNS)


def _line(rows: pd.DataFrame, reference: pd.DataFrame) -> dict:
    """One line of `accuracy`."""
    first = rows.iloc[0]
    refused = rows[rows.outcome != OK]
    error, noise = _error(rows, reference, random=bool(first.random))
    return {name: first[name] for name in (*KEY, "size", "random", "today", "reference", "settings")} | {
        "error": error if refused.empty else np.nan,
        "noise": noise if refused.empty else np.nan,
        "seconds": float(rows.seconds.median()),
        "seconds_spread": float(rows.seconds.max() - rows.seconds.min()) / 2,
        "memory_mb": float(rows.memory_mb.max()),
        "repeats": len(rows),
        "outcome": OK if refused.empty else str(refused.outcome.iloc[0]),
    }


def _error(rows: pd.DataFrame, reference: pd.DataFrame, *, random: bool) -> tuple[float, float]:
    """Error and noise, see above."""
    if reference.empty or (reference.outcome != OK).any():
        return np.nan, np.nan
    v, r = _answers(rows), _answers(reference)
    scale = _unit(str(rows["quantity"].iloc[0]), r.mean(axis=0))
    paired = not random and len(v) == len(r)
    noise2 = _variance(v - r) / len(v) if paired else _variance(v) / len(v) + _variance(r) / len(r)
    bias2 = max(float(np.sum((v.mean(axis=0) - r.mean(axis=0)) ** 2)) - noise2, 0.0)
    error2 = _variance(v) + bias2 if random else bias2
    return float(scale * np.sqrt(error2)), float(scale * np.sqrt(noise2))


def _answers(rows: pd.DataFrame) -> np.ndarray:
    """(n, 1) or (n, 3)."""
    values = rows[list(ANSWERS)].to_numpy(float)
    return values[:, ~np.all(np.isnan(values), axis=0)]


def _variance(v: np.ndarray) -> float:
    """Of the repeats, summed over coordinates; 0 of a single one."""
    return float(v.var(axis=0, ddof=1).sum()) if len(v) > 1 else 0.0


def _unit(quantity: str, reference: np.ndarray) -> float:
    """What a difference is multiplied with: percent of the reference where the quantity is relative."""
    relative = quantities([quantity])[quantity].relative
    return 100 / float(np.linalg.norm(reference)) if relative else 1.0


def orders(table: pd.DataFrame) -> pd.DataFrame:
    """ORDERS of `accuracy`: p of error ~ size^p and q of seconds ~ size^-q with standard errors.

    Fitted to logarithms: p over values above the noise, the reference left out where its error is zero by
    definition; q over all that were not refused. NaN for fewer than two points; without an error for two.
    """
    found = []
    for (stage, knob, quantity), rows in table.groupby(["stage", "knob", "quantity"], sort=False):
        rows = rows[np.isfinite(rows["size"].astype(float)) & (rows.outcome == OK)]
        if len(rows) < 2:
            continue
        fitted = rows[(rows.error > ABOVE_NOISE * rows.noise) | (rows.random & (rows.error > 0))]
        p, p_se = slope(fitted["size"], fitted.error)
        q, q_se = slope(rows["size"], rows.seconds)
        found.append((stage, knob, quantity, p, p_se, -q, q_se, len(fitted)))
    return pd.DataFrame(found, columns=ORDERS)


def slope(x: Sequence[float], y: Sequence[float]) -> tuple[float, float]:
    """Slope of ln y over ln x by least squares, and its standard error; NaN where they are not determined."""
    keep = (np.asarray(x, float) > 0) & (np.asarray(y, float) > 0)
    a, b = np.log(np.asarray(x, float)[keep]), np.log(np.asarray(y, float)[keep])
    if len(np.unique(a)) < 2:
        return float("nan"), float("nan")
    a = a - a.mean()
    p = float(a @ b / (a @ a))
    left = b - b.mean() - p * a
    error = float(np.sqrt(left @ left / (len(a) - 2) / (a @ a))) if len(a) > 2 else float("nan")
    return p, error


def on_front(seconds: Sequence[float], error: Sequence[float]) -> np.ndarray:
    """Whether nothing else is at least as fast and as accurate, and better in one of them; (n,) bool."""
    t, e = np.asarray(seconds, float), np.asarray(error, float)
    at_least = (t[:, None] >= t) & (e[:, None] >= e)
    better = (t[:, None] > t) | (e[:, None] > e)
    return np.isfinite(t) & np.isfinite(e) & ~np.any(at_least & better, axis=1)
