"""What accuracy costs: error and processor time of every value of every parameter.

With v and r the answers of a value and of the reference, the finest that has an answer, in n and m repeats:

    noise^2  = var v / n + var r / m,  or var(v - r) / n of repeats with the same random streams
    distance = max(|mean v - mean r|^2 - noise^2, 0)^(1/2)
    error    = distance + left of a deterministic parameter,  (var v + distance^2)^(1/2) of a stochastic one
    error ~ size^p,  seconds ~ size^-q

left is what the reference itself leaves, extrapolated to size zero (study.accuracy.convergence).
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy.optimize import least_squares

from mammosim.chain.quantities import quantities
from mammosim.core.errors import ConfigurationError
from mammosim.study.accuracy.trial import ANSWERS, CONVERGED

KEY = ["stage", "parameter", "value", "quantity"]
COLUMNS = [*KEY, "error", "seconds", "memory_mb", "distance", "left", "noise", "seconds_spread", "repeats",
           "size", "stochastic", "today", "reference", "outcome", "settings"]  # fmt: skip
LEAST, MOST = 0.5, 2.0  # orders that are extrapolated with; a higher one is taken as the second
SOUGHT = (-6.0, 8.0)  # that are looked for; below zero, steps grow towards the finest size
ABOVE_NOISE = 2.0  # distances that many times the noise are fitted
ORDERS = ["stage", "parameter", "quantity", "order", "order_se", "order_taken", "exponent", "exponent_se",
          "points"]  # fmt: skip


def accuracy(rows: pd.DataFrame) -> pd.DataFrame:
    """COLUMNS of the rows of study.accuracy.trial.Trial, a line per parameter, value and quantity, in order.

    error, distance, left and noise in the unit of the quantity's name; NaN where the value has no answer,
    or there is no other. left: 0 of a stochastic parameter, and of one without sizes.
    seconds: median of the repeats; seconds_spread: half their range.
    Raises ConfigurationError for a parameter without reference.
    """
    rows = rows.assign(value=[v if isinstance(v, str) else f"{v:g}" for v in rows.value])
    found = []
    for (parameter, quantity), of_parameter in rows.groupby(["parameter", "quantity"], sort=False):
        if of_parameter.value.nunique() > 1 and not of_parameter.reference.any():
            raise ConfigurationError(
                f"the parameter {parameter} lacks the row of its reference for {quantity}; make it"
            )
        of_parameter = _referred(of_parameter)
        reference = of_parameter[of_parameter.reference]
        lines = pd.DataFrame(
            [_line(of_value, reference) for _, of_value in of_parameter.groupby("value", sort=False)]
        )
        found.append(_with_left(lines))
    return pd.concat(found, ignore_index=True)[COLUMNS]


def _referred(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows of one parameter and quantity, with the finest value that has an answer as the reference."""
    if not rows.reference.any():
        return rows
    answered = rows.groupby("value", sort=False).outcome.agg(lambda outcome: (outcome == CONVERGED).all())
    return rows.assign(reference=rows.value.isin(answered.index[answered][-1:]))


def _line(rows: pd.DataFrame, reference: pd.DataFrame) -> dict:
    """One line of `accuracy`."""
    first = rows.iloc[0]
    unanswered = rows[rows.outcome != CONVERGED]
    distance, scatter, noise = _distance(rows, reference, stochastic=bool(first.stochastic))
    return {name: first[name] for name in (*KEY, "size", "stochastic", "today", "reference", "settings")} | {
        "error": np.hypot(distance, scatter),
        "distance": distance,
        "noise": noise,
        "seconds": float(rows.seconds.median()),
        "seconds_spread": float(rows.seconds.max() - rows.seconds.min()) / 2,
        "memory_mb": float(rows.memory_mb.max()),
        "repeats": len(rows),
        "outcome": CONVERGED if unanswered.empty else str(unanswered.outcome.iloc[0]),
    }


def _distance(rows: pd.DataFrame, reference: pd.DataFrame, *, stochastic: bool) -> tuple[float, float, float]:
    """distance, (var v)^(1/2) of a stochastic parameter, and noise, see above."""
    if reference.empty or (rows.outcome != CONVERGED).any():
        return np.nan, np.nan, np.nan
    v, r = _answers(rows), _answers(reference)
    scale = _unit(str(rows["quantity"].iloc[0]), r.mean(axis=0))
    paired = not stochastic and len(v) == len(r)
    noise2 = _variance(v - r) / len(v) if paired else _variance(v) / len(v) + _variance(r) / len(r)
    distance2 = max(float(np.sum((v.mean(axis=0) - r.mean(axis=0)) ** 2)) - noise2, 0.0)
    scatter2 = _variance(v) if stochastic else 0.0
    distance, scatter, noise = scale * np.sqrt([distance2, scatter2, noise2])
    return float(distance), float(scatter), float(noise)


def _with_left(lines: pd.DataFrame) -> pd.DataFrame:
    """The lines of one parameter and quantity with what the reference leaves added to the error of each."""
    lines["left"] = 0.0
    if lines.stochastic.any() or lines["size"].isna().any() or not lines.reference.any():
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

    p over values whose distance from the reference stands above the noise, q over all that have an answer.
    NaN for fewer than two points; without an error for two. order_taken: by which `left` is extrapolated.
    """
    found = []
    for (stage, parameter, quantity), rows in table.groupby(["stage", "parameter", "quantity"], sort=False):
        rows = rows[np.isfinite(rows["size"].astype(float)) & (rows.outcome == CONVERGED)]
        if len(rows) < 2:
            continue
        p, p_se, points = _order(rows)
        q, q_se = slope(rows["size"], rows.seconds)
        taken = np.nan if rows.stochastic.any() else order_taken(p)
        found.append((stage, parameter, quantity, p, p_se, taken, -q, q_se, points))
    return pd.DataFrame(found, columns=ORDERS)


def _order(rows: pd.DataFrame) -> tuple[float, float, int]:
    """p, its standard error, and how many of the values of one parameter and quantity are fitted."""
    if rows.stochastic.any():
        fitted = rows[rows.error > 0]
        return (*slope(fitted["size"], fitted.error), len(fitted))
    fitted = rows[~rows.reference & (rows.distance > ABOVE_NOISE * rows.noise)]
    r = rows["size"][rows.reference]
    if r.empty:
        return float("nan"), float("nan"), 0
    return (*order(fitted["size"], fitted.distance, float(r.iloc[0])), len(fitted))


def order(h: Sequence[float], d: Sequence[float], r: float) -> tuple[float, float]:
    """p of distances d > 0 at sizes h > r, by least squares of ln d, and its standard error.

    NaN for fewer than two sizes; without an error for two.
    """
    x, b = np.log(np.asarray(h, float) / r), np.log(np.asarray(d, float))
    if len(np.unique(x)) < 2:
        return float("nan"), float("nan")

    def misfit(p: np.ndarray) -> np.ndarray:
        predicted = np.log(np.expm1(p * x) / p) if abs(p[0]) > 1e-9 else np.log(x)
        return centred(b - predicted)

    found = least_squares(misfit, x0=[1.0], bounds=SOUGHT, xtol=1e-12, ftol=1e-12)
    freedom = len(x) - 2
    J2 = float((found.jac**2).sum())
    error = float(np.sqrt(2 * found.cost / freedom / J2)) if freedom else float("nan")
    return float(found.x[0]), error


def centred(x: np.ndarray) -> np.ndarray:
    """Without its mean."""
    return x - x.mean()


def order_taken(p: float) -> float:
    """The order that is extrapolated with, where p was observed; NaN where none was."""
    return min(p, MOST) if p >= LEAST else float("nan")


def left(h: Sequence[float], d: Sequence[float], r: float, p: float) -> float:
    """What the finest size r leaves, from the distances d at sizes h > r and the order p that is taken.

    p: NaN where none is; else the mean of c with its standard error on top, times r^p.
    """
    away = np.asarray(d, float)
    if np.isnan(p):
        return float(np.sqrt(np.mean(away**2)))
    c = away / (np.asarray(h, float) ** p - r**p)
    error = c.std(ddof=1) / np.sqrt(len(c)) if len(c) > 1 else 0.0
    return float((c.mean() + error) * r**p)


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
