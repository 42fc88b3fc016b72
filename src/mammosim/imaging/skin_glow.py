"""Brightness that fades steadily from the skin inwards: blurred skin, and fat that is not suppressed.

Gland begins with a rise. So the brightness of what lies equally deep nearby, taken no higher than in
any layer nearer to the skin, tells of no gland: its part above that of fat is the glow of the skin.
"""

import numpy as np

from mammosim.core.volume import Grid
from mammosim.imaging.joint_level import Voxels

# ASSUME: the glow reaches 20 mm under the skin; it is even within 20 mm along it, in layers of 1.5 mm.
REACH_MM, LAYER_MM, NEAR_MM, FAR = 20.0, 1.5, 20.0, (40.0, 0.01)
# ASSUME: strands leave fat between them, glow does not: what is brighter than the mean of its layer nearby
# has a fifth of the weight in it (an expectile: Newey & Powell, Econometrica 55:819, 1987).
BRIGHTER_WEIGHT, ITERATIONS = 0.2, 4
# ASSUME: skin is bright where it is 1.4 times as bright as what lies 12 to 18 mm deep. It is 1.6 times in
# fat-suppressed T1 (Duke 001), and 1.1 where it is not bright (one breast in fat-suppressed T2).
SKIN_LAYERS_MM, DEEP_MM, BRIGHT = ((3.0, 6.0), (6.0, 9.0)), (12.0, 18.0), 1.4


def skin_is_bright(relative: np.ndarray, depth: np.ndarray) -> bool:
    """Of brightness (n,) relative to fat and depth (n,) mm: whether a layer of skin is brighter."""

    def median(within: tuple[float, float]) -> float:
        layer = relative[(depth > within[0]) & (depth <= within[1])]
        return float(np.median(layer)) if len(layer) else np.nan

    return bool(max(median(layer) for layer in SKIN_LAYERS_MM) > BRIGHT * median(DEEP_MM))


def skin_glow(ratio: np.ndarray, where: np.ndarray, depth: np.ndarray, grid: Grid) -> np.ndarray:
    """Brightness (nz, ny, nx) of the glow relative to fat, at least 1, in a region (bool); 1 elsewhere.

    ratio: brightness relative to fat; depth mm under the skin.
    """
    glow = np.ones(ratio.shape, np.float32)
    index = np.nonzero(where & (depth < REACH_MM))
    if not len(index[0]):
        return glow
    below, ratios = depth[index], ratio[index]
    layer = ((below - below.min()) / max(LAYER_MM, float(np.median(grid.spacing)))).astype(int)
    nearer = np.full(1, np.inf, np.float32)
    for n in np.unique(layer):
        here = layer == n
        voxels = Voxels(grid, tuple(i[here] for i in index))
        nearer = np.minimum(nearer, _expectile(voxels, ratios[here]))
        glow[voxels.index] = np.maximum(voxels.on(nearer), 1)
    return glow


def _expectile(voxels: Voxels, ratio: np.ndarray) -> np.ndarray:
    """Coarse map of the mean of a layer nearby that leans to what is less bright."""
    mean = voxels.carried(ratio, np.ones_like(ratio), NEAR_MM, FAR)
    for _ in range(ITERATIONS):
        weight = np.where(ratio > voxels.on(mean), BRIGHTER_WEIGHT, 1.0)
        mean = voxels.carried(ratio, weight, NEAR_MM, FAR)
    return mean
