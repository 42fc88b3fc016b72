"""What a classifier is told of each voxel: intensity, its neighbourhood, and its place in the body.

Removing the slow variation of brightness that receiver coils leave.
"""

from itertools import product

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from scipy import ndimage

from mammosim.core.volume import Grid, Image
from mammosim.imaging.outline import body_mask, bright_level, largest_part, torso_depth

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


NAMES = (
    *("intensity", "smooth", "mean", "minimum", "maximum", "deviation", "gradient"),
    *("right", "left", "anterior", "posterior", "inferior", "superior"),
    *("depth_mm", "torso_depth_mm", "behind_fat_mm", "lateral_mm", "behind_front_mm", "height_mm"),
)
FAT = 0.65


def features(image: Image, *, neighbourhood_mm: float) -> np.ndarray:
    """(nz, ny, nx, n_feature) float32 in the order of NAMES; intensities are parts of the brightness of fat.

    The neighbourhood is a box of half width neighbourhood_mm; right to superior are its six middles.
    """
    body = body_mask(image)
    even = correct_bias(image)
    I = even.values / bright_level(even)
    r = np.maximum(np.round(neighbourhood_mm / image.grid.spacing[::-1]), 1).astype(int)
    return np.stack([*_neighbourhood(I, r), *_place(I, body, image.grid)], axis=-1).astype(np.float32)


def _neighbourhood(I: np.ndarray, r: np.ndarray) -> list[np.ndarray]:
    """Intensity features, each (nz, ny, nx), for a neighbourhood of r (3,) voxels in order (z, y, x)."""
    size = list(2 * r + 1)
    mean = ndimage.uniform_filter(I, size, mode="nearest")
    square = ndimage.uniform_filter(I * I, size, mode="nearest")
    return [
        I,
        ndimage.gaussian_filter(I, r / 4, mode="nearest"),
        mean,
        ndimage.minimum_filter(I, size, mode="nearest"),
        ndimage.maximum_filter(I, size, mode="nearest"),
        np.sqrt(np.maximum(square - mean**2, 0)),
        ndimage.gaussian_gradient_magnitude(I, r / 4, mode="nearest"),
        *(_shifted(I, axis, step * r[axis]) for axis in (2, 1, 0) for step in (-1, 1)),
    ]


def _shifted(I: np.ndarray, axis: int, step: int) -> np.ndarray:
    """The intensity `step` voxels further along an axis, the border repeated."""
    index = np.clip(np.arange(I.shape[axis]) + step, 0, I.shape[axis] - 1)
    return np.take(I, index, axis=axis)


def _place(I: np.ndarray, body: np.ndarray, grid: Grid) -> list[np.ndarray]:
    """Depth under skin, torso's skin and fat; distances from the midline, the front and the middle."""
    # ASSUME: the fat under the skin is the largest connected part brighter than 65 % of fat.
    dx, dy, dz = grid.spacing
    torso = torso_depth(body, grid.spacing)
    k, j, i = np.indices(body.shape, np.float32)
    columns, rows = (np.flatnonzero((torso > 0).any(axis=axis)) for axis in (0, 1))
    return [
        ndimage.distance_transform_edt(body, sampling=(dz, dy, dx)),
        np.broadcast_to(torso, body.shape),
        ndimage.distance_transform_edt(~largest_part(body & (I > FAT)), sampling=(dz, dy, dx)),
        np.abs(i - columns.mean()) * dx,
        (j - rows[0]) * dy,
        (k - (body.shape[0] - 1) / 2) * dz,
    ]
