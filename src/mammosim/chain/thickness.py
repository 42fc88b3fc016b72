"""How thick a pressed breast is at every place between the plates: what an X-ray has to go through."""

import numpy as np
import pandas as pd

from mammosim.core.errors import MeshError
from mammosim.core.mesh import SUBTRIANGLES, TetMesh
from mammosim.io.compiled import njit
from mammosim.mechanics.paddles import Plates

COLUMNS = ["outward_mm", "across_mm", "thickness_mm"]


def thickness_map(mesh: TetMesh, plates: Plates, *, pixel_mm: float = 2.0) -> pd.DataFrame:
    """COLUMNS of the places under the paddle where there is tissue, a pixel apart.

    mesh: in its pressed shape. outward_mm: from the plates' chest edge; across_mm: from their middle;
    thickness_mm: from the lowest to the highest point of the body there, along the normal of the support.
    Raises MeshError when no tissue is there.
    """
    half, shift = plates.half_sizes, np.array([plates.half_sizes[0], 0.0, 0.0])
    counts = np.rint(2 * half[:2] / pixel_mm).astype(int)
    outward = (np.arange(counts[0]) + 0.5) * pixel_mm
    across = (np.arange(counts[1]) + 0.5 - counts[1] / 2) * pixel_mm
    places = (mesh.points - plates.centre) @ plates.axes + shift
    faces = np.vstack(list(mesh.boundaries.values()))[:, SUBTRIANGLES].reshape(-1, 3)
    low, high = _extent(places[faces], outward, across)
    found = np.nonzero(high > low)
    if len(found[0]) == 0:
        raise MeshError("no tissue lies between the plates; move their centre, or enlarge them")
    return pd.DataFrame(
        dict(zip(COLUMNS, (outward[found[0]], across[found[1]], high[found] - low[found]), strict=True))
    )


@njit(cache=True)
def _extent(triangles: np.ndarray, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The least and greatest third coordinate (n_u, n_v) of triangles (n, 3, 3) over the places u, v."""
    low, high = np.full((len(u), len(v)), np.inf), np.full((len(u), len(v)), -np.inf)
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
                    w = a * p[2] + b * q[2] + (1 - a - b) * r[2]
                    low[i, j], high[i, j] = min(low[i, j], w), max(high[i, j], w)
    return low, high
