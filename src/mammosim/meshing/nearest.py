"""The nearest point of a triangle surface."""

import numpy as np
from scipy.spatial import cKDTree

from mammosim.io.compiled import njit
from mammosim.meshing.lattice import dot

# Of triangles whose squared distances differ by less than this factor the first counts as the nearest, so
# that the last bit does not choose between two that are equally far.
NEARER = 1 - 1e-12


class NearestOnTriangles:
    """Exact nearest points on triangles with corners (m, 3, 3) mm."""

    def __init__(self, corners: np.ndarray) -> None:
        self.corners = np.ascontiguousarray(corners, dtype=float)
        centres = self.corners.mean(axis=1)
        self._radius = np.linalg.norm(self.corners - centres[:, None], axis=2).max()
        self._tree = cKDTree(centres)

    def __call__(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Nearest point (n, 3) on any triangle and the number (n,) of that triangle, for points (n, 3)."""
        points = np.ascontiguousarray(points, dtype=float)
        _, first = self._tree.query(points)
        start = np.arange(len(points) + 1)
        bound = np.linalg.norm(_nearest(points, self.corners, start, first)[0] - points, axis=1)
        # A triangle that comes nearer has its centre within the bound plus the largest circumradius.
        near = self._tree.query_ball_point(points, bound + self._radius * (1 + 1e-9), return_sorted=True)
        start = np.concatenate([[0], np.cumsum([len(n) for n in near])])
        return _nearest(points, self.corners, start, np.concatenate(near).astype(np.int64))


@njit(cache=True)
def _nearest(
    points: np.ndarray, corners: np.ndarray, start: np.ndarray, candidates: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    nearest = np.empty_like(points)
    which = np.empty(len(points), dtype=np.int64)
    for n in range(len(points)):
        smallest = np.inf
        for c in range(start[n], start[n + 1]):
            t = candidates[c]
            q = _nearest_on_triangle(points[n], corners[t, 0], corners[t, 1], corners[t, 2])
            d = np.sum((q - points[n]) ** 2)
            if d < smallest * NEARER:
                smallest = d
                nearest[n] = q
                which[n] = t
    return nearest, which


@njit(cache=True)
def _nearest_on_triangle(p: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """By the Voronoi region of p: corners, then edges, then the face (Ericson 2005, section 5.1.5)."""
    ab, ac, ap, bp, cp = b - a, c - a, p - a, p - b, p - c
    d1, d2 = dot(ab, ap), dot(ac, ap)
    d3, d4 = dot(ab, bp), dot(ac, bp)
    d5, d6 = dot(ab, cp), dot(ac, cp)
    if d1 <= 0 and d2 <= 0:
        return a
    if d3 >= 0 and d4 <= d3:
        return b
    if d6 >= 0 and d5 <= d6:
        return c
    vc, vb, va = d1 * d4 - d3 * d2, d5 * d2 - d1 * d6, d3 * d6 - d5 * d4
    if vc <= 0 and d1 >= 0 and d3 <= 0:
        return a + ab * (d1 / (d1 - d3))
    if vb <= 0 and d2 >= 0 and d6 <= 0:
        return a + ac * (d2 / (d2 - d6))
    if va <= 0 and d4 - d3 >= 0 and d5 - d6 >= 0:
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))
    return a + ab * (vb / (va + vb + vc)) + ac * (vc / (va + vb + vc))
