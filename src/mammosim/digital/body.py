"""What the scanner finds at each point of its grid: the material of a virtual patient in it."""

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from scipy.ndimage import binary_dilation
from scipy.spatial import cKDTree

from mammosim.core.fiducials import Fiducials
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.rigid import RigidTransform
from mammosim.core.volume import Grid
from mammosim.digital.anatomy import Anatomy
from mammosim.digital.markers import skin_normals, skin_points
from mammosim.digital.thorax import organs_at
from mammosim.meshing.raster import rasterise

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


SKIN_REACH_MM = (
    8.0  # how far from its centre a piece of skin carries points outside the mesh: chords, the nipple
)
SLIVER_MM = 3.0  # how deep under the skin its mesh may lie
EDGE_MM = 15.0  # how far from the region's cuts the mesh may be rounded off; the skin hardly moves there


class Body(Protocol):
    """A volunteer in the scanner: materials are codes of core.labels.Label and thorax.ORGANS."""

    def materials(self, grid: Grid) -> np.ndarray:
        """Material (nz, ny, nx) uint8 at the voxel centres of a scanner grid, without markers."""

    def fiducials(self) -> Fiducials:
        """Markers and nipples on the outer face of the skin, scanner frame, mm."""

    def normals(self) -> np.ndarray:
        """Outward unit normals (n, 3) of the skin at the fiducials, scanner frame."""


@dataclass(frozen=True)
class AtRest:
    """The stress-free body, moved rigidly into the scanner."""

    anatomy: Anatomy
    moved: RigidTransform

    def materials(self, grid: Grid) -> np.ndarray:
        """See Body."""
        points = _in_body(grid, self.moved).centres()
        return materials_of(self.anatomy, points, self.anatomy.labels_at(points)).reshape(grid.shape)

    def fiducials(self) -> Fiducials:
        """See Body."""
        listed = skin_points(self.anatomy)
        return Fiducials(listed.names, listed.kinds, self.moved(listed.points))

    def normals(self) -> np.ndarray:
        """See Body."""
        return skin_normals(self.anatomy, skin_points(self.anatomy).points) @ self.moved.R.T


@dataclass(frozen=True)
class Loaded:
    """The body under gravity: mesh.points stress-free, x (n_node, 3) in equilibrium; body frame, mm."""

    anatomy: Anatomy
    moved: RigidTransform
    mesh: TetMesh
    x: np.ndarray

    @cached_property
    def skin(self) -> SkinMap:
        """The deformation continued beyond the meshed skin."""
        return skin_map(self.mesh, self.x)

    def materials(self, grid: Grid) -> np.ndarray:
        """See Body: every point is carried back to the stress-free reference, where the anatomy is known.

        In the mesh by its elements, near the skin by the skin; everywhere else the body is rigid.
        """
        grid = _in_body(grid, self.moved)
        points = grid.centres()
        raster = rasterise(self.mesh.moved_to(self.x), grid)
        at_rest = rasterise(self.mesh, grid).inside.ravel()
        inside = raster.inside.ravel()
        outside = np.flatnonzero(~inside)
        near, above_skin = self.skin.pulled(points[outside], SKIN_REACH_MM)
        away = outside[~near]
        left = away[at_rest[away] | self._was_skin(points[away])]
        points[inside] = raster.carry(self.mesh.points)
        points[outside[near]] = above_skin
        labels = self.anatomy.labels_at(points)
        labels[left] = Label.AIR
        return materials_of(self.anatomy, points, labels).reshape(grid.shape)

    def _was_skin(self, points: np.ndarray) -> np.ndarray:
        """Whether points (n, 3) lie by the skin at rest, where chords of the mesh leave slivers out."""
        moves = self.anatomy.region_field(points) < -EDGE_MM
        return moves & (np.abs(self.anatomy.outer_field(points)) < SLIVER_MM)

    def fiducials(self) -> Fiducials:
        """See Body."""
        listed = skin_points(self.anatomy)
        return Fiducials(listed.names, listed.kinds, self.moved(self.skin.pushed(listed.points)[0]))

    def normals(self) -> np.ndarray:
        """See Body."""
        return self.skin.pushed(skin_points(self.anatomy).points)[1] @ self.moved.R.T


def _in_body(grid: Grid, moved: RigidTransform) -> Grid:
    """The same voxels in the body frame."""
    origin = moved.inverse()(grid.origin[None])[0]
    return Grid(grid.shape, grid.spacing, origin, moved.R.T @ grid.direction)


def materials_of(anatomy: Anatomy, points: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """Labels (n,) of stress-free points (n, 3), with the thorax resolved into its organs."""
    materials = labels.astype(np.uint8)
    thorax = np.flatnonzero(labels == Label.THORAX)
    materials[thorax] = organs_at(anatomy, points[thorax])
    return materials
