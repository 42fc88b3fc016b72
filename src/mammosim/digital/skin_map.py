"""The deformation of a body continued beyond its meshed skin, to points that the skin carries."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from mammosim.core.mesh import TetMesh

QUARTERS = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))  # of a quadratic triangle, as local node numbers


@dataclass(frozen=True)
class SkinMap:
    """x = c + A (X - C) near each quarter of a skin face, C and c its centres in the two configurations, mm.

    C, c (n, 3); A (n, 3, 3) stretches the quarter as its nodes moved, and its normal so that det A = 1;
    normals (n, 3): outward, in the loaded configuration.
    """

    C: np.ndarray
    c: np.ndarray
    A: np.ndarray
    normals: np.ndarray

    def pushed(self, X: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Loaded points (m, 3) of reference points X (m, 3) on the skin, and the normals there."""
        _, i = cKDTree(self.C).query(X)
        return self.c[i] + np.einsum("nij,nj->ni", self.A[i], X - self.C[i]), self.normals[i]

    def pulled(self, x: np.ndarray, reach_mm: float) -> tuple[np.ndarray, np.ndarray]:
        """Which loaded points x (m, 3) lie within reach of the skin (m,), and their reference points."""
        distance, i = cKDTree(self.c).query(x, distance_upper_bound=reach_mm)
        near = np.isfinite(distance)
        i = i[near]
        inverse = np.linalg.inv(self.A)[i]
        return near, self.C[i] + np.einsum("nij,nj->ni", inverse, x[near] - self.c[i])


def skin_map(mesh: TetMesh, x: np.ndarray) -> SkinMap:
    """The map of a mesh whose points are the reference, loaded to x (n_node, 3)."""
    # ASSUME: what lies above the meshed skin, as the nipple's tip, moves with the nearest skin, keeping volume.
    corners = mesh.boundaries["skin"][:, QUARTERS].reshape(-1, 3)
    T, N = _frame(mesh.points[corners])
    t, n = _frame(x[corners])
    area_ratio = np.linalg.norm(n, axis=1) / np.linalg.norm(N, axis=1)
    normals = n / np.linalg.norm(n, axis=1, keepdims=True)
    unit = N / np.linalg.norm(N, axis=1, keepdims=True)
    reference = np.concatenate([T, unit[:, None]], axis=1)
    loaded = np.concatenate([t, (normals / area_ratio[:, None])[:, None]], axis=1)
    A = np.moveaxis(np.linalg.solve(reference, loaded), 1, 2)
    return SkinMap(mesh.points[corners].mean(axis=1), x[corners].mean(axis=1), A, normals)


def _frame(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two edges (n, 2, 3) of triangles (n, 3, 3) and their cross product (n, 3)."""
    edges = corners[:, 1:] - corners[:, :1]
    return edges, np.cross(edges[:, 0], edges[:, 1])
