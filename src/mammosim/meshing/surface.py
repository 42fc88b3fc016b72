"""Closed triangle surfaces of signed fields and of labelled voxels, in the patient frame LPS, mm."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from skimage.measure import marching_cubes

from mammosim.core.errors import MeshError
from mammosim.core.labels import DEFORMABLE, Label
from mammosim.core.volume import Grid, LabelMap
from mammosim.meshing.lattice import on_lattice

# What the skin meets; markers are stuck on from outside.
OPEN = (Label.AIR, Label.MARKER)


@dataclass(frozen=True)
class Surface:
    """A closed surface: points (n, 3) mm; triangles (m, 3) point numbers, counter-clockwise from outside.

    Raises MeshError when an edge does not belong to exactly two triangles of opposite sense.
    """

    points: np.ndarray
    triangles: np.ndarray

    def __post_init__(self) -> None:
        if not np.isfinite(self.points).all():
            raise MeshError("the surface has coordinates that are not finite")
        if bad := _unpaired_edges(self.triangles):
            raise MeshError(f"the surface is open or folded: {bad} edges do not join exactly two triangles")

    def corners(self) -> np.ndarray:
        """Corners (m, 3, 3) of the triangles: triangle, corner, coordinate."""
        return self.points[self.triangles]

    def volume(self) -> float:
        """Enclosed volume in mm3: sum of a . (b x c) / 6."""
        a, b, c = np.moveaxis(self.corners() - self.points.mean(axis=0), 1, 0)
        return float(np.einsum("ti,ti->", a, np.cross(b, c)) / 6)


def _unpaired_edges(triangles: np.ndarray) -> int:
    """How many directed edges a -> b do not meet exactly one b -> a."""
    a, b = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    n = int(triangles.max(initial=0)) + 1
    forth, back = np.sort(a * n + b), np.sort(b * n + a)
    twice = np.count_nonzero(forth[1:] == forth[:-1])
    return int(twice + np.count_nonzero(~np.isin(forth, back)))


def surface_of_field(values: np.ndarray, grid: Grid) -> Surface:
    """Where a signed field (nz, ny, nx), negative inside, is zero: marching cubes, oriented outward.

    The largest connected piece is kept and its cavities are filled. At the border of the grid the
    surface is closed half a voxel outside the last centres. Raises MeshError when nothing is inside.
    """
    field, least = _rounded(np.asarray(values, dtype=float))
    field = _one_solid(field)
    # Outside the grid the field is the border's, made positive: it crosses zero at the voxel's outer face.
    outside = np.pad(np.zeros(field.shape, dtype=bool), 1, constant_values=True)
    padded = np.pad(field, 1, mode="edge")
    padded[outside] = np.abs(padded[outside])
    # Zeros at voxel centres would give triangles without area.
    padded = np.where(np.abs(padded) < least, np.where(padded < 0, -least, least), padded)
    vertices, triangles, _, _ = marching_cubes(padded, level=0.0)
    surface = Surface(grid.points(vertices.astype(float) - 1), triangles.astype(np.int64))
    return surface if surface.volume() > 0 else Surface(surface.points, surface.triangles[:, ::-1])


def _rounded(field: np.ndarray) -> tuple[np.ndarray, float]:
    """The field on a lattice of a millionth of its mean size, so that a zero is one, and 1e-3 of that size.

    Both are powers of two, which last bits of the mean do not change.
    """
    _, exponent = np.frexp(np.abs(field).mean())
    return on_lattice(field, 2.0 ** (exponent - 21)), 2.0 ** (exponent - 11)


def _one_solid(field: np.ndarray) -> np.ndarray:
    """The field with all but the largest piece below zero turned outside, and cavities turned inside."""
    pieces, n = ndimage.label(field < 0)
    if n == 0:
        raise MeshError("the field is nowhere negative: nothing lies inside the surface")
    largest = pieces == 1 + np.argmax(np.bincount(pieces.ravel())[1:])
    solid = ndimage.binary_fill_holes(largest)
    return np.where(solid, -np.abs(field), np.abs(field))


def surface_of_labels(labels: LabelMap, *, smoothing_mm: float | None = None) -> Surface:
    """Smooth closed surface around the DEFORMABLE voxels.

    Two surfaces bound them: one against the air, which goes on around what holds the tissue (the thorax), and
    one against what holds it, which goes on into the air. The signed distance from each is smoothed over
    `smoothing_mm`, by default the largest voxel spacing; where the larger of the two is zero lies the result,
    so that its rim is sharp.
    Raises MeshError when no voxel is deformable.
    """
    deformable, opened = np.isin(labels.values, DEFORMABLE), np.isin(labels.values, OPEN)
    if not deformable.any():
        raise MeshError(f"no voxel has a label of: {', '.join(label.tissue for label in DEFORMABLE)}")
    spacing = labels.grid.spacing[::-1]
    sigma = float(spacing.max()) if smoothing_mm is None else smoothing_mm
    bounds = [
        _smoothed(_signed_distance(~outside, spacing), sigma / spacing)
        for outside in (opened, _continued(~(opened | deformable), opened, spacing))
        if outside.any()
    ]
    everywhere = np.full(labels.grid.shape, -float(spacing.min()) / 2, dtype=np.float32)
    return surface_of_field(np.max(bounds, axis=0) if bounds else everywhere, labels.grid)


def _smoothed(field: np.ndarray, sigma: np.ndarray) -> np.ndarray:
    """2 G f - G G f with a Gaussian G of standard deviation sigma (3,) voxels (Tukey's twicing).

    G alone moves a surface of mean curvature 1/R inwards by sigma^2 / R; this one to order sigma^4 / R^3.
    """
    once = ndimage.gaussian_filter(field, sigma, mode="nearest")
    return 2 * once - ndimage.gaussian_filter(once, sigma, mode="nearest")


def _continued(mask: np.ndarray, unknown: np.ndarray, spacing: np.ndarray) -> np.ndarray:
    """The mask (nz, ny, nx) with each unknown voxel taking the value of the nearest known one."""
    if not mask.any() or not unknown.any():
        return mask
    nearest = ndimage.distance_transform_edt(
        unknown, sampling=spacing, return_distances=False, return_indices=True
    )
    return mask[tuple(nearest)]


def _signed_distance(mask: np.ndarray, spacing: np.ndarray) -> np.ndarray:
    """Distance (nz, ny, nx) in mm to the faces between mask and background, negative inside the mask."""
    half = float(spacing.mean()) / 2
    inward, outward = (
        ndimage.distance_transform_edt(m, sampling=spacing).astype(np.float32) for m in (mask, ~mask)
    )
    return np.where(mask, half - inward, outward - half)
