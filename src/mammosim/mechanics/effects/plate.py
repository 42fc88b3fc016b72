"""Contact of the skin with a rigid plate: a rounded box, frictionless, by a penalty on its signed distance d.

    E = 1/2 eps integral of <-d(x)>_+^2 over the reference area
    q = |R^T (x - c)| - (b - r),  d = |max(q, 0)| + min(max_i q_i, 0) - r,  n = grad d

b are the half sizes and r the edge radius: grad d is continuous everywhere outside the inner box q < 0.
"""

from dataclasses import dataclass, replace
from typing import Any

import numba
import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.mechanics.effects.protocol import WithoutVolume
from mammosim.mechanics.pattern import Tangent, add_to_nodes
from mammosim.mechanics.reference import (
    FACE_SHAPES,
    TRIANGLE_EDGES,
    TRIANGLE_POINTS,
    TRIANGLE_WEIGHTS,
    shape_gradients,
)

_FACE_GRADIENTS = shape_gradients(TRIANGLE_POINTS, TRIANGLE_EDGES)


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
        return _distances(x, self.centre, self.axes, self.half_sizes - self.radius, self.radius)[0]

    def normal(self, x: np.ndarray) -> np.ndarray:
        """Outward normal grad d (n, 3) at points (n, 3)."""
        return _distances(x, self.centre, self.axes, self.half_sizes - self.radius, self.radius)[1]

    def moved(self, shift: np.ndarray) -> "RoundedBox":
        """The box shifted by (3,) mm."""
        return replace(self, centre=self.centre + shift)


@dataclass(frozen=True)
class ContactState:
    """What a plate does to the skin.

    force (3,) mN on the plate; area mm2 of skin in contact, deformed; pressure (n_face, 6) kPa per deformed
    area at the quadrature points; penetration: the deepest, mm.
    """

    force: np.ndarray
    area: float
    pressure: np.ndarray
    penetration: float


@dataclass(frozen=True)
class RigidPlate(WithoutVolume):
    """faces (n_face, 6) of the skin, their reference areas (n_face, 6) mm2, and the penalty eps [kPa/mm]."""

    faces: np.ndarray
    areas: np.ndarray
    box: RoundedBox
    penalty: float

    @property
    def connectivity(self) -> np.ndarray:
        """The faces."""
        return self.faces

    def moved_to(self, box: RoundedBox) -> "RigidPlate":
        """The same contact with the plate elsewhere."""
        return replace(self, box=box)

    def _kernel_arguments(self, x: np.ndarray) -> tuple[Any, ...]:
        box = self.box
        inner = box.half_sizes - box.radius
        return x, self.faces, self.areas, FACE_SHAPES, box.centre, box.axes, inner, box.radius

    def energy(self, x: np.ndarray) -> float:
        """E = 1/2 eps integral of <-d>_+^2."""
        return self.penalty * float(np.sum(_energies(*self._kernel_arguments(x))))

    def add_gradient(self, x: np.ndarray, g: np.ndarray) -> None:
        """g_a += - integral of eps <-d> n N_a."""
        add_to_nodes(self.faces, self.penalty * _gradients(*self._kernel_arguments(x)), g)

    def add_tangent(self, x: np.ndarray, K: Tangent, *, projected: bool = False) -> None:
        """K_ab += integral of eps (n (x) n - <-d> d2d/dx2) N_a N_b, the last term not when projected."""
        Ke = _tangents(*self._kernel_arguments(x), not projected)  # type: ignore[call-arg]
        K.add(self.faces, self.penalty * Ke)

    def state(self, x: np.ndarray) -> ContactState:
        """Force, area, pressure and penetration in the loaded shape x (n_node, 3)."""
        points = np.einsum("qa,eai->eqi", FACE_SHAPES, x[self.faces])
        d = self.box.distance(points.reshape(-1, 3)).reshape(points.shape[:2])
        n = self.box.normal(points.reshape(-1, 3)).reshape(points.shape)
        tangents = np.einsum("eai,qaj->eqij", x[self.faces], _FACE_GRADIENTS)
        deformed = np.linalg.norm(np.cross(tangents[..., 0], tangents[..., 1]), axis=-1)
        deformed *= TRIANGLE_WEIGHTS
        depth = np.maximum(-d, 0.0)
        load = self.penalty * depth * self.areas
        force = -np.einsum("eq,eqi->i", load, n)
        return ContactState(force, float(deformed[d < 0].sum()), load / deformed, float(depth.max()))


@numba.njit(cache=True, inline="always")
def _distance(y, q, n, inner, radius):  # type: ignore[no-untyped-def]
    """d of y = R^T (x - c) in the box frame; fills q and the normal n; also returns |max(q, 0)|."""
    length, deepest, axis = 0.0, -np.inf, 0
    for i in range(3):
        q[i] = abs(y[i]) - inner[i]
        length += max(q[i], 0.0) ** 2
        if q[i] > deepest:
            deepest, axis = q[i], i
    length = np.sqrt(length)
    for i in range(3):
        side = 1.0 if y[i] >= 0 else -1.0
        if length > 0:
            n[i] = side * max(q[i], 0.0) / length
        else:
            n[i] = side if i == axis else 0.0
    return length + min(deepest, 0.0) - radius, length


@numba.njit(cache=True)
def _distances(x, centre, R, inner, radius):  # type: ignore[no-untyped-def]
    d, normals = np.empty(len(x)), np.empty((len(x), 3))
    q, n = np.empty(3), np.empty(3)
    for t in range(len(x)):
        d[t], _ = _distance(R.T @ (x[t] - centre), q, n, inner, radius)
        normals[t] = R @ n
    return d, normals


@numba.njit(cache=True, inline="always")
def _point(x, nodes, N, centre, R, y):  # type: ignore[no-untyped-def]
    """y = R^T (sum_a N_a x_a - c)."""
    for j in range(3):
        y[j] = 0.0
    for i in range(3):
        s = -centre[i]
        for a in range(6):
            s += N[a] * x[nodes[a], i]
        for j in range(3):
            y[j] += R[i, j] * s


@numba.njit(cache=True, parallel=True)
def _energies(x, faces, dA, N, centre, R, inner, radius):  # type: ignore[no-untyped-def]
    n_face, n_q = dA.shape
    energies = np.zeros(n_face)
    for e in numba.prange(n_face):
        y, q, n = np.empty(3), np.empty(3), np.empty(3)
        for t in range(n_q):
            _point(x, faces[e], N[t], centre, R, y)
            d, _ = _distance(y, q, n, inner, radius)
            if d < 0:
                energies[e] += dA[e, t] / 2 * d * d
    return energies


@numba.njit(cache=True, parallel=True)
def _gradients(x, faces, dA, N, centre, R, inner, radius):  # type: ignore[no-untyped-def]
    n_face, n_q = dA.shape
    ge = np.zeros((n_face, 6, 3))
    for e in numba.prange(n_face):
        y, q, n = np.empty(3), np.empty(3), np.empty(3)
        for t in range(n_q):
            _point(x, faces[e], N[t], centre, R, y)
            d, _ = _distance(y, q, n, inner, radius)
            if d < 0:
                for i in range(3):
                    n_i = R[i, 0] * n[0] + R[i, 1] * n[1] + R[i, 2] * n[2]
                    for a in range(6):
                        ge[e, a, i] += dA[e, t] * d * n_i * N[t, a]
    return ge


@numba.njit(cache=True, parallel=True)
def _tangents(x, faces, dA, N, centre, R, inner, radius, curved):  # type: ignore[no-untyped-def]
    n_face, n_q = dA.shape
    Ke = np.zeros((n_face, 6, 6, 3, 3))
    for e in numba.prange(n_face):
        y, q, n, H = np.empty(3), np.empty(3), np.empty(3), np.empty((3, 3))
        for t in range(n_q):
            _point(x, faces[e], N[t], centre, R, y)
            d, length = _distance(y, q, n, inner, radius)
            if d < 0:
                curvature = d / length if curved and length > 0.0 else 0.0
                for i in range(3):
                    for j in range(3):
                        H[i, j] = n[i] * n[j] * (1 - curvature)
                    if q[i] > 0:
                        H[i, i] += curvature
                G = R @ H @ R.T
                for a in range(6):
                    for b in range(6):
                        for i in range(3):
                            for j in range(3):
                                s = G[i, j] if i <= j else G[j, i]
                                Ke[e, a, b, i, j] += N[t, a] * N[t, b] * (dA[e, t] * s)
    return Ke
