"""Material points inside quadratic tetrahedra: integrals over a body that belong to both of its shapes."""

from dataclasses import dataclass

import numpy as np

from mammosim.core.mesh import EDGES, SUBTETRAHEDRA, TetMesh

# Barycentric coordinates (10, 4) of the nodes of a quadratic tetrahedron.
NODES = np.vstack([np.eye(4), [(np.eye(4)[a] + np.eye(4)[b]) / 2 for a, b in EDGES]])
# The 4-point rule of degree 2 (Hammer & Stroud 1956), barycentric; all weights 1/4.
FOUR_POINTS = np.full((4, 4), (5 - np.sqrt(5)) / 20) + np.eye(4) * np.sqrt(5) / 5


@dataclass(frozen=True)
class MaterialVolume:
    """Sample points of a body: cell (n,), N (n_point, 10) per cell, dV and dv (n,) mm3 in its two shapes."""

    cell: np.ndarray
    N: np.ndarray
    dV: np.ndarray
    dv: np.ndarray

    def carry(self, mesh: TetMesh, points: np.ndarray) -> np.ndarray:
        """Where the sample points are, (n, 3), when the nodes of `mesh` are at points (n_node, 3)."""
        found: np.ndarray = np.einsum("qa,cad->cqd", self.N, points[mesh.cells]).reshape(-1, 3)
        return found


def material_volume(mesh: TetMesh, reference: np.ndarray) -> MaterialVolume:
    """32 points in each cell, 4 in each of its 8 parts, which resolve sharp borders: a box, a label.

    mesh: in its deformed shape x; reference: X (n_node, 3) mm. dV = w det(dX/dxi), dv = w det(dx/dxi): the
    sum of dv over a part of the body is the integral of J dV.
    """
    parts = NODES[np.array(SUBTETRAHEDRA)]
    L = np.einsum("qv,svd->sqd", FOUR_POINTS, parts).reshape(-1, 4)
    N, dN = _shape_functions(L)
    weight = 1 / 6 / len(L)
    dV, dv = (
        weight * np.linalg.det(np.einsum("cad,qae->cqde", shape[mesh.cells], dN)).ravel()
        for shape in (reference, mesh.points)
    )
    return MaterialVolume(np.repeat(np.arange(len(mesh.cells)), len(L)), N, dV, dv)


def _shape_functions(L: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """N (q, 10) and dN/dxi (q, 10, 3) at barycentric coordinates L (q, 4): xi = L[1:]."""
    a, b = np.array(EDGES).T
    N = np.hstack([L * (2 * L - 1), 4 * L[:, a] * L[:, b]])
    dL = np.vstack([-np.ones(3), np.eye(3)])
    corners = (4 * L - 1)[:, :, None] * dL
    edges = 4 * (L[:, a, None] * dL[b] + L[:, b, None] * dL[a])
    return N, np.concatenate([corners, edges], axis=1)
