"""An active contour on a probability: grown from seeds, then smoothed by its curvature."""

import numpy as np
from scipy import ndimage

# ASSUME: a voxel of which the classifier is sure by 90 % is a seed, as the strokes are.
SURE = 0.9


def speed(p: np.ndarray) -> np.ndarray:
    """S = 2 p - 1 in [-1, 1] of a probability: outward where the tissue is likely, inward elsewhere."""
    return 2 * p - 1


def grow(p: np.ndarray, seeds: np.ndarray, *, within: np.ndarray, smoothing: int) -> np.ndarray:
    """Region (nz, ny, nx) bool that a contour reaches from seeds where S > 0, smoothed by curvature.

    p, seeds, within: (nz, ny, nx); smoothing: number of curvature steps.
    Each step is threshold dynamics (Merriman, Bence & Osher 1992; with a data term Esedoglu & Tsai 2006),
    u <- [G * (2 u - 1) + S > 0] with a Gaussian G of one voxel: the front moves by its curvature and by S.
    """
    S = np.where(within, speed(p), -1.0).astype(np.float32)
    start = (seeds | (p >= SURE)) & (S > 0)
    u = ndimage.binary_propagation(start, mask=S > 0)
    for _ in range(smoothing):
        u = (ndimage.gaussian_filter(2 * u.astype(np.float32) - 1, 1.0, truncate=3.0) + S > 0) & within
    return u
