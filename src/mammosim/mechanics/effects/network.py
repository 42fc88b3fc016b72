"""Bulk tissue as a network of springs along the edges of its cells: what mass-spring models compute.

E = sum k/2 (l - L)^2,  l = |x_1 - x_0|,  n = (x_1 - x_0) / l,  k = sum of E_t V_t of its cells t / L^2
force k (l - L) n;  tangent k (n (x) n + (1 - L/l) (1 - n (x) n))

The stiffness is that of Van Gelder (1998), in space. Where edges run equally in all directions,
W = 3 E <(n . e n)^2> = E/5 ((tr e)^2 + 2 e : e), which is linear elasticity with lambda = mu = 2/5 E: the
modulus is E, and nu = 1/4, whatever the tissue's: springs that pull along their length alone have no other.
"""

from dataclasses import dataclass

import numpy as np

from mammosim.core.mesh import SUBTETRAHEDRA, TetMesh
from mammosim.core.tissues import Tissues
from mammosim.mechanics.effects.protocol import WithoutVolume
from mammosim.mechanics.mixture import cell_tissues
from mammosim.mechanics.pattern import Tangent, add_to_nodes

# ASSUME: the springs of a network join the nodes of the quadratic cells along the edges of their eight parts.
# ASSUME: they push as they pull, in proportion to their change of length.
SHEAR_PER_MODULUS = 0.4  # mu / E of a network whose edges run equally in all directions
_EDGES = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
_SIGNS = np.array([-1.0, 1.0])


@dataclass(frozen=True)
class SpringNetwork(WithoutVolume):
    """pairs (n_spring, 2) of nodes; rest lengths L (n_spring,) mm; stiffness k (n_spring,) mN/mm.

    mu (n_cell,) kPa: the shear modulus of each cell's part of the network.
    """

    pairs: np.ndarray
    rest_lengths: np.ndarray
    stiffness: np.ndarray
    mu: np.ndarray

    @classmethod
    def of(cls, mesh: TetMesh, tissues: Tissues) -> "SpringNetwork":
        """The edges of a mesh whose points are the reference. Raises MechanicsError for an unknown tissue."""
        parts = mesh.cells[:, SUBTETRAHEDRA].reshape(-1, 4)
        modulus = cell_tissues(mesh, tissues).youngs_modulus_kpa
        E = np.repeat(modulus, len(SUBTETRAHEDRA))
        corners = mesh.points[parts]
        V = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
        ends = np.sort(parts[:, _EDGES].reshape(-1, 2), axis=1)
        pairs, number = np.unique(ends, axis=0, return_inverse=True)
        EV = np.bincount(number.ravel(), weights=np.repeat(E * V, len(_EDGES)))
        L = np.linalg.norm(mesh.points[pairs[:, 1]] - mesh.points[pairs[:, 0]], axis=1)
        mu = SHEAR_PER_MODULUS * modulus
        return cls(np.ascontiguousarray(pairs, dtype=np.int64), L, EV / L**2, mu)

    @property
    def connectivity(self) -> np.ndarray:
        """The pairs."""
        return self.pairs

    def _stretched(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """l (n_spring,) and n (n_spring, 3)."""
        between = x[self.pairs[:, 1]] - x[self.pairs[:, 0]]
        lengths = np.maximum(np.linalg.norm(between, axis=1), np.finfo(float).tiny)
        return lengths, between / lengths[:, None]

    def energy(self, x: np.ndarray) -> float:
        """E = sum k/2 (l - L)^2."""
        return float(np.sum(self.stiffness / 2 * (self._stretched(x)[0] - self.rest_lengths) ** 2))

    def add_gradient(self, x: np.ndarray, g: np.ndarray) -> None:
        """Minus and plus k (l - L) n at the two nodes."""
        l, n = self._stretched(x)
        force = (self.stiffness * (l - self.rest_lengths))[:, None] * n
        add_to_nodes(self.pairs, _SIGNS[:, None] * force[:, None, :], g)

    def add_tangent(self, x: np.ndarray, K: Tangent, *, projected: bool = False) -> None:
        """k (n (x) n + (1 - L/l) (1 - n (x) n)); projected, without what is pressed across its length."""
        l, n = self._stretched(x)
        across = 1 - self.rest_lengths / l
        if projected:
            across = np.maximum(across, 0.0)
        nn = n[:, :, None] * n[:, None, :]
        M = self.stiffness[:, None, None] * (nn + across[:, None, None] * (np.eye(3) - nn))
        K.add(self.pairs, np.outer(_SIGNS, _SIGNS)[:, :, None, None] * M[:, None, None])
