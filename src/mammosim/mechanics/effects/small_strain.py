"""Bulk tissue at small strain: linear elasticity, what models in small increments solve in each of them.

e = sym grad u,  u = x - X,  W = mu e : e + lambda/2 (tr e)^2,  lambda = k - 2/3 mu
s = 2 mu e + lambda tr e 1;  g_a = integral of s dN_a
K_ab = integral of mu (dN_a . dN_b 1 + dN_b (x) dN_a) + lambda dN_a (x) dN_b
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import Tissues
from mammosim.mechanics.mixture import cell_tissues
from mammosim.mechanics.pattern import Tangent, add_to_nodes
from mammosim.mechanics.reference import CellQuadrature, cell_quadrature

_HALF = np.arange(10)[:, None] > np.arange(10)  # of the pairs of nodes, those that mirror others


@dataclass(frozen=True)
class SmallStrain:
    """The energy of all cells, quadratic in u.

    points: X (n_node, 3) mm; cells (n_cell, 10); mu, k (n_cell,) kPa.
    """

    points: np.ndarray
    cells: np.ndarray
    quadrature: CellQuadrature
    mu: np.ndarray
    k: np.ndarray

    @classmethod
    def of(cls, mesh: TetMesh, tissues: Tissues) -> "SmallStrain":
        """The cells of a mesh whose points are the reference. Raises MechanicsError for an unknown tissue."""
        each = cell_tissues(mesh, tissues)
        quadrature = cell_quadrature(mesh.points, mesh.cells)
        return cls(mesh.points, mesh.cells, quadrature, each.shear_modulus_kpa, each.bulk_modulus_kpa)

    @property
    def connectivity(self) -> np.ndarray:
        """The cells."""
        return self.cells

    @property
    def lame(self) -> np.ndarray:
        """lambda (n_cell,) kPa."""
        found: np.ndarray = self.k - 2 / 3 * self.mu
        return found

    def _slopes(self, x: np.ndarray) -> np.ndarray:
        """grad u (n_cell, 4, 3, 3) at the integration points."""
        u = (x - self.points)[self.cells]
        found: np.ndarray = np.einsum("eai,eqaj->eqij", u, self.quadrature.gradients)
        return found

    def energy(self, x: np.ndarray) -> float:
        """The integral of W."""
        H = self._slopes(x)
        e = (H + H.swapaxes(-1, -2)) / 2
        W = self.mu[:, None] * np.sum(e**2, axis=(2, 3)) + self.lame[:, None] / 2 * _trace(e) ** 2
        return float(np.sum(self.quadrature.volumes * W))

    def add_gradient(self, x: np.ndarray, g: np.ndarray) -> None:
        """g_a += integral of s dN_a/dX."""
        H = self._slopes(x)
        s = self.mu[:, None, None, None] * (H + H.swapaxes(-1, -2))
        s += (self.lame[:, None] * _trace(H))[..., None, None] * np.eye(3)
        s *= self.quadrature.volumes[..., None, None]
        add_to_nodes(self.cells, np.einsum("eqij,eqaj->eai", s, self.quadrature.gradients), g)

    def add_tangent(self, x: np.ndarray, K: Tangent, *, projected: bool = False) -> None:
        """K_ab: the same in every shape, and positive semidefinite."""
        K.add_in_batches(self.cells, self._element_tangents)

    def _element_tangents(self, batch: slice) -> np.ndarray:
        """Of a slice of the cells (n_in_batch, 10, 10, 3, 3) mN/mm, symmetric to the last bit."""
        dN, V = self.quadrature.gradients[batch], self.quadrature.volumes[batch]
        mu, lame = (c[batch][:, None, None, None, None] for c in (self.mu, self.lame))
        A = np.einsum("eqai,eqbj->eabij", dN * V[..., None, None], dN, optimize=True)
        Ke: np.ndarray = (
            mu * (np.einsum("eabkk->eab", A)[..., None, None] * np.eye(3) + A.swapaxes(-1, -2)) + lame * A
        )
        mirrored = Ke.transpose(0, 2, 1, 4, 3)
        Ke[:, _HALF] = mirrored[:, _HALF]
        diagonal = np.arange(10)
        own = Ke[:, diagonal, diagonal]
        Ke[:, diagonal, diagonal] = (own + own.swapaxes(-1, -2)) / 2
        return Ke

    def smallest_J(self, x: np.ndarray) -> float:
        """The smallest J of the integration points: the law has none, but cells must not turn inside out."""
        return float(np.linalg.det(self._slopes(x) + np.eye(3)).min())

    def predicted(self, x: np.ndarray, dx: np.ndarray) -> Self:
        """Itself."""
        return self


def _trace(H: np.ndarray) -> np.ndarray:
    found: np.ndarray = np.trace(H, axis1=-2, axis2=-1)
    return found
