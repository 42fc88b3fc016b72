"""How good the elements are, and whether a mesh can be computed with at all."""

import numpy as np
import pandas as pd
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from skfem.element import ElementTetP2
from skfem.quadrature import get_quadrature
from skfem.refdom import RefTet

from mammosim.core.errors import MeshError
from mammosim.core.mesh import EDGES, FACES, TetMesh

# Below this mean ratio an element counts as flat: a regular one that was squeezed to 1/50 of its height.
FLAT = 0.05
NAMED_CELLS = 5

_ELEMENT = ElementTetP2()
# The ten nodes and then four Gauss points of degree 2, barycentric.
_XI = np.vstack([_ELEMENT.doflocs, get_quadrature(RefTet, 2)[0].T])
_POINTS = np.column_stack([1 - _XI.sum(axis=1), _XI])


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
    dets = jacobians(x, _POINTS)
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
    dN = np.stack([_ELEMENT.lbasis(L.T[1:], a)[1] for a in range(10)])
    return np.linalg.det(np.einsum("cad,aeq->cqde", x, dN))


def require_sound(mesh: TetMesh) -> None:
    """Raise MeshError when a mesh cannot be computed with, naming how many cells or nodes and which.

    Not finite coordinates, unattached nodes, inverted or flat elements, empty boundaries, several pieces of
    which nothing holds one.
    """
    _reject(~np.isfinite(mesh.points).all(axis=1), "nodes have coordinates that are not finite")
    _reject(np.bincount(mesh.cells.ravel(), minlength=len(mesh.points)) == 0, "nodes belong to no cell")
    table = quality(mesh)
    _reject(~(table["smallest_J"].to_numpy() > 0), "cells are inverted")
    _reject(~(table["mean_ratio"].to_numpy() > FLAT), f"cells are flat (mean ratio below {FLAT:g})")
    for name, faces in mesh.boundaries.items():
        if len(faces) == 0:
            raise MeshError(f"boundary {name!r} has no faces; check the labels around the tissue")
    _require_held(mesh)


def _reject(bad: np.ndarray, what: str) -> None:
    if bad.any():
        which = np.flatnonzero(bad)
        named = ", ".join(map(str, which[:NAMED_CELLS])) + (", ..." if len(which) > NAMED_CELLS else "")
        raise MeshError(f"{len(which)} {what}: {named}; mesh again with smoother labels or smaller elements")


def _require_held(mesh: TetMesh) -> None:
    """One piece; or several, each with nodes of the boundary `posterior`."""
    n = len(mesh.points)
    first, others = np.repeat(mesh.cells[:, 0], 9), mesh.cells[:, 1:].ravel()
    pieces, number = connected_components(coo_array((np.ones(len(first)), (first, others)), shape=(n, n)))
    free = np.setdiff1d(number, number[mesh.boundaries.get("posterior", np.zeros((0, 6), int))])
    if pieces > 1 and len(free):
        sizes = ", ".join(map(str, sorted(np.bincount(number), reverse=True)[:NAMED_CELLS]))
        raise MeshError(
            f"the mesh falls into {pieces} pieces of {sizes} nodes, of which {len(free)} are not held; "
            "keep the largest one only"
        )
