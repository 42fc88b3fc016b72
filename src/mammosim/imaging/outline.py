"""Where the body ends and the air begins; images are in axis order (z, y, x), as the import leaves them.

Images with fewer voxels, for what needs no finer ones: seconds and memory follow the number of voxels.
"""

import numpy as np
from scipy import ndimage
from skimage.filters import threshold_otsu

from mammosim.core.errors import ImageError
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


# ASSUME: what 90 % of the axial slices share is the torso without breasts.
SHARED_PART = 0.9
SKIN_LEVEL = 0.12


def body_mask(image: Image) -> np.ndarray:
    """Body (nz, ny, nx) bool: the largest object brighter than air, with what it encloses in axial slices.

    Dark parts that reach no air in front count as enclosed. Raises ImageError when no body is in the image.
    """
    # ASSUME: the body begins at 12 % of the brightness of fat, or at Otsu's threshold of the logarithm.
    if np.ptp(image.values) == 0:
        raise ImageError(f"all voxels have the value {image.values.flat[0]:g}; give an image of a body")
    smooth = np.log1p(np.maximum(ndimage.gaussian_filter(image.values, 0.7), 0))
    level = max(np.expm1(threshold_otsu(smooth)), SKIN_LEVEL * bright_level(image))
    body = largest_part(image.values > level)
    body = largest_part(ndimage.uniform_filter(body.astype(np.float32), 3, mode="nearest") > 0.5)
    return np.stack([fill_axial(axial) for axial in body])


def largest_part(region: np.ndarray) -> np.ndarray:
    """The largest face-connected part of a region (nz, ny, nx) bool; an empty one stays empty."""
    parts, n = ndimage.label(region)
    return parts == np.argmax(np.bincount(parts.ravel())[1:]) + 1 if n else region


def bright_level(image: Image) -> float:
    """Brightness of fat: the 90th percentile of the voxels above Otsu's threshold."""
    return float(np.percentile(image.values[image.values > threshold_otsu(image.values)], 90))


def torso_depth(body: np.ndarray, spacing: np.ndarray) -> np.ndarray:
    """Signed depth (ny, nx) mm under the skin of the torso without breasts, negative outside; in all slices.

    body (nz, ny, nx) bool; spacing (3,) mm in (x, y, z). Borders of the image count as inside.
    """
    torso = body.mean(axis=0) >= SHARED_PART
    inside, outside = (
        ndimage.distance_transform_edt(part, sampling=(spacing[1], spacing[0])) for part in (torso, ~torso)
    )
    return inside - outside


def fill_axial(axial: np.ndarray) -> np.ndarray:
    """One slice (ny, nx) with all filled that air in front of the body (first row) does not reach."""
    closed = np.pad(axial, ((0, 1), (1, 1)), constant_values=True)
    return ndimage.binary_fill_holes(closed)[:-1, 1:-1]
