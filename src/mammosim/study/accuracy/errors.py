"""What accuracy costs: error and processor time of every value of every knob.

With v and r the answers of a value and of the reference, the finest that was not refused, in n and m repeats:

    noise^2  = var v / n + var r / m,  or var(v - r) / n of repeats with the same random streams
    distance = max(|mean v - mean r|^2 - noise^2, 0)^(1/2)
    error    = distance + left of a deterministic knob,  (var v + distance^2)^(1/2) of a random one
    error ~ size^p,  seconds ~ size^-q

left is what the reference itself leaves, extrapolated to size zero (study.accuracy.convergence).
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from mammosim.chain.quantities import quantities
from mammosim.core.errors import ConfigurationError
from mammosim.study.accuracy.convergence import left, order, order_taken
from mammosim.study.accuracy.trial import ANSWERS, OK

KEY = ["stage", "knob", "value", "quantity"]
COLUMNS = [*KEY, "error", "seconds", "memory_mb", "distance", "left", "noise", "seconds_spread", "repeats",
           "size", "random", "today", "reference", "outcome", "settings"]  # fmt: skip
ABOVE_NOISE = 2.0  # distances that many times the noise are fitted
ORDERS = ["stage", "knob", "quantity", "order", "order_se", "order_taken", "exponent", "exponent_se",
          "points"]  # fmt: skip


def accuracy(rows: pd.DataFrame) -> pd.DataFrame:
    """COLUMNS of the rows of study.accuracy.trial.Trial, a line per knob, value and quantity, in their order.

    error, distance, left and noise in the unit of the quantity's name; NaN where the value was refused, or
    there is no other. left: 0 where chance or no size tells the values of a knob apart.
    seconds: median of the repeats; seconds_spread: half their range.
    Raises ConfigurationError for a knob without reference.
    """
    rows = rows.assign(value=[v if isinstance(v, str) else f"{v:g}" for v in rows.value])
    found = []
    for (knob, quantity), of_knob in rows.groupby(["knob", "quantity"], sort=False):
        if of_knob.value.nunique() > 1 and not of_knob.reference.any():
            raise ConfigurationError(
                f"the knob {knob} lacks the row of its reference for {quantity}; make it"
            )
        of_knob = _referred(of_knob)
        reference = of_knob[of_knob.reference]
        lines = pd.DataFrame(
            [_line(of_value, reference) for _, of_value in of_knob.groupby("value", sort=False)]
        )
        found.append(_with_left(lines))
    return pd.concat(found, ignore_index=True)[COLUMNS]


def _referred(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows of one knob and quantity, with the finest value that was not refused as the reference."""
    if not rows.reference.any():
        return rows
    answered = rows.groupby("value", sort=False).outcome.agg(lambda outcome: (outcome == OK).all())
    return rows.assign(reference=rows.value.isin(answered.index[answered][-1:]))


def _line(rows: pd.DataFrame, reference: pd.DataFrame) -> dict:
    """One line of `accuracy`."""
    first = rows.iloc[0]
    refused = rows[rows.outcome != OK]
    distance, scatter, noise = _distance(rows, reference, random=bool(first.random))
    return {name: first[name] for name in (*KEY, "size", "random", "today", "reference", "settings")} | {
        "error": np.hypot(distance, scatter),
        "distance": distance,
        "noise": noise,
        "seconds": float(rows.seconds.median()),
        "seconds_spread": float(rows.seconds.max() - rows.seconds.min()) / 2,
        "memory_mb": float(rows.memory_mb.max()),
        "repeats": len(rows),
        "outcome": OK if refused.empty else str(refused.outcome.iloc[0]),
    }


def _distance(rows: pd.DataFrame, reference: pd.DataFrame, *, random: bool) -> tuple[float, float, float]:
    """distance, (var v)^(1/2) of a random knob, and noise, see above."""
    if reference.empty or (rows.outcome != OK).any():
        return np.nan, np.nan, np.nan
    v, r = _answers(rows), _answers(reference)
    scale = _unit(str(rows["quantity"].iloc[0]), r.mean(axis=0))
    paired = not random and len(v) == len(r)
    noise2 = _variance(v - r) / len(v) if paired else _variance(v) / len(v) + _variance(r) / len(r)
    distance2 = max(float(np.sum((v.mean(axis=0) - r.mean(axis=0)) ** 2)) - noise2, 0.0)
    scatter2 = _variance(v) if random else 0.0
    distance, scatter, noise = scale * np.sqrt([distance2, scatter2, noise2])
    return float(distance), float(scatter), float(noise)


def _with_left(lines: pd.DataFrame) -> pd.DataFrame:
    """The lines of one knob and quantity with what the reference leaves added to the error of each."""
    lines["left"] = 0.0
    if lines.random.any() or lines["size"].isna().any() or not lines.reference.any():
        return lines
    r = float(lines["size"][lines.reference].iloc[0])
    others = lines[(lines["size"] > r) & lines.distance.notna()]
    if others.empty:  # nothing is left that the reference could be compared with
        return lines.assign(error=np.nan, left=np.nan)
    # ASSUME: two values that noise cannot tell apart may differ by the noise.
    d = np.maximum(others.distance, others.noise)
    lines["left"] = left(others["size"], d, r, order_taken(_order(lines)[0]))
    return lines.assign(error=lines.error + lines.left)


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

    p over values whose distance from the reference stands above the noise, q over all that were not refused.
    NaN for fewer than two points; without an error for two. order_taken: by which `left` is extrapolated.
    """
    found = []
    for (stage, knob, quantity), rows in table.groupby(["stage", "knob", "quantity"], sort=False):
        rows = rows[np.isfinite(rows["size"].astype(float)) & (rows.outcome == OK)]
        if len(rows) < 2:
            continue
        p, p_se, points = _order(rows)
        q, q_se = slope(rows["size"], rows.seconds)
        taken = np.nan if rows.random.any() else order_taken(p)
        found.append((stage, knob, quantity, p, p_se, taken, -q, q_se, points))
    return pd.DataFrame(found, columns=ORDERS)


def _order(rows: pd.DataFrame) -> tuple[float, float, int]:
    """p, its standard error, and how many of the values of one knob and quantity are fitted."""
    if rows.random.any():
        fitted = rows[rows.error > 0]
        return (*slope(fitted["size"], fitted.error), len(fitted))
    fitted = rows[~rows.reference & (rows.distance > ABOVE_NOISE * rows.noise)]
    r = rows["size"][rows.reference]
    if r.empty:
        return float("nan"), float("nan"), 0
    return (*order(fitted["size"], fitted.distance, float(r.iloc[0])), len(fitted))


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
