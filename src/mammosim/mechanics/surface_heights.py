"""Heights of the underside of a closed surface, by vertical rays that must enter and leave it once."""

import numpy as np
from scipy.ndimage import distance_transform_edt

from mammosim.core.errors import MechanicsError
from mammosim.io.compiled import njit
from mammosim.io.surfaces import ClosedSurface

# Rays pass beside the given places by this much, so that none meets an edge or a corner of a triangle.
_ASIDE_MM = np.array([0.6180e-4, 0.7321e-4])
# Corners of the outline may be round: so much of what is asked may lie beside the surface.
_MOST_BESIDE = 0.05


def faces_below(surface: ClosedSurface, u: np.ndarray, v: np.ndarray, *, name: str) -> np.ndarray:
    """z (n, m) mm of the underside over x = u (n,) and y = v (m,), both ascending; beside it, of the nearest.

    Raises MechanicsError, which calls the surface `name`, where a ray enters it more than once, so that it
    overhangs or meets itself, or where too much of what is asked is beside it.
    """
    x, y = u + _ASIDE_MM[0], v + _ASIDE_MM[1]
    entered, left, below, above = _crossings(surface.corners, x, y)
    wrong = (entered > 1) | (left > 1) | (entered != left) | ((entered > 0) & ~(below < above))
    if wrong.any():
        i, j = np.argwhere(wrong)[0]
        raise MechanicsError(
            f"the surface of {name} overhangs or meets itself at x = {u[i]:.0f}, y = {v[j]:.0f} mm, where "
            f"a ray from below enters it {max(entered[i, j], left[i, j])} times: draw it without undercuts, "
            "z away from the breast"
        )
    beside = entered == 0
    if beside.mean() > _MOST_BESIDE:
        raise MechanicsError(
            f"the surface of {name} has holes, or is no rectangle seen from above: {100 * beside.mean():.0f} "
            f"% of the plate are not covered, at most {100 * _MOST_BESIDE:.0f} %"
        )
    nearest = distance_transform_edt(beside, return_distances=False, return_indices=True)
    heights: np.ndarray = below[tuple(nearest)]
    return heights


@njit(cache=True)
def _crossings(
    triangles: np.ndarray, u: np.ndarray, v: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """How often a ray upward at u, v enters and leaves, and where it does first and last, (n_u, n_v) each."""
    shape = (len(u), len(v))
    entered, left = np.zeros(shape, np.int64), np.zeros(shape, np.int64)
    below, above = np.full(shape, np.inf), np.full(shape, -np.inf)
    for t in range(len(triangles)):
        p, q, r = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        area = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
        if area == 0.0:
            continue
        i0, i1 = np.searchsorted(u, min(p[0], q[0], r[0])), np.searchsorted(u, max(p[0], q[0], r[0]))
        j0, j1 = np.searchsorted(v, min(p[1], q[1], r[1])), np.searchsorted(v, max(p[1], q[1], r[1]))
        for i in range(i0, i1):
            for j in range(j0, j1):
                a = ((q[0] - u[i]) * (r[1] - v[j]) - (q[1] - v[j]) * (r[0] - u[i])) / area
                b = ((r[0] - u[i]) * (p[1] - v[j]) - (r[1] - v[j]) * (p[0] - u[i])) / area
                if a >= 0 and b >= 0 and a + b <= 1:
                    z = a * p[2] + b * q[2] + (1 - a - b) * r[2]
                    if area < 0:
                        entered[i, j] += 1
                        below[i, j] = min(below[i, j], z)
                    else:
                        left[i, j] += 1
                        above[i, j] = max(above[i, j], z)
    return entered, left, below, above
