"""A height that was sampled on a grid, as a smooth function: a bicubic spline with exact derivatives.

w(y) = sum_ij c_ij B(s_0 - i) B(s_1 - j),  s = (y - origin) / spacing,  B the cubic B-spline
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import spline_filter

from mammosim.io.compiled import njit, prange


@dataclass(frozen=True)
class HeightMap:
    """origin (2,) mm of the first sample; spacing (2,) mm; coefficients (n, m) of the spline, mm.

    A Deflection. Beyond its samples it goes on level.
    """

    origin: np.ndarray
    spacing: np.ndarray
    coefficients: np.ndarray

    @classmethod
    def through(cls, origin: np.ndarray, spacing: np.ndarray, heights: np.ndarray) -> "HeightMap":
        """The spline through heights (n, m) mm; n and m are 4 or more."""
        return cls(origin, spacing, spline_filter(heights, order=3, mode="mirror"))

    def at(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """w (n,) mm, grad w (n, 2), and its second derivatives (n, 2, 2) 1/mm at y (n, 2) mm."""
        found = _evaluated((y - self.origin) / self.spacing, self.coefficients)
        h = self.spacing
        slope = found[:, 1:3] / h
        second = np.stack([found[:, 3:5], found[:, 4:6]], axis=1) / np.outer(h, h)
        return found[:, 0], slope, second


@njit(cache=True, inline="always")
def _weights(f: float, b: np.ndarray, db: np.ndarray, ddb: np.ndarray) -> None:
    """B and its two derivatives at the four samples around a place, f beyond the second of them."""
    g = 1.0 - f
    b[0], b[3] = g**3 / 6, f**3 / 6
    b[1], b[2] = 2 / 3 - f**2 * (2 - f) / 2, 2 / 3 - g**2 * (2 - g) / 2
    db[0], db[3] = -(g**2) / 2, f**2 / 2
    db[1], db[2] = f * (1.5 * f - 2), -g * (1.5 * g - 2)
    ddb[0], ddb[3] = g, f
    ddb[1], ddb[2] = 3 * f - 2, 3 * g - 2


@njit(cache=True, parallel=True)
def _evaluated(places: np.ndarray, c: np.ndarray) -> np.ndarray:
    """w, w_0, w_1, w_00, w_01, w_11 (n, 6) by places in samples (n, 2)."""
    found = np.zeros((len(places), 6))
    shape = c.shape
    for t in prange(len(places)):
        b, db, ddb = np.empty((2, 4)), np.empty((2, 4)), np.empty((2, 4))
        first, within = np.empty(2, np.int64), np.empty(2)
        for k in range(2):
            s = min(max(places[t, k], 0.0), shape[k] - 1.0)
            within[k] = 1.0 if s == places[t, k] else 0.0
            first[k] = min(int(s), shape[k] - 2)
            _weights(s - first[k], b[k], db[k], ddb[k])
        for i in range(4):
            # mirrored at the first and at the last sample
            p = abs(first[0] + i - 1)
            p = min(p, 2 * (shape[0] - 1) - p)
            for j in range(4):
                q = abs(first[1] + j - 1)
                q = min(q, 2 * (shape[1] - 1) - q)
                found[t, 0] += c[p, q] * b[0, i] * b[1, j]
                found[t, 1] += c[p, q] * db[0, i] * b[1, j] * within[0]
                found[t, 2] += c[p, q] * b[0, i] * db[1, j] * within[1]
                found[t, 3] += c[p, q] * ddb[0, i] * b[1, j] * within[0]
                found[t, 4] += c[p, q] * db[0, i] * db[1, j] * within[0] * within[1]
                found[t, 5] += c[p, q] * b[0, i] * ddb[1, j] * within[1]
    return found
