"""A paddle that bends: a thin plate in a frame, by a few modes (Ritz).

U = D/2 integral of (w_ss + w_tt)^2 - 2 (1 - nu) (w_ss w_tt - w_st^2),  D = E h^3 / (12 (1 - nu^2))

s runs from the arm, where w = 0, to the chest edge, which is free; at the two sides t = +-1 w = 0.
"""

# ASSUME: the frame holds the paddle at its two sides and at the arm, free to turn; the chest edge is free.
# ASSUME: polycarbonate has a Poisson's ratio of 0.37.
# ASSUME: the paddle's weight does not bend it; the arm and the support are rigid.

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg import eigh

from mammosim.core.errors import MechanicsError
from mammosim.mechanics.effects import BentBox, RoundedBox

KPA_PER_MPA = 1e3
_POWERS = (1, 2, 3)  # of s
_GAUSS = 10


@dataclass(frozen=True)
class PlateModes:
    """Modes (9, m): of the products s^i g_j(t), g = cos(pi t / 2), sin(pi t), cos(3 pi t / 2).

    half_sizes (2,) mm along s and t; the largest deflection of a mode is 1 mm. stiffness (m,) mN/mm.
    """

    half_sizes: tuple[float, float]
    vectors: np.ndarray
    stiffness: np.ndarray

    @classmethod
    def of(cls, rigidity: float, poisson: float, half_sizes: tuple[float, float], count: int) -> "PlateModes":
        """The `count` softest modes of a plate of rigidity D [mN mm]: K v = k M v, M the mean square."""
        points, weights = np.polynomial.legendre.leggauss(_GAUSS)
        y = np.stack(np.meshgrid(points, points, indexing="ij"), axis=-1).reshape(-1, 2) * half_sizes
        area = np.outer(weights, weights).ravel() * half_sizes[0] * half_sizes[1]
        w, _, second = _products(y, half_sizes)
        ss, tt, st = second[..., 0, 0], second[..., 1, 1], second[..., 0, 1]

        def form(a: np.ndarray, b: np.ndarray) -> np.ndarray:
            integral: np.ndarray = np.einsum("q,qi,qj->ij", area, a, b)
            return integral

        K = form(ss + tt, ss + tt) - (1 - poisson) * (form(ss, tt) + form(tt, ss) - 2 * form(st, st))
        _, vectors = eigh(rigidity * K, form(w, w))
        vectors = vectors[:, :count] / _largest(vectors[:, :count], half_sizes)
        return cls(half_sizes, vectors, np.einsum("im,ij,jm->m", vectors, rigidity * K, vectors))

    def at(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """w (n, m), grad w (n, m, 2) and second derivatives (n, m, 2, 2) of the modes at y (n, 2) mm."""
        w, slope, curvature = _products(y, self.half_sizes)
        V = self.vectors
        return w @ V, np.einsum("nki,km->nmi", slope, V), np.einsum("nkij,km->nmij", curvature, V)


@dataclass(frozen=True)
class Bending:
    """Modes with amplitudes q (m,) mm: a Deflection."""

    modes: PlateModes
    q: np.ndarray

    def at(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """See Deflection."""
        w, slope, curvature = self.modes.at(y)
        q = self.q
        return w @ q, np.einsum("nmi,m->ni", slope, q), np.einsum("nmij,m->nij", curvature, q)


@dataclass(frozen=True)
class Flexible:
    """A plate of Young's modulus [MPa] and thickness [mm] in its frame, by its softest modes.

    The default Poisson's ratio is that of polycarbonate. Raises MechanicsError for values out of range.
    """

    youngs_modulus_mpa: float
    thickness_mm: float
    poisson_ratio: float = 0.37
    modes: int = 4

    def __post_init__(self) -> None:
        good = self.youngs_modulus_mpa > 0 and self.thickness_mm > 0 and 0 <= self.poisson_ratio < 0.5
        if not good or not 1 <= self.modes <= 9:
            raise MechanicsError(
                f"a flexible paddle of {self.youngs_modulus_mpa:g} MPa, {self.thickness_mm:g} mm, nu "
                f"{self.poisson_ratio:g}, {self.modes} modes: all above 0, nu in [0, 0.5), 1 to 9 modes"
            )

    def _modes(self, half_sizes: np.ndarray) -> PlateModes:
        E, h, nu = KPA_PER_MPA * self.youngs_modulus_mpa, self.thickness_mm, self.poisson_ratio
        rigidity = E * h**3 / (12 * (1 - nu**2))
        return _modes(rigidity, nu, (float(half_sizes[0]), float(half_sizes[1])), self.modes)

    @property
    def unknowns(self) -> int:
        """How many amplitudes."""
        return self.modes

    def stiffness(self, half_sizes: np.ndarray) -> np.ndarray:
        """K (m, m) mN/mm."""
        return np.diag(self._modes(half_sizes).stiffness)

    def reach(self, half_sizes: np.ndarray) -> np.ndarray:
        """How far the face moves at most for a unit of each unknown (m,), mm."""
        return np.ones(self.modes)

    def placed(self, box: RoundedBox, q: np.ndarray) -> BentBox:
        """The paddle bent by the amplitudes q (m,) mm, away from the support where positive."""
        return BentBox(box, Bending(self._modes(box.half_sizes), q))

    def middle(self, half_sizes: np.ndarray) -> np.ndarray:
        """That of both plates."""
        return np.zeros(2)

    def rise(self, y: np.ndarray, box: RoundedBox, q: np.ndarray) -> np.ndarray:
        """See Paddle."""
        return Bending(self._modes(box.half_sizes), q).at(y)[0]

    def tilt_deg(self, q: np.ndarray) -> float:
        """It does not tilt."""
        return 0.0


@lru_cache(maxsize=8)
def _modes(rigidity: float, poisson: float, half_sizes: tuple[float, float], count: int) -> PlateModes:
    return PlateModes.of(rigidity, poisson, half_sizes, count)


def _largest(vectors: np.ndarray, half_sizes: tuple[float, float]) -> np.ndarray:
    """The value (m,) that is largest in size on the plate."""
    grid = np.linspace(-1.0, 1.0, 41)
    y = np.stack(np.meshgrid(grid, grid, indexing="ij"), axis=-1).reshape(-1, 2) * half_sizes
    w = _products(y, half_sizes)[0] @ vectors
    largest: np.ndarray = w[np.abs(w).argmax(axis=0), np.arange(w.shape[1])]
    return largest


def _products(y: np.ndarray, half_sizes: tuple[float, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """s^i g_j(t) (n, 9), their gradients (n, 9, 2) 1/mm and second derivatives (n, 9, 2, 2) at y (n, 2)."""
    b0, b1 = half_sizes
    s, t = (b0 - y[:, 0]) / (2 * b0), y[:, 1] / b1
    ds, dt = -1 / (2 * b0), 1 / b1
    f = [_power(s, i, ds) for i in _POWERS]
    g = [_wave(np.cos, np.pi / 2, t, dt), _wave(np.sin, np.pi, t, dt), _wave(np.cos, 1.5 * np.pi, t, dt)]
    w = np.stack([a[0] * b[0] for a in f for b in g], axis=1)
    slope = np.stack([np.stack([a[1] * b[0], a[0] * b[1]], axis=-1) for a in f for b in g], axis=1)
    second = [np.stack([a[2] * b[0], a[1] * b[1], a[1] * b[1], a[0] * b[2]], axis=-1) for a in f for b in g]
    return w, slope, np.stack(second, axis=1).reshape(*w.shape, 2, 2)


def _power(s: np.ndarray, i: int, ds: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """s^i and two derivatives."""
    return s**i, i * s ** (i - 1) * ds, i * (i - 1) * s ** max(i - 2, 0) * ds**2


def _wave(form: np.ufunc, k: float, t: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """form(k t) and two derivatives."""
    turned = -np.sin(k * t) if form is np.cos else np.cos(k * t)
    return form(k * t), k * dt * turned, -((k * dt) ** 2) * form(k * t)
