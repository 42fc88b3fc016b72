"""Automatic exposure: the mAs at which the detector behind the breast receives a wanted air kerma."""

import numpy as np
from scipy.ndimage import uniform_filter

from mammosim.core.errors import XrayError


def automatic_mas(
    kerma_mgy_per_mas: np.ndarray, breast: np.ndarray, *, target_mgy: float, sensor_pixels: int
) -> float:
    """mAs = target/K, K the least mean air kerma of a square of sensor_pixels^2 behind the breast.

    kerma_mgy_per_mas: (nv, nu) at the detector; breast: (nv, nu) bool, its shadow.
    Raises XrayError when the target is not positive, or no such square fits in the shadow.
    """
    # ASSUME: automatic exposure sees the air kerma of the primary behind the densest square of the breast.
    if not 0 < target_mgy < np.inf:
        raise XrayError(
            f"target_mgy = {target_mgy} must be positive; detectors are exposed to 0.02 to 0.2 mGy"
        )
    size = sensor_pixels
    inside = uniform_filter(breast.astype(float), size, mode="constant") > 1 - 0.5 / size**2
    if not inside.any():
        raise XrayError(
            f"no square of {size} x {size} pixels fits in the breast's shadow; make sensor_pixels smaller"
        )
    K = uniform_filter(kerma_mgy_per_mas, size, mode="nearest")[inside].min()
    return float(target_mgy / K)
