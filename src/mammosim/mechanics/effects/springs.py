"""Cooper's ligaments as a network of springs between nodes, in tension only.

E = sum k/2 <l - L>_+^2,  l = |x_1 - x_0|,  n = (x_1 - x_0) / l,  k = E A / L
force k <l - L> n;  tangent k (n (x) n + (1 - L/l) (1 - n (x) n)) where l > L

Attraction of points on a boundary to given places: what drives a morph.

y = sum_a N_a x_a,  E = sum s/2 [ (n . (y - z))^2 + t |y - z|^2 ]
force s M (y - z);  stiffness s M,  M = n (x) n + t 1
"""

from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.mechanics.effects.protocol import WithoutVolume
from mammosim.mechanics.pattern import Tangent, add_to_nodes

# ASSUME: the ligaments of a spring network are straight, join nodes of the mesh, and carry no compression.


_SIGNS = np.array([-1.0, 1.0])


@dataclass(frozen=True)
class Springs(WithoutVolume):
    """pairs (n_spring, 2) of nodes; rest lengths L (n_spring,) mm; stiffness k (n_spring,) mN/mm.

    Raises MechanicsError for a length that is not positive or a negative stiffness.
    """

    pairs: np.ndarray
    rest_lengths: np.ndarray
    stiffness: np.ndarray

    def __post_init__(self) -> None:
        bad = np.flatnonzero(~((self.rest_lengths > 0) & (self.stiffness >= 0)))
        if len(bad):
            raise MechanicsError(
                f"{len(bad)} springs, the first {bad[0]}, have a rest length that is not above 0 mm or a "
                "stiffness below 0 mN/mm: join two different nodes"
            )

    @classmethod
    def between(
        cls,
        points: np.ndarray,
        pairs: np.ndarray,
        *,
        youngs_modulus_kpa: float,
        section_mm2: float,
        slack: float = 1.0,
    ) -> "Springs":
        """Ligaments of section A between nodes of the reference points (n_node, 3), k = E A / L.

        slack: L over the distance of the nodes; above 1 for ligaments that hang loose at first.
        Raises MechanicsError as the class does.
        """
        pairs = np.ascontiguousarray(pairs, dtype=np.int64)
        L = slack * np.linalg.norm(points[pairs[:, 1]] - points[pairs[:, 0]], axis=1)
        with np.errstate(divide="ignore"):
            k = youngs_modulus_kpa * section_mm2 / L
        return cls(pairs, L, k)

    @property
    def connectivity(self) -> np.ndarray:
        """The pairs."""
        return self.pairs

    def _stretched(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """l (n_spring,) and n (n_spring, 3)."""
        between = x[self.pairs[:, 1]] - x[self.pairs[:, 0]]
        lengths = np.linalg.norm(between, axis=1)
        return lengths, between / np.maximum(lengths, np.finfo(float).tiny)[:, None]

    def tensions(self, x: np.ndarray) -> np.ndarray:
        """k <l - L>_+ (n_spring,) mN."""
        tensions: np.ndarray = self.stiffness * np.maximum(self._stretched(x)[0] - self.rest_lengths, 0.0)
        return tensions

    def energy(self, x: np.ndarray) -> float:
        """E = sum k/2 <l - L>_+^2."""
        stretch = np.maximum(self._stretched(x)[0] - self.rest_lengths, 0.0)
        return float(np.sum(self.stiffness / 2 * stretch**2))

    def add_gradient(self, x: np.ndarray, g: np.ndarray) -> None:
        """Minus and plus k <l - L>_+ n at the two nodes."""
        force = self.tensions(x)[:, None] * self._stretched(x)[1]
        add_to_nodes(self.pairs, _SIGNS[:, None] * force[:, None, :], g)

    def add_tangent(self, x: np.ndarray, K: Tangent, *, projected: bool = False) -> None:
        """k (n (x) n + (1 - L/l) (1 - n (x) n)) where l > L, positive semidefinite."""
        l, n = self._stretched(x)
        taut = l > self.rest_lengths
        across = 1 - self.rest_lengths / np.where(taut, l, self.rest_lengths)
        nn = n[:, :, None] * n[:, None, :]
        M = nn + across[:, None, None] * (np.eye(3) - nn)
        M *= (self.stiffness * taut)[:, None, None]
        K.add(self.pairs, np.outer(_SIGNS, _SIGNS)[:, :, None, None] * M[:, None, None])


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
