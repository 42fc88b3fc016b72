"""The chest wall as a rigid obstacle: an elliptic cylinder, known by its exact signed distance.

In the plane of the ellipse, for y = R^T (x - c) with y_1, y_2 >= 0 by symmetry, the nearest point e solves

    e_i = a_i^2 y_i / (t + a_i^2),  sum (a_i y_i / (t + a_i^2))^2 = 1,  t > -min a_i^2  (Eberly 2013)
    d = sign(t) |y - e|,  n_i ~ e_i / a_i^2,  H = kappa / (1 + kappa d) s (x) s,  s: the tangent

with the curvature kappa = (a_1 a_2)^-2 (sum e_i^2 / a_i^4)^(-3/2) of the ellipse at e.

Sliding: the back of the breast stays at its distance from the muscle, and moves along it.

E = 1/2 integral of eps (d(x) - d(X))^2 + kappa |T (x - X)|^2 over the reference area,  T = 1 - n(X) (x) n(X)

d is the signed distance of the wall, eps the stiffness against approaching or leaving it, kappa that of the
loose tissue along it: zero for free sliding.
"""

from dataclasses import dataclass, field

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.io.compiled import njit, prange
from mammosim.mechanics.effects.contact import Obstacle, RigidContact
from mammosim.mechanics.effects.pointwise import gathered_forces, gathered_stiffness, positions
from mammosim.mechanics.effects.protocol import WithoutVolume
from mammosim.mechanics.pattern import Tangent, add_to_nodes
from mammosim.mechanics.reference import FACE_SHAPES, face_quadrature, faces_of

# ASSUME: the chest wall is rigid and an elliptic cylinder, and tissue slides on it without friction.


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


# ASSUME: the layer on which the breast slides is thin; it ties the breast to the wall in both directions.
# ASSUME: the loose tissue along the wall pulls back in proportion to the slip, in the plane where it began.


@dataclass(frozen=True)
class Sliding(WithoutVolume):
    """faces (n_face, 6), reference areas (n_face, 6) mm2, points X (n_node, 3) mm; eps and kappa [kPa/mm].

    Raises MechanicsError for eps <= 0 or kappa < 0.
    """

    faces: np.ndarray
    areas: np.ndarray
    points: np.ndarray
    wall: Obstacle
    normal_stiffness: float
    tangential_stiffness: float = 0.0

    def __post_init__(self) -> None:
        if self.normal_stiffness <= 0 or self.tangential_stiffness < 0:
            raise MechanicsError(
                f"sliding with eps = {self.normal_stiffness:g} (above 0) and kappa = "
                f"{self.tangential_stiffness:g} (at least 0) kPa/mm"
            )

    @classmethod
    def of(
        cls,
        mesh: TetMesh,
        wall: Obstacle,
        *,
        normal_stiffness: float,
        tangential_stiffness: float = 0.0,
        boundary: str = "posterior",
    ) -> "Sliding":
        """The boundary of a mesh, whose points are the reference, slides on a wall.

        Nodes that slide must not be held: pass `held` to the equilibrium without them.
        Raises MechanicsError as the class does, and when the mesh has no such boundary.
        """
        faces = faces_of(mesh, boundary)
        areas = face_quadrature(mesh.points, faces).areas
        return cls(faces, areas, mesh.points, wall, normal_stiffness, tangential_stiffness)

    @property
    def connectivity(self) -> np.ndarray:
        """The faces."""
        return self.faces

    def _state(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """y (n, 3), the gap d(x) - d(X) (n,) and the slip T (x - X) (n, 3), n = 6 n_face."""
        y, Y = (positions(at, self.faces, FACE_SHAPES).reshape(-1, 3) for at in (x, self.points))
        u, n = y - Y, self.wall.normal(Y)
        return y, self.wall.distance(y) - self.wall.distance(Y), u - np.sum(u * n, axis=1)[:, None] * n

    def energy(self, x: np.ndarray) -> float:
        """E = 1/2 integral of eps gap^2 + kappa |slip|^2."""
        _, gap, slip = self._state(x)
        density = self.normal_stiffness * gap**2 + self.tangential_stiffness * np.sum(slip**2, axis=1)
        return float(np.sum(self.areas.ravel() * density)) / 2

    def add_gradient(self, x: np.ndarray, g: np.ndarray) -> None:
        """g_a += integral of (eps gap n(x) + kappa slip) N_a."""
        y, gap, slip = self._state(x)
        t = self.normal_stiffness * gap[:, None] * self.wall.normal(y) + self.tangential_stiffness * slip
        t = t.reshape(*self.areas.shape, 3) * self.areas[..., None]
        add_to_nodes(self.faces, gathered_forces(t, FACE_SHAPES), g)

    def add_tangent(self, x: np.ndarray, K: Tangent, *, projected: bool = False) -> None:
        """K_ab += integral of (eps (n (x) n + gap H) + kappa T) N_a N_b, without H when projected."""
        y, gap, _ = self._state(x)
        n, N = (
            self.wall.normal(y),
            self.wall.normal(positions(self.points, self.faces, FACE_SHAPES).reshape(-1, 3)),
        )
        M = n[:, :, None] * n[:, None, :]
        if not projected:
            M += gap[:, None, None] * self.wall.hessian(y)
        M *= self.normal_stiffness
        M += self.tangential_stiffness * (np.eye(3) - N[:, :, None] * N[:, None, :])
        M = M.reshape(*self.areas.shape, 3, 3) * self.areas[..., None, None]
        K.add(self.faces, gathered_stiffness(M, FACE_SHAPES))
