"""Frictionless contact of a surface with a rigid obstacle, by a penalty on the signed distance d.

E = 1/2 eps integral of <-d(x)>_+^2 over the reference area,  n = grad d,  H = d2d/dx2

Coulomb friction of a surface on an obstacle, as a potential for one step of the way.

E = mu sum of lambda F(|s|),  s = T (y - a),  T = 1 - n (x) n
F'(s) = 2 s/g - (s/g)^2 for s < g, 1 above: sticking up to the slip g, then mu lambda against the slip

lambda is the normal force of each point and n the normal there, both known from before (lagged; Li et al.
2020), a the place on the obstacle where the point sticks. So E is convex in y, and its tangent symmetric.

Quadrature on quadratic triangles that follows the border of a contact: the six points, or finer.

The integrand of contact has a kink where contact begins, so that more points help, a higher degree does not.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol, Self

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.mechanics.effects.pointwise import gathered_forces, gathered_stiffness, positions
from mammosim.mechanics.effects.protocol import WithoutVolume
from mammosim.mechanics.pattern import Tangent, add_to_nodes
from mammosim.mechanics.reference import (
    TRIANGLE,
    TRIANGLE_POINTS,
    TRIANGLE_WEIGHTS,
    shape_functions,
    shape_gradients,
)


@dataclass(frozen=True)
class FaceRule:
    """Barycentric points L (n_q, 3) with weights (n_q,), which sum to the triangle's area 1/2."""

    points: np.ndarray
    weights: np.ndarray

    @cached_property
    def shapes(self) -> np.ndarray:
        """N (n_q, 6)."""
        return shape_functions(self.points, TRIANGLE)

    @cached_property
    def gradients(self) -> np.ndarray:
        """dN/dxi (n_q, 6, 2)."""
        return shape_gradients(self.points, TRIANGLE)

    @cached_property
    def hats(self) -> np.ndarray:
        """H (n_q, 6) >= 0: functions that are linear in each quarter of the triangle and 1 at one node."""
        L = self.points
        at_corners = np.maximum(2 * L - 1, 0.0)
        in_corner = at_corners > 0
        # In the quarter at a corner the two edges that meet there, in the middle all three.
        at_edges = [
            np.where(in_corner[:, b], 2 * L[:, a], np.where(in_corner[:, a], 2 * L[:, b], 1 - 2 * L[:, c]))
            * ~in_corner[:, c]
            for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
        ]
        return np.column_stack([at_corners, *at_edges])

    def areas(self, x: np.ndarray, faces: np.ndarray) -> np.ndarray:
        """Area (n_face, n_q) mm2 that each point stands for, of faces (n_face, 6) in x (n_node, 3)."""
        tangents = np.einsum("eai,qaj->eqij", x[faces], self.gradients)
        areas: np.ndarray = (
            np.linalg.norm(np.cross(tangents[..., 0], tangents[..., 1]), axis=-1) * self.weights
        )
        return areas


SIX_POINTS = FaceRule(TRIANGLE_POINTS, TRIANGLE_WEIGHTS)


def six_points_in_each(parts: int) -> FaceRule:
    """The six points in each of parts^2 equal triangles. Raises MechanicsError unless parts >= 1."""
    if parts < 1:
        raise MechanicsError(f"a face is cut into {parts} parts along its edges; it must be at least 1")
    corners = []
    for i in range(parts):
        for j in range(parts - i):
            k = parts - 1 - i - j
            corners.append([[i + 1, j, k], [i, j + 1, k], [i, j, k + 1]])
            if k > 0:
                corners.append([[i, j + 1, k], [i + 1, j, k], [i + 1, j + 1, k - 1]])
    L = np.concatenate([TRIANGLE_POINTS @ (np.array(corner) / parts) for corner in corners])
    return FaceRule(L, np.tile(TRIANGLE_WEIGHTS, parts**2) / parts**2)


class Obstacle(Protocol):
    """A rigid shape, known by the signed distance of points (n, 3), mm, negative inside."""

    def distance(self, x: np.ndarray) -> np.ndarray:
        """d (n,) mm."""
        ...

    def normal(self, x: np.ndarray) -> np.ndarray:
        """n = grad d (n, 3)."""
        ...

    def hessian(self, x: np.ndarray) -> np.ndarray:
        """H = d2d/dx2 (n, 3, 3), 1/mm."""
        ...


@dataclass(frozen=True)
class ContactState:
    """What an obstacle does to a surface.

    force (3,) mN on the obstacle; areas (n_face, n_q) mm2 of surface in contact, deformed; pressure
    (n_face, n_q) kPa per deformed area at the quadrature points; penetration: the deepest, mm.
    """

    force: np.ndarray
    areas: np.ndarray
    pressure: np.ndarray
    penetration: float

    @property
    def area(self) -> float:
        """Of the surface in contact, mm2."""
        return float(self.areas.sum())

    @property
    def face_pressure(self) -> np.ndarray:
        """The mean pressure (n_face,) kPa of each face over its part in contact."""
        load = np.sum(self.pressure * self.areas, axis=1)
        mean: np.ndarray = load / np.maximum(self.areas.sum(axis=1), 1e-300)
        return mean


@dataclass(frozen=True)
class RigidContact(WithoutVolume):
    """faces (n_face, 6) of the surface, reference areas (n_face, n_q) mm2, and the penalty eps [kPa/mm].

    rule: the quadrature points that the areas are of.
    """

    faces: np.ndarray
    areas: np.ndarray
    obstacle: Obstacle
    penalty: float
    rule: FaceRule = SIX_POINTS

    @property
    def connectivity(self) -> np.ndarray:
        """The faces."""
        return self.faces

    def moved_to(self, obstacle: Obstacle) -> Self:
        """The same contact with the obstacle elsewhere."""
        return replace(self, obstacle=obstacle)

    def at_points(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """y (n_face, n_q, 3) and d (n_face, n_q) of the quadrature points, mm."""
        y = positions(x, self.faces, self.rule.shapes)
        return y, self.obstacle.distance(y.reshape(-1, 3)).reshape(y.shape[:2])

    def energy(self, x: np.ndarray) -> float:
        """E = 1/2 eps integral of <-d>_+^2."""
        _, d = self.at_points(x)
        return self.penalty / 2 * float(np.sum(self.areas * np.minimum(d, 0.0) ** 2))

    def add_gradient(self, x: np.ndarray, g: np.ndarray) -> None:
        """g_a += - integral of eps <-d> n N_a."""
        y, d = self.at_points(x)
        t = np.zeros_like(y)
        t[d < 0] = self.penalty * (self.areas * d)[d < 0][:, None] * self.obstacle.normal(y[d < 0])
        add_to_nodes(self.faces, gathered_forces(t, self.rule.shapes), g)

    def add_tangent(self, x: np.ndarray, K: Tangent, *, projected: bool = False) -> None:
        """K_ab += integral of eps (n (x) n - <-d> H) N_a N_b, the last term not when projected."""
        y, d = self.at_points(x)
        inside = d < 0
        if not np.any(inside):
            return
        n = self.obstacle.normal(y[inside])
        M = np.zeros((*y.shape, 3))
        M[inside] = n[:, :, None] * n[:, None, :]
        if not projected:
            M[inside] += d[inside][:, None, None] * self.obstacle.hessian(y[inside])
        M *= self.penalty * self.areas[..., None, None]
        K.add(self.faces, gathered_stiffness(M, self.rule.shapes))

    def state(self, x: np.ndarray) -> ContactState:
        """Force, area, pressure and penetration in the loaded shape x (n_node, 3)."""
        y, d = self.at_points(x)
        n = self.obstacle.normal(y.reshape(-1, 3)).reshape(y.shape)
        deformed = self.rule.areas(x, self.faces)
        depth = np.maximum(-d, 0.0)
        load = self.penalty * depth * self.areas
        force = -np.einsum("eq,eqi->i", load, n)
        return ContactState(force, np.where(d < 0, deformed, 0.0), load / deformed, float(depth.max()))


@dataclass(frozen=True)
class CoulombFriction(WithoutVolume):
    """faces (n_face, 6) with the points of a rule, n_q each.

    load (n_face, n_q): mu lambda, mN; normals and places a (n_face, n_q, 3), mm; slip_mm: g.
    """

    faces: np.ndarray
    rule: FaceRule
    load: np.ndarray
    normals: np.ndarray
    places: np.ndarray
    slip_mm: float

    @property
    def connectivity(self) -> np.ndarray:
        """The faces."""
        return self.faces

    def slips(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """s (n_face, n_q, 3) and |s| (n_face, n_q), mm."""
        s = positions(x, self.faces, self.rule.shapes) - self.places
        s -= np.sum(s * self.normals, axis=-1, keepdims=True) * self.normals
        return s, np.linalg.norm(s, axis=-1)

    def energy(self, x: np.ndarray) -> float:
        """E = sum of mu lambda F."""
        _, s = self.slips(x)
        g = self.slip_mm
        v = np.minimum(s / g, 1.0)
        return float(np.sum(self.load * (g * v**2 * (1 - v / 3) + np.maximum(s - g, 0.0))))

    def _over(self, s: np.ndarray) -> np.ndarray:
        """F' / |s| (n_face, n_q)."""
        v = s / self.slip_mm
        return np.where(v < 1, 2 - v, 1 / np.maximum(v, 1.0)) / self.slip_mm

    def forces(self, x: np.ndarray) -> np.ndarray:
        """(n_face, n_q, 3) mN that the surface exerts on the obstacle: mu lambda F' s / |s|."""
        s, length = self.slips(x)
        t: np.ndarray = (self.load * self._over(length))[..., None] * s
        return t

    def add_gradient(self, x: np.ndarray, g: np.ndarray) -> None:
        """g_a += sum of mu lambda F' s / |s| N_a."""
        add_to_nodes(self.faces, gathered_forces(self.forces(x), self.rule.shapes), g)

    def add_tangent(self, x: np.ndarray, K: Tangent, *, projected: bool = False) -> None:
        """K_ab += sum of mu lambda (F'/|s| (T - e (x) e) + F'' e (x) e) N_a N_b, e = s / |s|."""
        s, length = self.slips(x)
        e = s / np.maximum(length, 1e-300)[..., None]
        over = self._over(length)
        second = np.maximum(2 / self.slip_mm * (1 - length / self.slip_mm), 0.0)
        T = np.eye(3) - self.normals[..., :, None] * self.normals[..., None, :]
        M = over[..., None, None] * T + (second - over)[..., None, None] * e[..., :, None] * e[..., None, :]
        K.add(self.faces, gathered_stiffness(self.load[..., None, None] * M, self.rule.shapes))
