"""The local brightness of fat, and whether other tissue is brighter or darker, whatever sequence and coil.

The layer under the skin is fat in every woman. From there the level is carried on to all that is as bright,
again and again: the field of the coil and of uneven fat suppression, of one class alone (Wells et al., IEEE
Trans Med Imaging 15:429, 1996, with fat as the class).
"""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

# ASSUME: from 4.5 to 10 mm under the skin there is mostly fat.
SHELL_MM = (4.5, 10.0)
# ASSUME: the brightness of fat varies over 12 mm, and over 40 mm where there is none so near.
NEAR_MM, FAR_MM = 12.0, 40.0
# Of ln(I / level) towards gland within which a voxel counts as fat, one iteration after the other; as much
# to the other side first, then more, where there is nothing but fat out of the reach of the coil.
WIDTHS = (0.4, 0.3, 0.25, 0.25, 0.2, 0.2, 0.2, 0.2)
OTHER_SIDE, LAST_WIDTH = 0.7, 0.2
# ASSUME: where nothing is brighter than fat, what is less bright has a tenth of the weight, or the level
# would be that of gland where there is much of it. Such a mean, an expectile (Newey & Powell, Econometrica
# 55:819, 1987), is a standard deviation off: the last one is even. Where fat is suppressed lungs and ribs
# are on the other side, to which it would lean: Duke 001 lost 0.19 of gland by that.
GLAND_WEIGHT = 0.1
LEAST_SHELL = 200  # voxels
# ASSUME: a hundredth of the breast differs from fat to one side: for bright tissue that tail is 1.2 times as
# long as the other, relative to fat.
TAILS, UPPER_TAIL = (1, 99), 1.2


@dataclass(frozen=True)
class FatLevel:
    """level (nz, ny, nx): brightness of fat; sign: 1 where other tissue is brighter, -1 where darker."""

    level: np.ndarray
    sign: int


def fat_level(
    I: np.ndarray,
    region: np.ndarray,
    breast: np.ndarray,
    depth: np.ndarray,
    spacing: np.ndarray,
    *,
    sign: int = 0,
) -> FatLevel:
    """Of intensities (nz, ny, nx) in a region of fat and breast, bool, with depth mm under the skin.

    breast: what certainly is in front of the muscle, bool, by which the sign is decided where
    it is not given (0).
    """
    smooth = ndimage.median_filter(I, 3)
    shell = (depth > SHELL_MM[0]) & (depth < SHELL_MM[1])
    fat = shell & (breast if np.count_nonzero(shell & breast) > LEAST_SHELL else region)
    level = carried(smooth, fat, spacing, near=False)
    sign = sign or sign_of_others(smooth / level, breast & (depth > SHELL_MM[1]))
    weight = GLAND_WEIGHT if sign < 0 else 1.0
    for width in WIDTHS:
        log = sign * _log_ratio(smooth, level)
        other = OTHER_SIDE if sign < 0 or width <= LAST_WIDTH else width
        fat = region & (log > -other) & (log < width)
        level = carried(smooth, fat * np.where(log > 0, weight, 1.0), spacing)
    if sign < 0:
        level = carried(smooth, region & (np.abs(_log_ratio(smooth, level)) < LAST_WIDTH), spacing)
    return FatLevel(level, sign)


def _log_ratio(I: np.ndarray, level: np.ndarray) -> np.ndarray:
    log: np.ndarray = np.log(np.maximum(I, 1e-6 * I.max()) / level)
    return log


def sign_of_others(ratio: np.ndarray, deep: np.ndarray) -> int:
    """1 where other tissue is brighter than fat: the ratio reaches farther above 1 than below; else -1."""
    if not deep.any():
        return -1
    low, high = np.percentile(ratio[deep], TAILS)
    return 1 if high - 1 > UPPER_TAIL * (1 - low) else -1


def carried(I: np.ndarray, where: np.ndarray, spacing: np.ndarray, *, near: bool = True) -> np.ndarray:
    """Mean (nz, ny, nx) of intensities by a mask or weights: of near ones if there are any, or far ones."""
    total, weight = np.zeros(I.shape, np.float32), np.zeros(I.shape, np.float32)
    for sigma, share in ((NEAR_MM, float(near)), (FAR_MM, 0.01)):
        s = sigma / spacing[::-1]
        total += share * ndimage.gaussian_filter((where * I).astype(np.float32), s, truncate=3)
        weight += share * ndimage.gaussian_filter(where.astype(np.float32), s, truncate=3)
    mean = float((where * I).sum() / where.sum()) if where.any() else 1.0
    return (total + 1e-6 * mean) / (weight + 1e-6)
