"""Frictionless contact of a surface with a rigid obstacle, by a penalty on the signed distance d.

E = 1/2 eps integral of <-d(x)>_+^2 over the reference area,  n = grad d,  H = d2d/dx2
"""

from dataclasses import dataclass, replace
from typing import Protocol, Self

import numpy as np

from mammosim.mechanics.effects.face_rule import SIX_POINTS, FaceRule
from mammosim.mechanics.effects.pointwise import gathered_forces, gathered_stiffness, positions
from mammosim.mechanics.effects.protocol import WithoutVolume
from mammosim.mechanics.pattern import Tangent, add_to_nodes


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
