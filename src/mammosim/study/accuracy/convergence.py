"""Observed order of convergence, and what the finest size itself still leaves.

    a(h) = a_0 + c h^p,    d(h) = |a(h) - a(r)| = |c| |h^p - r^p|,    left = |c| r^p

The distances d from the finest size r can be measured; a_0, at size zero, cannot, and is extrapolated from
all of them, each telling a c of its own. Where no order is observed, values differ, but not by their size:
then left = (mean d^2)^(1/2).
"""

# After Eca & Hoekstra, J Comput Phys 262:104 (2014): sequences with scatter, orders that are not observed.

from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares

LEAST, MOST = 0.5, 2.0  # orders that are extrapolated with; a higher one is taken as the second
ORDERS = (-6.0, 8.0)  # that are looked for; below zero, steps grow towards the finest size


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

    found = least_squares(misfit, x0=[1.0], bounds=ORDERS, xtol=1e-12, ftol=1e-12)
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
