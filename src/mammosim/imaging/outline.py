"""Where the body ends and the air begins; images are in axis order (z, y, x), as the import leaves them."""

import numpy as np
from scipy import ndimage
from skimage.filters import threshold_otsu

from mammosim.core.errors import ImageError
from mammosim.core.volume import Image

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
