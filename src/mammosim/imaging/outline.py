"""Where the body ends and the air begins; images are in axis order (z, y, x), as the import leaves them."""

import numpy as np
from scipy import ndimage
from skimage.filters import threshold_otsu

from mammosim.core.errors import ImageError
from mammosim.core.volume import Image


def body_mask(image: Image) -> np.ndarray:
    """Body (nz, ny, nx) bool: the largest object brighter than air, and what it encloses in each axial slice.

    Lungs that reach the posterior border count as enclosed. Raises ImageError when no body is in the image.
    """
    # ASSUME: air and tissue part where Otsu's threshold cuts the logarithm of the slightly smoothed image.
    smooth = np.log1p(np.maximum(ndimage.gaussian_filter(image.values, 0.7), 0))
    if np.ptp(smooth) == 0:
        raise ImageError(f"all voxels have the value {image.values.flat[0]:g}; give an image of a body")
    objects, _ = ndimage.label(smooth > threshold_otsu(smooth))
    largest = objects == np.argmax(np.bincount(objects.ravel())[1:]) + 1
    return np.stack([_filled(axial) for axial in largest])


def bright_level(image: Image) -> float:
    """Brightness of fat: the 90th percentile of the voxels above Otsu's threshold."""
    return float(np.percentile(image.values[image.values > threshold_otsu(image.values)], 90))


def _filled(axial: np.ndarray) -> np.ndarray:
    """One slice (ny, nx) with its holes filled, the posterior border (last row) taken as closed."""
    closed = np.vstack([axial, np.full((1, axial.shape[1]), True)])
    return ndimage.binary_fill_holes(closed)[:-1]
