"""A rounded box whose faces are bent along its last axis a: d(x) = d_box(x - w(x) a).

w depends on the two other coordinates of the box. n = B^T n_box, B = 1 - a (x) grad w, has a length of
sqrt(1 + |grad w|^2): d is the distance but for half the square of the slope, the energy of contact exact.
"""

# ASSUME: a plate bends along its normal only; slopes are small, so that their squares do not count.

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mammosim.mechanics.effects.plate import RoundedBox


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
