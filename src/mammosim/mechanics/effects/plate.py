"""The faces of plates: a rounded box.

    q = |R^T (x - c)| - (b - r),  d = |max(q, 0)| + min(max_i q_i, 0) - r

b are the half sizes and r the edge radius: grad d is continuous everywhere outside the inner box q < 0.

A rounded box whose faces are bent along its last axis a: d(x) = d_box(x - w(x) a).

w depends on the two other coordinates of the box. n = B^T n_box, B = 1 - a (x) grad w, has a length of
sqrt(1 + |grad w|^2): d is the distance but for half the square of the slope, the energy of contact exact.
"""

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.io.compiled import njit, prange
from mammosim.mechanics.effects.contact import Obstacle


@dataclass(frozen=True)
class RoundedBox:
    """A box with rounded edges: centre c (3,) mm, axes R (3, 3) in columns, half sizes b (3,), radius r mm.

    Raises MechanicsError when the radius exceeds a half size, or the axes are not orthonormal.
    """

    centre: np.ndarray
    axes: np.ndarray
    half_sizes: np.ndarray
    radius: float

    def __post_init__(self) -> None:
        if not 0 < self.radius <= np.min(self.half_sizes):
            raise MechanicsError(
                f"edge radius {self.radius:g} mm must be in (0, {np.min(self.half_sizes):g}] mm, "
                "at most half the plate's thickness"
            )
        if not np.allclose(self.axes.T @ self.axes, np.eye(3), atol=1e-8):
            raise MechanicsError("the axes of a plate must be orthonormal columns")

    def distance(self, x: np.ndarray) -> np.ndarray:
        """Signed distance d (n,) mm of points (n, 3), negative inside."""
        return _distances(x, self.centre, self.axes, self.half_sizes - self.radius, self.radius)

    def normal(self, x: np.ndarray) -> np.ndarray:
        """Outward normal grad d (n, 3) at points (n, 3)."""
        return _normals(x, self.centre, self.axes, self.half_sizes - self.radius)

    def hessian(self, x: np.ndarray) -> np.ndarray:
        """d2d/dx2 (n, 3, 3): (1 - n (x) n) / |max(q, 0)| in the directions i of q_i > 0, else zero."""
        return _hessians(x, self.centre, self.axes, self.half_sizes - self.radius)

    def material(self, x: np.ndarray) -> np.ndarray:
        """Coordinates y (n, 3) = R^T (x - c) along the axes of the box, mm."""
        y: np.ndarray = (x - self.centre) @ self.axes
        return y

    def position(self, y: np.ndarray) -> np.ndarray:
        """x (n, 3) = c + R y."""
        x: np.ndarray = self.centre + y @ self.axes.T
        return x

    def steepness(self, x: np.ndarray) -> np.ndarray:
        """|grad d| (n,) = 1."""
        return np.ones(len(x))

    def moved(self, shift: np.ndarray) -> "RoundedBox":
        """The box shifted by (3,) mm."""
        return replace(self, centre=self.centre + shift)


class PlateFace(Obstacle, Protocol):
    """An obstacle with coordinates of its own, which move with it.

    half_sizes (3,) mm along them, and the radius of its edges, mm.
    """

    @property
    def half_sizes(self) -> np.ndarray:
        """See above."""

    @property
    def radius(self) -> float:
        """See above."""

    def material(self, x: np.ndarray) -> np.ndarray:
        """Its coordinates (n, 3) of points (n, 3), mm."""
        ...

    def position(self, y: np.ndarray) -> np.ndarray:
        """The points (n, 3) of coordinates (n, 3)."""
        ...

    def steepness(self, x: np.ndarray) -> np.ndarray:
        """|grad d| (n,) at points (n, 3): what presses there along the normal, over what the depth d says."""
        ...


@njit(cache=True, inline="always")
def _overlap(
    x: np.ndarray, centre: np.ndarray, R: np.ndarray, inner: np.ndarray, y: np.ndarray, q: np.ndarray
) -> tuple[float, int]:
    """y = R^T (x - c), q = |y| - (b - r); returns |max(q, 0)| and the axis of the largest q."""
    length, axis = 0.0, 0
    for i in range(3):
        y[i] = R[0, i] * (x[0] - centre[0]) + R[1, i] * (x[1] - centre[1]) + R[2, i] * (x[2] - centre[2])
        q[i] = abs(y[i]) - inner[i]
        length += max(q[i], 0.0) ** 2
        if q[i] > q[axis]:
            axis = i
    return np.sqrt(length), axis


@njit(cache=True, inline="always")
def _normal(y: np.ndarray, q: np.ndarray, n: np.ndarray, length: float, axis: int) -> None:
    """n = grad d in the axes of the box."""
    for i in range(3):
        side = 1.0 if y[i] >= 0 else -1.0
        if length > 0:
            n[i] = side * max(q[i], 0.0) / length
        else:
            n[i] = side if i == axis else 0.0


@njit(cache=True, parallel=True)
def _distances(
    x: np.ndarray, centre: np.ndarray, R: np.ndarray, inner: np.ndarray, radius: float
) -> np.ndarray:
    d = np.empty(len(x))
    for t in prange(len(x)):
        y, q = np.empty(3), np.empty(3)
        length, axis = _overlap(x[t], centre, R, inner, y, q)
        d[t] = length + min(q[axis], 0.0) - radius
    return d


@njit(cache=True, parallel=True)
def _normals(x: np.ndarray, centre: np.ndarray, R: np.ndarray, inner: np.ndarray) -> np.ndarray:
    normals = np.empty((len(x), 3))
    for t in prange(len(x)):
        y, q, n = np.empty(3), np.empty(3), np.empty(3)
        length, axis = _overlap(x[t], centre, R, inner, y, q)
        _normal(y, q, n, length, axis)
        for i in range(3):
            normals[t, i] = R[i, 0] * n[0] + R[i, 1] * n[1] + R[i, 2] * n[2]
    return normals


@njit(cache=True, parallel=True)
def _hessians(x: np.ndarray, centre: np.ndarray, R: np.ndarray, inner: np.ndarray) -> np.ndarray:
    hessians = np.zeros((len(x), 3, 3))
    for t in prange(len(x)):
        y, q, n = np.empty(3), np.empty(3), np.empty(3)
        length, axis = _overlap(x[t], centre, R, inner, y, q)
        if length > 0:
            _normal(y, q, n, length, axis)
            for k in range(3):
                for l in range(3):
                    # H of the box's own axes k, l
                    h = -n[k] * n[l] / length
                    if k == l and q[k] > 0:
                        h += 1 / length
                    for i in range(3):
                        for j in range(3):
                            hessians[t, i, j] += h * (R[i, k] * R[j, l])
    return hessians


# ASSUME: a plate bends along its normal only; slopes are small, so that their squares do not count.


class Deflection(Protocol):
    """w of places y (n, 2) mm, in the coordinates of the box, and its derivatives."""

    def at(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """w (n,) mm, grad w (n, 2), and its second derivatives (n, 2, 2) 1/mm."""
        ...


@dataclass(frozen=True)
class BentBox:
    """A box and the deflection w of its faces along its last axis."""

    box: RoundedBox
    deflection: Deflection

    @property
    def half_sizes(self) -> np.ndarray:
        """Of the straight box (3,), mm."""
        return self.box.half_sizes

    @property
    def radius(self) -> float:
        """Of its edges, mm."""
        return self.box.radius

    def _straightened(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """x - w a (n, 3), grad w (n, 3) and the second derivatives (n, 3, 3) of w in space."""
        R = self.box.axes
        w, slope, curvature = self.deflection.at(self.box.material(x)[:, :2])
        P = R[:, :2]
        return x - w[:, None] * R[:, 2], slope @ P.T, P @ curvature @ P.T

    def distance(self, x: np.ndarray) -> np.ndarray:
        """d (n,) mm of points (n, 3), negative inside."""
        return self.box.distance(self._straightened(x)[0])

    def normal(self, x: np.ndarray) -> np.ndarray:
        """grad d (n, 3) = n_box - (n_box . a) grad w."""
        x, slope, _ = self._straightened(x)
        n = self.box.normal(x)
        normal: np.ndarray = n - (n @ self.box.axes[:, 2])[:, None] * slope
        return normal

    def hessian(self, x: np.ndarray) -> np.ndarray:
        """d2d/dx2 (n, 3, 3) = B^T H_box B - (n_box . a) d2w/dx2."""
        x, slope, curvature = self._straightened(x)
        a = self.box.axes[:, 2]
        B = np.eye(3) - a[:, None] * slope[:, None, :]
        along = (self.box.normal(x) @ a)[:, None, None]
        H: np.ndarray = np.swapaxes(B, 1, 2) @ self.box.hessian(x) @ B - along * curvature
        return H

    def material(self, x: np.ndarray) -> np.ndarray:
        """Coordinates (n, 3) in the straight box of points (n, 3)."""
        return self.box.material(self._straightened(x)[0])

    def position(self, y: np.ndarray) -> np.ndarray:
        """Points (n, 3) of coordinates y (n, 3) in the straight box."""
        w, _, _ = self.deflection.at(y[:, :2])
        x: np.ndarray = self.box.position(y) + w[:, None] * self.box.axes[:, 2]
        return x

    def steepness(self, x: np.ndarray) -> np.ndarray:
        """1 (n,): small slopes."""
        return np.ones(len(x))


# ASSUME: on a shaped face d is measured along the plate's axis: where it slopes, contact and cushion are
# stiffer by the square of the slope than across their thickness, 3 % at 10 degrees.
@dataclass(frozen=True)
class ShapedBox(BentBox):
    """A box whose faces have a shape, of slopes that count."""

    def steepness(self, x: np.ndarray) -> np.ndarray:
        """|grad d| (n,) = sqrt(1 + |grad w|^2) on the face."""
        steepness: np.ndarray = np.linalg.norm(self.normal(x), axis=1)
        return steepness
