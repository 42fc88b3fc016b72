"""The chest wall as a rigid obstacle: an elliptic cylinder, known by its exact signed distance.

In the plane of the ellipse, for y = R^T (x - c) with y_1, y_2 >= 0 by symmetry, the nearest point e solves

    e_i = a_i^2 y_i / (t + a_i^2),  sum (a_i y_i / (t + a_i^2))^2 = 1,  t > -min a_i^2  (Eberly 2013)
    d = sign(t) |y - e|,  n_i ~ e_i / a_i^2,  H = kappa / (1 + kappa d) s (x) s,  s: the tangent

with the curvature kappa = (a_1 a_2)^-2 (sum e_i^2 / a_i^4)^(-3/2) of the ellipse at e.
"""

# ASSUME: the chest wall is rigid and an elliptic cylinder, and tissue slides on it without friction.

from dataclasses import dataclass, field

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.io.compiled import njit, prange
from mammosim.mechanics.effects.contact import Obstacle, RigidContact
from mammosim.mechanics.reference import face_quadrature
from mammosim.mechanics.soundness import faces_of

_ITERATIONS = 100


@dataclass(frozen=True)
class EllipticCylinder:
    """centre c (3,) mm; semi_axes a (2,) mm along the first two columns of axes R (3, 3).

    Inside, d is smooth as far as the smallest radius of curvature. The default axes are the patient's, the
    cylinder's along z. Raises MechanicsError for semi-axes <= 0 or axes that are not orthonormal.
    """

    centre: np.ndarray
    semi_axes: np.ndarray
    axes: np.ndarray = field(default_factory=lambda: np.eye(3))

    def __post_init__(self) -> None:
        if np.shape(self.semi_axes) != (2,) or np.min(self.semi_axes) <= 0:
            raise MechanicsError(
                f"semi-axes {self.semi_axes} of the chest wall must be two lengths above 0 mm"
            )
        if not np.allclose(self.axes.T @ self.axes, np.eye(3), atol=1e-8):
            raise MechanicsError("the axes of the chest wall must be orthonormal columns")

    def distance(self, x: np.ndarray) -> np.ndarray:
        """Signed distance d (n,) mm of points (n, 3), negative inside."""
        return self._nearest(x)[0]

    def normal(self, x: np.ndarray) -> np.ndarray:
        """Outward normal grad d (n, 3) at points (n, 3)."""
        n: np.ndarray = self._nearest(x)[1] @ self.axes[:, :2].T
        return n

    def hessian(self, x: np.ndarray) -> np.ndarray:
        """d2d/dx2 (n, 3, 3) = kappa / (1 + kappa d) s (x) s."""
        d, n, kappa = self._nearest(x)
        s = np.stack([-n[:, 1], n[:, 0]], axis=1) @ self.axes[:, :2].T
        H: np.ndarray = (kappa / (1 + kappa * d))[:, None, None] * s[:, :, None] * s[:, None, :]
        return H

    def _nearest(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """d (n,), the normal (n, 2) in the plane of the ellipse, and kappa (n,) at the nearest point."""
        y = (x - self.centre) @ self.axes[:, :2]
        return _nearest(y, np.asarray(self.semi_axes, dtype=float))


def chest_wall_contact(mesh: TetMesh, wall: Obstacle, *, boundary: str, penalty: float) -> RigidContact:
    """Contact of a boundary of a mesh, whose points are the reference, with the wall; penalty eps [kPa/mm].

    Raises MechanicsError when the mesh has no such boundary.
    """
    faces = faces_of(mesh, boundary)
    return RigidContact(faces, face_quadrature(mesh.points, faces).areas, wall, penalty)


@njit(cache=True, inline="always")
def _root(y0: float, y1: float, a0: float, a1: float) -> float:
    """t of the nearest point: Newton from the left, where the sum exceeds 1, on a convex falling function."""
    t = max(a0 * (y0 - a0), a1 * (y1 - a1))
    for _ in range(_ITERATIONS):
        r0, r1 = a0 * y0 / (t + a0 * a0), a1 * y1 / (t + a1 * a1)
        value = r0 * r0 + r1 * r1 - 1
        slope = -2 * (r0 * r0 / (t + a0 * a0) + r1 * r1 / (t + a1 * a1))
        step = -value / slope
        t += step
        if step <= 1e-15 * (abs(t) + a0 * a1):
            break
    return t


@njit(cache=True, parallel=True)
def _nearest(y: np.ndarray, a: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    n_point = len(y)
    d, normals, kappa = np.empty(n_point), np.empty((n_point, 2)), np.empty(n_point)
    tiny = 1e-12 * min(a[0], a[1])
    for p in prange(n_point):
        y0, y1 = max(abs(y[p, 0]), tiny), max(abs(y[p, 1]), tiny)
        t = _root(y0, y1, a[0], a[1])
        m0, m1 = y0 / (t + a[0] ** 2), y1 / (t + a[1] ** 2)  # e_i / a_i^2
        length = np.hypot(m0, m1)
        d[p] = t * length  # y - e = t m
        normals[p, 0] = m0 / length if y[p, 0] >= 0 else -m0 / length
        normals[p, 1] = m1 / length if y[p, 1] >= 0 else -m1 / length
        kappa[p] = 1 / ((a[0] * a[1]) ** 2 * length**3)
    return d, normals, kappa
