"""Observed order of convergence, and what the finest size itself still leaves.

    a(h) = a_0 + c h^p,    d(h) = |a(h) - a(r)| = |c| |h^p - r^p|,    left = |c| r^p

The distances d from the finest size r can be measured; a_0, at size zero, cannot, and is extrapolated.
"""

# Roache, J Fluids Eng 116:405 (1994): without an order that was observed to hold, extrapolate with a low one.

from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares

# ASSUME: at least first order, as of a surface made of labelled voxels; nothing is trusted beyond second.
LEAST_ORDER, MOST_ORDER = 1.0, 2.0
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

    found = least_squares(misfit, x0=[LEAST_ORDER], bounds=ORDERS, xtol=1e-12, ftol=1e-12)
    freedom = len(x) - 2
    J2 = float((found.jac**2).sum())
    error = float(np.sqrt(2 * found.cost / freedom / J2)) if freedom else float("nan")
    return float(found.x[0]), error


def centred(x: np.ndarray) -> np.ndarray:
    """Without its mean."""
    return x - x.mean()


def left(h: float, d: float, r: float, p: float) -> float:
    """What the finest size r leaves, from the distance d of the next size h > r and the observed order p.

    p: NaN where none was observed; it is taken within LEAST_ORDER and MOST_ORDER.
    """
    p = float(np.clip(p, LEAST_ORDER, MOST_ORDER)) if np.isfinite(p) else LEAST_ORDER
    return d / ((h / r) ** p - 1)
