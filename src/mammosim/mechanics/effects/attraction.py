"""Attraction of points on a boundary to given places: what drives a morph.

y = sum_a N_a x_a,  E = sum s/2 [ (n . (y - z))^2 + t |y - z|^2 ]
force s M (y - z);  stiffness s M,  M = n (x) n + t 1
"""

from dataclasses import dataclass

import numpy as np

from mammosim.mechanics.effects.protocol import WithoutVolume
from mammosim.mechanics.pattern import Tangent, add_to_nodes


@dataclass(frozen=True)
class Attraction(WithoutVolume):
    """Points y of faces (n_face, 6) are drawn to places z, along the normal n more than across it.

    face (n_point,): the number of each point's face, N (n_point, 6) its shape functions there; places z
    (n_point, 3) mm; normals n (n_point, 3), of unit length; stiffness s (n_point,) mN/mm; across: t.
    """

    faces: np.ndarray
    face: np.ndarray
    N: np.ndarray
    places: np.ndarray
    normals: np.ndarray
    stiffness: np.ndarray
    across: float

    @property
    def connectivity(self) -> np.ndarray:
        """All faces, whether a point lies on them or not: the same for other points of the same faces."""
        return self.faces

    @property
    def nodes(self) -> np.ndarray:
        """(n_point, 6) of each point's face."""
        nodes: np.ndarray = self.faces[self.face]
        return nodes

    def offsets(self, x: np.ndarray) -> np.ndarray:
        """y - z (n_point, 3) mm."""
        offsets: np.ndarray = np.einsum("pa,pai->pi", self.N, x[self.nodes]) - self.places
        return offsets

    def energy(self, x: np.ndarray) -> float:
        """E."""
        d = self.offsets(x)
        along = np.sum(self.normals * d, axis=1)
        return float(np.sum(self.stiffness / 2 * (along**2 + self.across * np.sum(d * d, axis=1))))

    def add_gradient(self, x: np.ndarray, g: np.ndarray) -> None:
        """N_a s M (y - z) at the nodes."""
        force = np.einsum("pij,pj->pi", self._stiffness(), self.offsets(x))
        add_to_nodes(self.nodes, self.N[:, :, None] * force[:, None, :], g)

    def add_tangent(self, x: np.ndarray, K: Tangent, *, projected: bool = False) -> None:
        """N_a N_b s M, positive semidefinite."""
        NN = self.N[:, :, None] * self.N[:, None, :]
        Ke = np.zeros((len(self.faces), 6, 6, 3, 3))
        np.add.at(Ke, self.face, NN[..., None, None] * self._stiffness()[:, None, None])
        K.add(self.faces, Ke)

    def _stiffness(self) -> np.ndarray:
        """s M (n_point, 3, 3)."""
        M = self.normals[:, :, None] * self.normals[:, None, :] + self.across * np.eye(3)
        sM: np.ndarray = self.stiffness[:, None, None] * M
        return sM
