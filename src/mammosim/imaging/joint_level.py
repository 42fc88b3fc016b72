"""The brightness of fat where much of the breast is gland: what is gland tells of it, too.

Each voxel is fat of the level L(x) or gland of (1 + s c) L(x), s = 1 where gland is brighter. Given L, the
probability p of gland follows from I / L; given p, L is the local mean of I and of I / (1 + s c), each by its
probability: field and classes of one another (Wells et al., IEEE Trans Med Imaging 15:429, 1996).
Without the second term the level of a dense breast becomes that of its gland.
"""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from mammosim.core.volume import Grid
from mammosim.imaging.fat_level import FAR_MM, NEAR_MM, SHELL_MM
from mammosim.imaging.outline import block, spread_linearly

BLOCK_MM = 3.5  # in which the level is smoothed
# ASSUME: what differs by less than this to the side of gland is fat; to the other side 1.2 times as much.
FAT_WITHIN, OTHER_SIDE = 0.25, 1.2
ITERATIONS, ALL_FAT = 12, 4  # of the first ones all but the darkest part to the other side counts
FARTHEST = 0.7
# ASSUME: gland differs from fat by a quarter at least, over 0.4 of that; it is 0.02 to 0.6 of the breast.
LEAST_CONTRAST, GLAND_SPREAD, SHARES, FIRST_SHARE = 0.25, 0.4, (0.02, 0.6), 0.3
DEEP_MM, LEAST_VOXELS = 8.0, 50
# ASSUME: fat varies by 0.03 at least; what differs by more than 0.2 and twice its noise is gland.
LEAST_NOISE, CLEARLY, NOISES = 0.03, 0.2, 2.0
# ASSUME: in the layer under the skin what differs by 0.15 is a tenth fat; the layer is even over 25 mm.
IN_SHELL, SHELL_WEIGHT, SHELL_NEAR_MM, SHELL_FAR_MM = 0.15, 0.1, 25.0, 60.0
SHELL_FARTHEST, SHELL_ITERATIONS = 0.6, 4  # what differs by more to the side away from gland is no fat


@dataclass(frozen=True)
class Voxels:
    """Those of a region (nz, ny, nx): their blocks in a coarse grid, and their places in it."""

    grid: Grid
    index: tuple[np.ndarray, ...]

    def carried(self, I: np.ndarray, w: np.ndarray, near: float, far: tuple[float, float]) -> np.ndarray:
        """Coarse map of weighted means of I (n,): of those near, and to a small share of those far away."""
        n = block(self.grid, BLOCK_MM)
        shape = tuple(int(-(-size // k)) for size, k in zip(self.grid.shape, n))
        at = np.ravel_multi_index([i // k for i, k in zip(self.index, n)], shape)
        size, spacing = int(np.prod(shape)), self.grid.spacing[::-1] * n
        sums = [np.bincount(at, v, minlength=size).reshape(shape) for v in (w * I, w)]
        total, weight = (
            sum(
                share * ndimage.gaussian_filter(each, mm / spacing, truncate=3)
                for mm, share in ((near, 1.0), far)
            )
            for each in sums
        )
        mean = float((w * I).sum() / max(w.sum(), 1e-6))
        level: np.ndarray = ((total + 1e-6 * mean) / (weight + 1e-6)).astype(np.float32)
        return level

    def on(self, level: np.ndarray) -> np.ndarray:
        """A coarse map at the voxels (n,)."""
        n = block(self.grid, BLOCK_MM)
        places = np.stack([(i - (k - 1) / 2) / k for i, k in zip(self.index, n)])
        found: np.ndarray = ndimage.map_coordinates(level, places, order=1, mode="nearest")
        return found


def joint_level(I: np.ndarray, where: np.ndarray, depth: np.ndarray, grid: Grid, sign: int) -> np.ndarray:
    """Brightness of fat (nz, ny, nx) of intensities in a region (bool) with depth mm under the skin.

    sign: 1 where gland is brighter than fat, -1 where it is darker.
    """
    where = where & (depth > SHELL_MM[0])
    voxels = Voxels(grid, np.nonzero(where))
    values, below = I[where], depth[where]
    level = _of_shell(voxels, values, below, sign)
    share = FIRST_SHARE
    for iteration in range(ITERATIONS):
        differs = sign * (values / voxels.on(level) - 1)
        noise, c = _classes(differs, below)
        p = _gland(differs, noise, c, share)
        share = float(np.clip(p.mean(), *SHARES))
        of_gland = p * (noise * ((1 + sign * c) if sign > 0 else 1.0) / max(GLAND_SPREAD * c, noise)) ** 2
        fat = (1 - p) * (differs > -FARTHEST)
        if iteration >= ALL_FAT:
            fat_like = (differs > -OTHER_SIDE * FAT_WITHIN) & (differs < FAT_WITHIN)
            fat = fat * fat_like
        total = fat + of_gland
        as_fat = values * (fat + of_gland / (1 + sign * c)) / np.maximum(total, 1e-9)
        level = voxels.carried(as_fat, total, NEAR_MM, (FAR_MM, 0.01))
    return spread_linearly(level, grid, BLOCK_MM)


def _of_shell(voxels: Voxels, I: np.ndarray, depth: np.ndarray, sign: int) -> np.ndarray:
    """Level of the layer under the skin, carried on to all."""
    weight = (depth < SHELL_MM[1]).astype(float)
    level = voxels.carried(I, weight, FAR_MM, (FAR_MM, 0.0))
    for _ in range(SHELL_ITERATIONS):
        differs = sign * (I / voxels.on(level) - 1)
        w = weight * np.where(differs > IN_SHELL, SHELL_WEIGHT, 1.0) * (differs > -SHELL_FARTHEST)
        level = voxels.carried(I, w, SHELL_NEAR_MM, (SHELL_FAR_MM, 0.01))
    return level


def _classes(differs: np.ndarray, depth: np.ndarray) -> tuple[float, float]:
    """Standard deviation of fat, from the other side of it than gland; what gland differs by."""
    other = differs[differs < 0]
    noise = max(1.4826 * float(np.median(-other)), LEAST_NOISE) if len(other) else LEAST_NOISE
    clear = differs[(differs > max(CLEARLY, NOISES * noise)) & (depth > DEEP_MM)]
    c = float(np.median(clear)) if len(clear) > LEAST_VOXELS else GLAND_SPREAD
    return noise, max(c, LEAST_CONTRAST)


def _gland(differs: np.ndarray, noise: float, c: float, share: float) -> np.ndarray:
    """Probability (n,) of gland: what is beyond the mean of a class is sure to be of it."""
    wide = max(GLAND_SPREAD * c, noise)
    fat = -0.5 * (np.maximum(differs, 0) / noise) ** 2 - np.log(noise)
    gland = -0.5 * (np.minimum(differs - c, 0) / wide) ** 2 - np.log(wide)
    p: np.ndarray = share / (share + (1 - share) * np.exp(np.clip(fat - gland, -30, 30)))
    return p
