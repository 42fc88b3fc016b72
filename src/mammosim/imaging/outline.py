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


def spread_linearly(values: np.ndarray, grid: Grid, voxel_mm: float) -> np.ndarray:
    """As spread, linear between the middles of blocks; beyond the outermost ones as they are."""
    for axis, (n, size) in enumerate(zip(block(grid, voxel_mm), grid.shape)):
        last = values.shape[axis] - 1
        place = np.clip((np.arange(size) - (n - 1) / 2) / n, 0, last)
        low = np.minimum(place.astype(int), max(last - 1, 0))
        share = (place - low).reshape([-1 if k == axis else 1 for k in range(3)]).astype(np.float32)
        high = np.minimum(low + 1, last)
        values = values.take(low, axis) * (1 - share) + values.take(high, axis) * share
    return values


# ASSUME: what 90 % of the axial slices share is the torso without breasts.
SHARED_PART = 0.9
# ASSUME: the body begins at 17 % of the brightness within 12 mm, and nowhere below AIR_SPREADS median
# deviations of the air above its median: 4.5 standard deviations of a channel of Rayleigh-distributed noise.
SKIN_LEVEL, NEAR_MM, AIR_SPREADS = 0.17, 12.0, 7.4
# ASSUME: where for 10 mm no tenth of a row is 2.5 times as bright as the least that is told from air, the
# back of the body has faded rather than ended.
FADED, FADED_MM = 2.5, 10.0
# ASSUME: air reaches through gaps of 8 mm and more; narrower dark ways are a border of the image, or noise.
GAP_MM = 8.0
# Intensities are compared as logarithms of 1 + 500 times their part of the brightness of the body.
LOG_SCALE = 500.0


def body_mask(image: Image, *, skin_level: float = SKIN_LEVEL) -> np.ndarray:
    """Body (nz, ny, nx) bool: the largest object brighter than air, with what it encloses in axial slices.

    Dark parts that reach no air in front count as enclosed; where brightness fades towards the back, the body
    goes on straight to the image's border. Neither unit nor zero of the intensities matters. Raises
    ImageError when no body is in the image. skin_level: part of the brightness nearby at which it begins.
    """
    if np.ptp(image.values) == 0:
        raise ImageError(f"all voxels have the value {image.values.flat[0]:g}; give an image of a body")
    I = _relative(image.values)
    least = _least_of_body(I)
    body = largest_part(np.maximum(least, skin_level * _nearby(I, image.grid.spacing)) < I)
    body = largest_part(ndimage.uniform_filter(body.astype(np.float32), 3, mode="nearest") > 0.5)
    body = np.stack([_filled(axial, image.grid.spacing[:2]) for axial in body])
    return _unfaded(body, I, least, float(image.grid.spacing[1]))


def _relative(values: np.ndarray) -> np.ndarray:
    """Intensities (nz, ny, nx) float32: 0 is their darkest hundredth, 1 the brightness of the body."""
    zero = np.percentile(values[::2, ::2, ::2], 1)
    I = (values - zero).astype(np.float32)
    bright = I[threshold_otsu(I) < I]
    return I / np.float32(np.percentile(bright, 90))


def _least_of_body(I: np.ndarray) -> float:
    """What is brighter than air: Otsu's threshold of the logarithm, or less where the noise allows for it."""
    smooth = np.log1p(LOG_SCALE * np.maximum(ndimage.gaussian_filter(I, 0.7), 0))
    otsu = float(np.expm1(threshold_otsu(smooth)) / LOG_SCALE)
    air = I[otsu > I]
    middle = np.median(air)
    noise = float(middle + AIR_SPREADS * np.median(np.abs(air - middle)))
    return min(otsu, noise) if noise > 0 else otsu


def _nearby(I: np.ndarray, spacing: np.ndarray) -> np.ndarray:
    """Brightness (nz, ny, nx) of what is bright nearby: sum I^2 / sum I, to which air adds nothing."""
    size = [2 * max(round(NEAR_MM / h), 1) + 1 for h in spacing[::-1]]
    positive = np.maximum(I, 0)
    first, second = (ndimage.uniform_filter(power, size, mode="nearest") for power in (positive, positive**2))
    return np.maximum(second, 0) / np.maximum(first, 1e-6)


def _filled(axial: np.ndarray, spacing: np.ndarray) -> np.ndarray:
    """One slice (ny, nx) with all filled that air in front of the body does not reach through GAP_MM."""
    n = np.maximum(np.round(GAP_MM / spacing[::-1]).astype(int), 1)
    air = np.pad(~axial, [(n[0], n[0]), (n[1], n[1])])
    air[: n[0]] = True
    wide = ndimage.minimum_filter(air, n)
    wide &= ~fill_axial(~wide)
    reached = ndimage.maximum_filter(wide, n, origin=[-1 if k % 2 == 0 else 0 for k in n])
    return axial | ~reached[n[0] : -n[0], n[1] : -n[1]]


def _unfaded(body: np.ndarray, I: np.ndarray, least: float, dy: float) -> np.ndarray:
    """The body (nz, ny, nx) bool, each slice of which goes on straight behind its widest row."""
    rows = np.flatnonzero(body.any(axis=(0, 2)))
    bright = [j for j in rows if np.percentile(I[:, j][body[:, j]], 90) > FADED * least]
    if not bright or (rows[-1] - bright[-1]) * dy < FADED_MM:
        return body
    whole, widest, last = body.copy(), int(body.sum(axis=(0, 2)).argmax()), bright[-1]
    first = min(widest, last)
    whole[:, first : last + 1] = np.maximum.accumulate(body[:, first : last + 1], axis=1)
    wide = whole[:, last]
    between = np.maximum.accumulate(wide, 1) & np.maximum.accumulate(wide[:, ::-1], 1)[:, ::-1]
    whole[:, last:] |= between[:, None]
    return whole


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
