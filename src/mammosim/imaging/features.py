"""What a classifier is told of each voxel: intensity, its neighbourhood, and its place in the body."""

import numpy as np
from scipy import ndimage

from mammosim.core.volume import Grid, Image
from mammosim.imaging.bias import correct_bias
from mammosim.imaging.outline import body_mask, bright_level, largest_part, torso_depth

NAMES = (
    *("intensity", "smooth", "mean", "minimum", "maximum", "deviation", "gradient"),
    *("right", "left", "anterior", "posterior", "inferior", "superior"),
    *("depth_mm", "torso_depth_mm", "behind_fat_mm", "lateral_mm", "behind_front_mm", "height_mm"),
)
FAT = 0.65


def features(image: Image, *, neighbourhood_mm: float) -> np.ndarray:
    """(nz, ny, nx, n_feature) float32 in the order of NAMES; intensities are parts of the brightness of fat.

    The neighbourhood is a box of half width neighbourhood_mm; right to superior are its six middles.
    """
    body = body_mask(image)
    even = correct_bias(image)
    I = even.values / bright_level(even)
    r = np.maximum(np.round(neighbourhood_mm / image.grid.spacing[::-1]), 1).astype(int)
    return np.stack([*_neighbourhood(I, r), *_place(I, body, image.grid)], axis=-1).astype(np.float32)


def _neighbourhood(I: np.ndarray, r: np.ndarray) -> list[np.ndarray]:
    """Intensity features, each (nz, ny, nx), for a neighbourhood of r (3,) voxels in order (z, y, x)."""
    size = list(2 * r + 1)
    mean = ndimage.uniform_filter(I, size, mode="nearest")
    square = ndimage.uniform_filter(I * I, size, mode="nearest")
    return [
        I,
        ndimage.gaussian_filter(I, r / 4, mode="nearest"),
        mean,
        ndimage.minimum_filter(I, size, mode="nearest"),
        ndimage.maximum_filter(I, size, mode="nearest"),
        np.sqrt(np.maximum(square - mean**2, 0)),
        ndimage.gaussian_gradient_magnitude(I, r / 4, mode="nearest"),
        *(_shifted(I, axis, step * r[axis]) for axis in (2, 1, 0) for step in (-1, 1)),
    ]


def _shifted(I: np.ndarray, axis: int, step: int) -> np.ndarray:
    """The intensity `step` voxels further along an axis, the border repeated."""
    index = np.clip(np.arange(I.shape[axis]) + step, 0, I.shape[axis] - 1)
    return np.take(I, index, axis=axis)


def _place(I: np.ndarray, body: np.ndarray, grid: Grid) -> list[np.ndarray]:
    """Depth under skin, torso's skin and fat; distances from the midline, the front and the middle."""
    # ASSUME: the fat under the skin is the largest connected part brighter than 65 % of fat.
    dx, dy, dz = grid.spacing
    torso = torso_depth(body, grid.spacing)
    k, j, i = np.indices(body.shape, np.float32)
    columns, rows = (np.flatnonzero((torso > 0).any(axis=axis)) for axis in (0, 1))
    return [
        ndimage.distance_transform_edt(body, sampling=(dz, dy, dx)),
        np.broadcast_to(torso, body.shape),
        ndimage.distance_transform_edt(~largest_part(body & (I > FAT)), sampling=(dz, dy, dx)),
        np.abs(i - columns.mean()) * dx,
        (j - rows[0]) * dy,
        (k - (body.shape[0] - 1) / 2) * dz,
    ]
