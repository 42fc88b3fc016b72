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
# Widths of ln(I / level) within which a voxel counts as fat, one iteration after the other.
WIDTHS = (0.4, 0.3, 0.25, 0.25, 0.25)
LEAST_SHELL = 200  # voxels
# Then less far to the side of gland, which else would be counted where there is much of it, and farther to
# the other side, where there is nothing but fat out of the reach of the coil.
ONE_SIDED, OTHER_SIDE, GLAND_SIDE = 4, 0.7, 0.2
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
    for width, near in zip(WIDTHS, (False, *(True,) * len(WIDTHS))):
        level = carried(smooth, fat, spacing, near=near)
        log = np.log(np.maximum(smooth, 1e-6 * smooth.max()) / level)
        fat = region & (np.abs(log) < width)
    sign = sign or sign_of_others(smooth / level, breast & (depth > SHELL_MM[1]))
    for _ in range(ONE_SIDED):
        log = sign * np.log(np.maximum(smooth, 1e-6 * smooth.max()) / level)
        level = carried(smooth, region & (log > -OTHER_SIDE) & (log < GLAND_SIDE), spacing)
    return FatLevel(level, sign)


def sign_of_others(ratio: np.ndarray, deep: np.ndarray) -> int:
    """1 where other tissue is brighter than fat: the ratio reaches farther above 1 than below; else -1."""
    if not deep.any():
        return -1
    low, high = np.percentile(ratio[deep], TAILS)
    return 1 if high - 1 > UPPER_TAIL * (1 - low) else -1


def carried(I: np.ndarray, where: np.ndarray, spacing: np.ndarray, *, near: bool = True) -> np.ndarray:
    """Weighted mean (nz, ny, nx) of intensities where a mask (bool) holds: near if it does there, or far."""
    total, weight = np.zeros(I.shape, np.float32), np.zeros(I.shape, np.float32)
    for sigma, share in ((NEAR_MM, float(near)), (FAR_MM, 0.01)):
        s = sigma / spacing[::-1]
        total += share * ndimage.gaussian_filter(np.where(where, I, 0).astype(np.float32), s, truncate=3)
        weight += share * ndimage.gaussian_filter(where.astype(np.float32), s, truncate=3)
    mean = float(I[where].mean()) if where.any() else 1.0
    return (total + 1e-6 * mean) / (weight + 1e-6)
