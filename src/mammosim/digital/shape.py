"""Shapes of a virtual patient: ellipsoids, smooth unions, random waves, and a stress-free breast of them."""

from dataclasses import dataclass

import numpy as np

from mammosim.digital.patient import VirtualPatient
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


# ASSUME: a nipple is a ball whose centre lies 0.3 of its radius below the skin, blended over 3 mm.
NIPPLE_SUNK = 0.3
NIPPLE_BLEND_MM = 3.0


@dataclass(frozen=True)
class Mound:
    """side: 'left' or 'right'; centre (3,) on the chest's skin, mm; axes (3, 3): rows u, v, d, orthonormal,
    d towards the nipple, v mostly up; radii (3,) along them, mm; nipple_mm: radius of the nipple.
    """

    side: str
    centre: np.ndarray
    axes: np.ndarray
    radii: np.ndarray
    nipple_mm: float

    def local(self, points: np.ndarray) -> np.ndarray:
        """q (n, 3) mm: components of points along u, v, d from the centre."""
        return (points - self.centre) @ self.axes.T

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Signed distance (n,) to the ellipsoid, mm."""
        return ellipsoid_distance(points, self.centre, self.axes, self.radii)

    def nipple_distance(self, points: np.ndarray) -> np.ndarray:
        """Signed distance (n,) to the ball of the nipple, mm."""
        ball = self.centre + (self.radii[2] - NIPPLE_SUNK * self.nipple_mm) * self.axes[2]
        return ellipsoid_distance(points, ball, self.axes, np.full(3, self.nipple_mm))

    @property
    def nipple(self) -> np.ndarray:
        """Tip of the nipple (3,), mm."""
        return self.centre + (self.radii[2] + (1 - NIPPLE_SUNK) * self.nipple_mm) * self.axes[2]


def mounds(patient: VirtualPatient) -> tuple[Mound, Mound]:
    """The left and the right breast of a virtual patient."""
    # ASSUME: the right breast is the mirrored left one, scaled by right_scale.
    return _mound(patient, "left", 1.0, 1.0), _mound(patient, "right", -1.0, patient.breast.right_scale)


def chest_distance(patient: VirtualPatient, points: np.ndarray, *, layers_mm: float) -> np.ndarray:
    """Signed distance (n,) mm to the elliptic cylinder that lies layers_mm outside the rib cage."""
    chest = patient.chest
    r = np.array([chest.semi_axis_x_mm + layers_mm, chest.semi_axis_y_mm + layers_mm, np.inf])
    return ellipsoid_distance(points, np.array([0.0, chest.centre_y_mm, 0.0]), np.eye(3), r)


def skin_layers_mm(patient: VirtualPatient) -> float:
    """From the rib cage to the outer face of the torso's skin: muscle, fat and skin, mm."""
    return patient.chest.muscle_mm + patient.chest.fat_mm + patient.skin.mean_mm


def _mound(patient: VirtualPatient, side: str, sign: float, scale: float) -> Mound:
    breast = patient.breast
    layers = skin_layers_mm(patient)
    a, b = patient.chest.semi_axis_x_mm + layers, patient.chest.semi_axis_y_mm + layers
    y = patient.chest.centre_y_mm - b * np.sqrt(1 - (breast.side_mm / a) ** 2)
    lateral, inferior = np.radians([breast.lateral_deg, breast.inferior_deg])
    d = np.array(
        [sign * np.sin(lateral) * np.cos(inferior), -np.cos(lateral) * np.cos(inferior), -np.sin(inferior)]
    )
    u = np.cross(d, [0.0, 0.0, 1.0])
    u /= np.linalg.norm(u)
    radii = scale * np.array([breast.base_radius_mm, breast.base_radius_mm, breast.projection_mm])
    return Mound(
        side,
        np.array([sign * breast.side_mm, y, 0.0]),
        np.stack([u, np.cross(u, d), d]),
        radii,
        breast.nipple_mm,
    )
