"""How good the elements are, and whether a mesh can be computed with at all."""

import numpy as np
import pandas as pd
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from mammosim.core.errors import MeshError
from mammosim.core.mesh import EDGES, FACES, TetMesh

# Below this mean ratio an element counts as flat: a regular one that was squeezed to 1/50 of its height.
FLAT = 0.05
NAMED_CELLS = 5

_CORNERS = np.eye(4)
_MIDDLES = _CORNERS[np.array(EDGES)].mean(axis=1)
# The 4-point rule of degree 2 (Hammer and Stroud 1956), barycentric.
_GAUSS = np.full((4, 4), (5 - np.sqrt(5)) / 20) + np.eye(4) * np.sqrt(5) / 5


def quality(mesh: TetMesh) -> pd.DataFrame:
    """One row per cell.

    volume_mm3: by the 4-point rule. mean_ratio: 12 (3 V)^(2/3) over the sum of squared edges, and
    aspect_ratio: longest edge over 2 sqrt(6) inradius, both of the straight element, 1 when it is regular.
    smallest_J: least det dX/dxi at the ten nodes and four Gauss points, over its value in the straight
    element: 1 when the edges are straight, not positive when the element is inverted.
    """
    x = mesh.points[mesh.cells]
    a, b = np.array(EDGES).T
    edges = np.linalg.norm(x[:, b] - x[:, a], axis=2)
    straight = np.linalg.det(x[:, 1:4] - x[:, :1])
    dets = jacobians(x, np.vstack([_CORNERS, _MIDDLES, _GAUSS]))
    area = sum(
        np.linalg.norm(np.cross(x[:, f[1]] - x[:, f[0]], x[:, f[2]] - x[:, f[0]]), axis=1) / 2 for f in FACES
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        return pd.DataFrame(
            {
                "cell": np.arange(len(x)),
                "volume_mm3": dets[:, -4:].mean(axis=1) / 6,
                "mean_ratio": 12 * np.cbrt(straight / 2) ** 2 * np.sign(straight) / (edges**2).sum(axis=1),
                "aspect_ratio": edges.max(axis=1) * area / (np.sqrt(6) * np.abs(straight)),
                "smallest_J": dets.min(axis=1) / np.abs(straight),
            }
        )


def jacobians(x: np.ndarray, L: np.ndarray) -> np.ndarray:
    """det dx/dxi (n_cell, q) of elements with nodes x (n_cell, 10, 3) at barycentric L (q, 4), xi = L[1:]."""
    dL = np.vstack([-np.ones(3), np.eye(3)])
    a, b = np.array(EDGES).T
    corners = (4 * L - 1)[:, :, None] * dL
    edges = 4 * (L[:, a, None] * dL[b] + L[:, b, None] * dL[a])
    return np.linalg.det(np.einsum("cad,qae->cqde", x, np.concatenate([corners, edges], axis=1)))


def require_sound(mesh: TetMesh) -> None:
    """Raise MeshError when a mesh cannot be computed with, naming how many cells or nodes and which.

    Not finite coordinates, unattached nodes, inverted or flat elements, several pieces, empty boundaries.
    """
    _refuse(~np.isfinite(mesh.points).all(axis=1), "nodes have coordinates that are not finite")
    _refuse(np.bincount(mesh.cells.ravel(), minlength=len(mesh.points)) == 0, "nodes belong to no cell")
    table = quality(mesh)
    _refuse(~(table["smallest_J"].to_numpy() > 0), "cells are inverted")
    _refuse(~(table["mean_ratio"].to_numpy() > FLAT), f"cells are flat (mean ratio below {FLAT:g})")
    _require_one_piece(mesh)
    for name, faces in mesh.boundaries.items():
        if len(faces) == 0:
            raise MeshError(f"boundary {name!r} has no faces; check the labels around the tissue")


def _refuse(bad: np.ndarray, what: str) -> None:
    if bad.any():
        which = np.flatnonzero(bad)
        named = ", ".join(map(str, which[:NAMED_CELLS])) + (", ..." if len(which) > NAMED_CELLS else "")
        raise MeshError(f"{len(which)} {what}: {named}; mesh again with smoother labels or smaller elements")


def _require_one_piece(mesh: TetMesh) -> None:
    n = len(mesh.points)
    first, others = np.repeat(mesh.cells[:, 0], 9), mesh.cells[:, 1:].ravel()
    pieces, number = connected_components(coo_array((np.ones(len(first)), (first, others)), shape=(n, n)))
    if pieces > 1:
        sizes = ", ".join(map(str, sorted(np.bincount(number), reverse=True)[:NAMED_CELLS]))
        raise MeshError(f"the mesh falls into {pieces} pieces of {sizes} nodes; keep the largest one only")
