"""Images with fewer voxels, for what needs no finer ones: seconds and memory follow the number of voxels."""

import numpy as np

from mammosim.core.volume import Grid, Image


def block(grid: Grid, voxel_mm: float) -> np.ndarray:
    """How many voxels (3,) in order (z, y, x) make one of about voxel_mm, halves rounded down, at least 1."""
    return np.maximum(np.ceil(voxel_mm / grid.spacing[::-1] - 0.5), 1).astype(int)


def coarsened(image: Image, voxel_mm: float) -> Image:
    """Means of blocks of about voxel_mm; the border is repeated to fill the last blocks.

    The image itself where its voxels are as large already.
    """
    n = block(image.grid, voxel_mm)
    if np.all(n == 1):
        return image
    pad = [(0, int(-size % k)) for size, k in zip(image.grid.shape, n)]
    values = np.pad(image.values, pad, mode="edge")
    nz, ny, nx = (int(size) // int(k) for size, k in zip(values.shape, n))
    means = values.reshape(nz, n[0], ny, n[1], nx, n[2]).mean(axis=(1, 3, 5), dtype=np.float32)
    origin = image.grid.points((n - 1)[None] / 2)[0]
    return Image(Grid((nz, ny, nx), image.grid.spacing * n[::-1], origin, image.grid.direction), means)


def spread(values: np.ndarray, grid: Grid, voxel_mm: float) -> np.ndarray:
    """Values of the blocks of `coarsened` as an array (nz, ny, nx) of the fine grid."""
    for axis, k in enumerate(block(grid, voxel_mm)):
        values = np.repeat(values, k, axis=axis) if k > 1 else values
    nz, ny, nx = grid.shape
    return values[:nz, :ny, :nx]
