"""Coulomb friction of a surface on an obstacle, as a potential for one step of the way.

E = mu sum of lambda F(|s|),  s = T (y - a),  T = 1 - n (x) n
F'(s) = 2 s/g - (s/g)^2 for s < g, 1 above: sticking up to the slip g, then mu lambda against the slip

lambda is the normal force of each point and n the normal there, both known from before (lagged; Li et al.
2020), a the place on the obstacle where the point sticks. So E is convex in y, and its tangent symmetric.
"""

from dataclasses import dataclass

import numpy as np

from mammosim.mechanics.effects.face_rule import FaceRule
from mammosim.mechanics.effects.pointwise import gathered_forces, gathered_stiffness, positions
from mammosim.mechanics.effects.protocol import WithoutVolume
from mammosim.mechanics.pattern import Tangent, add_to_nodes


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
