"""Sums of slices as a detector parallel to them sees them, and the exact transpose: the compiled loops.

The ray to pixel (r, c) crosses slice k at the voxel (y, x) = (y0 + y1 r, x0 + x1 c), and reads it linearly
between voxels, zero outside. Rows and columns separate: along x once per row of voxels, then along y.

    p[r, c] = sum_k sum_j Y_k[r, j] sum_i X_k[c, i] V[k, j, i]
"""

import numpy as np

from mammosim.io.compiled import njit, prange

BLOCK = 32  # rows of pixels traced together, so that what they share stays in the cache


@njit(cache=True)
def taps(start: float, step: float, size: int, place: np.ndarray, low: np.ndarray, high: np.ndarray) -> None:
    """Where start + step n falls in 0..size-1 with a zero at each end: place, weights of it and the next."""
    for n in range(len(place)):
        at = min(max(start + step * n + 1.0, 0.0), size + 1.0)
        i = min(int(at), size)
        place[n] = i
        low[n], high[n] = 1.0 - (at - i), at - i


@njit(cache=True, parallel=True)
def add_sums(volume: np.ndarray, across: np.ndarray, image: np.ndarray) -> None:
    """Adds to image (nv, nu) the sums p of volume (nz, ny, nx); across (nz, 4): x0, x1, y0, y1."""
    nz, ny, nx = volume.shape
    nv, nu = image.shape
    for block in prange((nv + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min((block + 1) * BLOCK, nv)
        at_x, low_x, high_x = np.empty(nu, np.uint32), np.empty(nu, image.dtype), np.empty(nu, image.dtype)
        at_y, low_y, high_y = np.empty(nv, np.uint32), np.empty(nv, image.dtype), np.empty(nv, image.dtype)
        row = np.zeros(nx + 2, image.dtype)
        crossed = np.zeros((ny + 2, nu), image.dtype)
        for k in range(nz):
            taps(across[k, 0], across[k, 1], nx, at_x, low_x, high_x)
            taps(across[k, 2], across[k, 3], ny, at_y, low_y, high_y)
            j_first = max(min(at_y[first], at_y[last - 1]), 1)
            j_last = min(max(at_y[first], at_y[last - 1]) + 1, ny)
            for j in range(j_first, j_last + 1):
                row[1 : nx + 1] = volume[k, j - 1]
                for c in range(nu):
                    crossed[j, c] = low_x[c] * row[at_x[c]] + high_x[c] * row[at_x[c] + np.uint32(1)]
            for r in range(first, last):
                below, above = crossed[at_y[r]], crossed[at_y[r] + 1]
                w_low, w_high = low_y[r], high_y[r]
                for c in range(nu):
                    image[r, c] += w_low * below[c] + w_high * above[c]


@njit(cache=True, parallel=True)
def add_transposed(
    image: np.ndarray, across: np.ndarray, per_voxel: tuple[np.ndarray, np.ndarray], volume: np.ndarray
) -> None:
    """Adds to volume (nz, ny, nx) per_y[k, j] per_x[k, i] times the transposed sums of image (nv, nu).

    per_voxel: (per_y (nz, ny), per_x (nz, nx)).
    """
    nz, ny, nx = volume.shape
    nv, nu = image.shape
    per_y, per_x = per_voxel
    for k in prange(nz):
        at_x, low_x, high_x = np.empty(nu, np.uint32), np.empty(nu, image.dtype), np.empty(nu, image.dtype)
        at_y, low_y, high_y = np.empty(nv, np.uint32), np.empty(nv, image.dtype), np.empty(nv, image.dtype)
        taps(across[k, 0], across[k, 1], nx, at_x, low_x, high_x)
        taps(across[k, 2], across[k, 3], ny, at_y, low_y, high_y)
        crossed = np.zeros((ny + 2, nu), image.dtype)
        for r in range(nv):
            below, above = crossed[at_y[r]], crossed[at_y[r] + 1]
            w_low, w_high = low_y[r], high_y[r]
            for c in range(nu):
                below[c] += w_low * image[r, c]
                above[c] += w_high * image[r, c]
        row = np.zeros(nx + 2, image.dtype)
        for j in range(1, ny + 1):
            row[:] = 0
            for c in range(nu):
                row[at_x[c]] += low_x[c] * crossed[j, c]
                row[at_x[c] + np.uint32(1)] += high_x[c] * crossed[j, c]
            for i in range(nx):
                volume[k, j - 1, i] += per_y[k, j - 1] * per_x[k, i] * row[i + 1]
