"""The deformation of a body continued beyond its meshed skin, to points that the skin carries."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation
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
        near = _in_blocks_around(self.c, x, reach_mm)
        distance, i = cKDTree(self.c).query(x[near], distance_upper_bound=reach_mm)
        reached = np.isfinite(distance)
        near[near] = reached
        i = i[reached]
        inverse = np.linalg.inv(self.A)[i]
        return near, self.C[i] + np.einsum("nij,nj->ni", inverse, x[near] - self.c[i])


def skin_map(mesh: TetMesh, x: np.ndarray) -> SkinMap:
    """The map of a mesh whose points are the reference, loaded to x (n_node, 3)."""
    # ASSUME: what lies above the meshed skin, as the nipple's tip, moves with the skin below it.
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


def _in_blocks_around(c: np.ndarray, x: np.ndarray, reach_mm: float) -> np.ndarray:
    """Whether x (m, 3) lies in the same block, of edge reach_mm, as any c (n, 3), or in one beside it."""
    low = c.min(axis=0) - 2 * reach_mm
    shape = tuple(((c.max(axis=0) - low) // reach_mm).astype(int) + 3)
    occupied = np.zeros(shape, bool)
    occupied[tuple(((c - low) // reach_mm).astype(int).T)] = True
    occupied = binary_dilation(occupied, np.ones((3, 3, 3), bool))
    block = np.clip((x - low) // reach_mm, 0, np.array(shape) - 1).astype(int)
    return occupied[block[:, 0], block[:, 1], block[:, 2]]


def _frame(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two edges (n, 2, 3) of triangles (n, 3, 3) and their cross product (n, 3)."""
    edges = corners[:, 1:] - corners[:, :1]
    return edges, np.cross(edges[:, 0], edges[:, 1])
