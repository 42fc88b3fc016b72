"""Removing the slow variation of brightness that receiver coils leave."""

from itertools import product

import numpy as np
from numpy.polynomial.chebyshev import chebvander

from mammosim.core.volume import Image
from mammosim.imaging.outline import bright_level

# ASSUME: the logarithm of the bias field is a polynomial of total degree 3 in x, y and z.
POWERS = sorted((p for p in product(range(4), repeat=3) if sum(p) <= 3), key=sum)
# ASSUME: fat is what exceeds 40 % of the brightness of fat and ends up within 25 % of the fitted field.
BRIGHT, WIDTH = 0.4, 0.25
FIRST_WIDTH, ITERATIONS = 0.8, 20
RIDGE = 1e-3  # holds the polynomial back where there is no fat
SAMPLES = 30_000


def correct_bias(image: Image) -> Image:
    """The image over its bias field b, fitted to fat: log I = log I_fat + log b + noise."""
    fat = np.argwhere(image.values > BRIGHT * bright_level(image))
    fat = fat[:: len(fat) // SAMPLES + 1]
    c = _fit(_terms(fat, image.grid.shape), np.log(image.values[tuple(fat.T)]))
    _, ny, nx = image.grid.shape
    axial = np.argwhere(np.ones((1, ny, nx)))
    slices = (axial + np.array([k, 0, 0]) for k in range(image.grid.shape[0]))
    log_b = np.stack([_terms(voxels, image.grid.shape) @ c for voxels in slices])
    return Image(image.grid, (image.values / np.exp(log_b.reshape(image.grid.shape))).astype(np.float32))


def _fit(A: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The c that minimises sum w (A c - y)^2, w = (1 - r^2 / width^2)^2, r = A c - y (Tukey), without c_0.

    The width shrinks to WIDTH while gland and skin, darker than fat, lose their say.
    """
    c = np.zeros(A.shape[1])
    c[0] = np.percentile(y, 75)
    ridge = RIDGE * len(y) * np.diag([0.0, *np.ones(len(c) - 1)])
    for width in np.geomspace(FIRST_WIDTH, WIDTH, ITERATIONS):
        w = np.maximum(1 - ((A @ c - y) / width) ** 2, 0) ** 2
        c = np.linalg.solve(A.T @ (w[:, None] * A) + ridge, A.T @ (w * y))
    return c * np.array([0.0, *np.ones(len(c) - 1)])


def _terms(indices: np.ndarray, shape: tuple[int, int, int]) -> np.ndarray:
    """Chebyshev polynomials (n, n_term) of voxel indices (n, 3), each coordinate scaled to [-1, 1]."""
    u = 2 * indices / np.maximum(np.array(shape) - 1, 1) - 1
    T = [chebvander(u[:, axis], max(map(max, POWERS))) for axis in range(3)]
    return np.stack([T[0][:, a] * T[1][:, b] * T[2][:, c] for a, b, c in POWERS], axis=1)
