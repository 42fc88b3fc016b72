"""Signed distances of simple bodies: negative inside, with a gradient of length 1 on the surface."""

import numpy as np

from mammosim.io.compiled import njit, prange


def ellipsoid_distance(points: np.ndarray, centre: np.ndarray, axes: np.ndarray, r: np.ndarray) -> np.ndarray:
    """d = k0 (k0 - 1) / k1, k0 = |q / r|, k1 = |q / r^2|, q = axes (p - centre): distance (n,), first order.

    points p (n, 3); axes (3, 3): orthonormal rows; r (3,): semi-axes along them, mm, infinite for a cylinder.
    Exact for a ball. Source: I. Quilez, "Ellipsoid SDF", iquilezles.org/articles/ellipsoids.
    """
    return _ellipsoid_distances(np.ascontiguousarray(points, float), centre, axes, r)


@njit(cache=True, parallel=True)
def _ellipsoid_distances(
    points: np.ndarray, centre: np.ndarray, axes: np.ndarray, r: np.ndarray
) -> np.ndarray:
    d = np.empty(len(points))
    for i in prange(len(points)):
        k0, k1 = 0.0, 0.0
        for a in range(3):
            q = 0.0
            for b in range(3):
                q += axes[a, b] * (points[i, b] - centre[b])
            k0 += (q / r[a]) ** 2
            k1 += (q / r[a] ** 2) ** 2
        k0, k1 = np.sqrt(k0), max(np.sqrt(k1), 1e-9)
        d[i] = k0 * (k0 - 1) / k1
    return d


def blend(a: np.ndarray, b: np.ndarray, k: float) -> np.ndarray:
    """Union of two bodies, creases filled over k mm: min(a, b) - k h^2 / 4, h = max(1 - |a - b| / k, 0).

    Source: I. Quilez, "Smooth minimum", iquilezles.org/articles/smin (quadratic polynomial).
    """
    h = np.maximum(1 - np.abs(a - b) / k, 0)
    return np.minimum(a, b) - k * h**2 / 4


def waves(points: np.ndarray, k: np.ndarray, phase: np.ndarray) -> np.ndarray:
    """w = sqrt(2 / m) sum_j cos(k_j . p + phase_j): a random field (n,) of variance 1; k (m, 3) rad/mm."""
    return np.sqrt(2 / len(k)) * _sum_of_cosines(np.ascontiguousarray(points, float), k, phase)


def random_waves(
    rng: np.random.Generator, count: int, shortest_mm: float, longest_mm: float
) -> tuple[np.ndarray, np.ndarray]:
    """Wave vectors k (count, 3) in rad/mm of random direction and wavelength, and phases (count,)."""
    direction = rng.normal(size=(count, 3))
    wavelength = np.exp(rng.uniform(np.log(shortest_mm), np.log(longest_mm), count))
    k = 2 * np.pi * direction / np.linalg.norm(direction, axis=1, keepdims=True) / wavelength[:, None]
    return k, rng.uniform(0, 2 * np.pi, count)


@njit(cache=True, parallel=True)
def _sum_of_cosines(points: np.ndarray, k: np.ndarray, phase: np.ndarray) -> np.ndarray:
    w = np.zeros(len(points))
    for i in prange(len(points)):
        for j in range(len(k)):
            w[i] += np.cos(
                points[i, 0] * k[j, 0] + points[i, 1] * k[j, 1] + points[i, 2] * k[j, 2] + phase[j]
            )
    return w
