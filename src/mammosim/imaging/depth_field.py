"""The surface r(a, b) of least cost in a volume: one depth in each column, neighbours almost as deep."""

import numpy as np


def depth_field(cost: np.ndarray, *, penalty: float, reach: int = 3) -> np.ndarray:
    """Index (na, nb) of the depth that minimises sum c(a, b, r) + penalty sum (r - r')^2 over neighbours.

    cost: (na, nb, nr), finite. Depths of neighbours differ by `reach` at most on each path. The sum of least
    costs over paths from four sides stands for the exact minimum (semi-global matching: Hirschmuller, IEEE
    Trans Pattern Anal Mach Intell 30:328, 2008).
    """
    c = np.asarray(cost, np.float32)
    total = -3 * c  # each of the four paths has the column's own cost
    for axis in (0, 1):
        along = np.moveaxis(c, axis, 0)
        for step in (1, -1):
            total += np.moveaxis(_path(along[::step], penalty, reach)[::step], 0, axis)
    return total.argmin(axis=2)


def _path(c: np.ndarray, penalty: float, reach: int) -> np.ndarray:
    """Least cost (n, m, nr) of a path from the first row: L = c + min_k (L'(r + k) + penalty k^2)."""
    L = c.copy()
    nr = c.shape[2]
    for row in range(1, len(c)):
        before = np.pad(L[row - 1], ((0, 0), (reach, reach)), constant_values=np.inf)
        moves = [
            before[:, reach + k : reach + k + nr] + np.float32(penalty * k * k)
            for k in range(-reach, reach + 1)
        ]
        best = np.min(moves, axis=0)
        L[row] += best - best.min(axis=1, keepdims=True)
    return L
