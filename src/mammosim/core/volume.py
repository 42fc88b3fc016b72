"""Voxel grids in the patient frame LPS, mm. Arrays are (z, y, x); points and spacings are (x, y, z)."""

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Grid:
    """Where voxels are: shape (nz, ny, nx), spacing (3,) and origin (3,) in (x, y, z) order.

    origin: centre of voxel [0, 0, 0]; direction (3, 3): columns are the unit vectors of the i, j, k axes.
    """

    shape: tuple[int, int, int]
    spacing: np.ndarray
    origin: np.ndarray
    direction: np.ndarray = field(default_factory=lambda: np.eye(3))

    def __post_init__(self) -> None:
        if len(self.shape) != 3 or min(self.shape) < 1:
            raise ValueError(f"shape {self.shape} must be three positive numbers (nz, ny, nx)")
        if np.min(self.spacing) <= 0:
            raise ValueError(f"spacing {self.spacing} mm must be positive")
        if not np.allclose(self.direction.T @ self.direction, np.eye(3), atol=1e-4):
            raise ValueError("direction must have orthonormal columns")

    def points(self, indices: np.ndarray) -> np.ndarray:
        """Patient coordinates (n, 3) of continuous indices (n, 3) in array order (k, j, i)."""
        x: np.ndarray = self.origin + (indices[:, ::-1] * self.spacing) @ self.direction.T
        return x

    def indices(self, points: np.ndarray) -> np.ndarray:
        """Continuous array indices (n, 3) in order (k, j, i) of patient points (n, 3)."""
        kji: np.ndarray = (((points - self.origin) @ self.direction) / self.spacing)[:, ::-1]
        return kji

    def centres(self) -> np.ndarray:
        """Patient coordinates (nz * ny * nx, 3) of all voxel centres, in array order."""
        z, y, x = (
            np.arange(n)[:, None] * step
            for n, step in zip(self.shape, (self.direction * self.spacing).T[::-1])
        )
        centres: np.ndarray = (self.origin + (z[:, None, None] + (y[:, None] + x))).reshape(-1, 3)
        return centres

    @property
    def voxel_volume(self) -> float:
        """Volume of a voxel in mm3."""
        return float(np.prod(self.spacing))

    def same_as(self, other: "Grid") -> bool:
        """Whether this and the other grid place the same voxels at the same points, to 1e-3 mm."""
        return self.shape == other.shape and all(
            np.allclose(a, b, atol=1e-3)
            for a, b in [
                (self.spacing, other.spacing),
                (self.origin, other.origin),
                (self.direction, other.direction),
            ]
        )


@dataclass(frozen=True)
class Image:
    """Intensities: values (nz, ny, nx) float32 on a grid. Interpolate them; never ask them for a label."""

    grid: Grid
    values: np.ndarray

    def __post_init__(self) -> None:
        _check(self.grid, self.values)


@dataclass(frozen=True)
class LabelMap:
    """Tissue labels: values (nz, ny, nx) uint8 of core.labels.Label on a grid. Nearest neighbour only."""

    grid: Grid
    values: np.ndarray

    def __post_init__(self) -> None:
        _check(self.grid, self.values)
        if not np.issubdtype(self.values.dtype, np.integer):
            raise ValueError(f"labels must be integers, not {self.values.dtype}")


def _check(grid: Grid, values: np.ndarray) -> None:
    if values.shape != tuple(grid.shape):
        raise ValueError(f"values {values.shape} do not fit the grid {tuple(grid.shape)}, both (nz, ny, nx)")


def grid_around(low: np.ndarray, high: np.ndarray, spacing: float | np.ndarray) -> Grid:
    """Axis-aligned grid whose voxels cover the box from low (3,) to high (3,), mm."""
    step = np.broadcast_to(np.asarray(spacing, float), (3,)).copy()
    count = np.maximum(np.ceil((np.asarray(high) - low) / step - 1e-9).astype(int), 1)
    nx, ny, nz = map(int, count)
    return Grid((nz, ny, nx), step, np.asarray(low, float) + step / 2)
