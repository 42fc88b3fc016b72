"""Cooper's ligaments as fibres spread through the tissue: a transversely isotropic term, in tension only.

    W = k1 / (2 k2) (exp(k2 e^2) - 1),  e = <I4 - 1>_+,  I4 = |f|^2,  f = F a
    P = 2 W' f (x) a,  dP = 2 W' (dF a) (x) a + 4 W'' (f . dF a) f (x) a
    W' = k1 e exp(k2 e^2),  W'' = k1 (1 + 2 k2 e^2) exp(k2 e^2)

a: direction of the fibres in the reference. After Holzapfel, Gasser & Ogden (2000); k2 = 0 is the limit
W = k1 e^2 / 2. W is convex in F.
"""

# ASSUME: fibres follow the stretch of the tissue and carry no compression.
# ASSUME: fibres see the whole stretch I4, not its isochoric part, so that swelling tissue stretches them too.

from dataclasses import dataclass
from typing import Any

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.io.compiled import njit, prange
from mammosim.mechanics.effects.pointwise import spread
from mammosim.mechanics.effects.protocol import WithoutVolume
from mammosim.mechanics.pattern import Tangent, add_to_nodes
from mammosim.mechanics.reference import cell_quadrature


@dataclass(frozen=True)
class Fibres(WithoutVolume):
    """cells (n_cell, 10) with fibres; slopes (n_cell, 4, 10): dN_a/dX . a [1/mm]; volumes (n_cell, 4) mm3.

    stiffness k1 kPa, exponent k2. Raises MechanicsError when one is negative.
    """

    cells: np.ndarray
    slopes: np.ndarray
    volumes: np.ndarray
    stiffness: float
    exponent: float = 0.0

    def __post_init__(self) -> None:
        if self.stiffness < 0 or self.exponent < 0:
            raise MechanicsError(
                f"fibres with k1 = {self.stiffness:g} kPa and k2 = {self.exponent:g}: both must be at least 0"
            )

    @classmethod
    def of(
        cls, mesh: TetMesh, directions: np.ndarray, *, stiffness_kpa: float, exponent: float = 0.0
    ) -> "Fibres":
        """Fibres of a mesh whose points are the reference, along a = directions (n_cell, 3).

        A cell without fibres has the direction zero. Raises MechanicsError for other lengths than 0 and 1.
        """
        lengths = np.linalg.norm(directions, axis=1)
        bad = np.flatnonzero((np.abs(lengths - 1) > 1e-6) & (lengths > 0) | ~np.isfinite(lengths))
        if len(lengths) != len(mesh.cells) or len(bad):
            raise MechanicsError(
                f"fibre directions {directions.shape}, {len(bad)} of length neither 0 nor 1, "
                f"must be unit vectors ({len(mesh.cells)}, 3), or zero in cells without fibres"
            )
        cells = np.ascontiguousarray(mesh.cells[lengths > 0])
        q = cell_quadrature(mesh.points, cells)
        slopes = np.einsum("eqai,ei->eqa", q.gradients, directions[lengths > 0])
        return cls(cells, slopes, q.volumes, stiffness_kpa, exponent)

    @property
    def connectivity(self) -> np.ndarray:
        """The cells with fibres."""
        return self.cells

    def energy(self, x: np.ndarray) -> float:
        """The integral of W."""
        k = (self.stiffness, self.exponent)
        return float(np.sum(_energies(x, self.cells, self.slopes, self.volumes, *k)))

    def add_gradient(self, x: np.ndarray, g: np.ndarray) -> None:
        """g_a += integral of 2 W' (dN_a/dX . a) f."""
        k = (self.stiffness, self.exponent)
        add_to_nodes(self.cells, _gradients(x, self.cells, self.slopes, self.volumes, *k), g)

    def add_tangent(self, x: np.ndarray, K: Tangent, *, projected: bool = False) -> None:
        """K_ab += integral of (dN_a . a) (dN_b . a) (2 W' 1 + 4 W'' f (x) f), positive semidefinite."""
        k = (self.stiffness, self.exponent)
        K.add(self.cells, _tangents(x, self.cells, self.slopes, self.volumes, *k))


@njit(cache=True, inline="always")
def _stretched(x: np.ndarray, nodes: np.ndarray, slopes: np.ndarray, f: np.ndarray) -> Any:
    """f = F a = sum_a x_a (dN_a/dX . a); returns e = <I4 - 1>_+."""
    for i in range(3):
        f[i] = 0.0
        for a in range(10):
            f[i] += x[nodes[a], i] * slopes[a]
    return max(f[0] * f[0] + f[1] * f[1] + f[2] * f[2] - 1.0, 0.0)


@njit(cache=True, parallel=True)
def _energies(
    x: np.ndarray, cells: np.ndarray, slopes: np.ndarray, dV: np.ndarray, k1: float, k2: float
) -> np.ndarray:
    n_cell, n_q = dV.shape
    energies = np.zeros(n_cell)
    for c in prange(n_cell):
        f = np.empty(3)
        for q in range(n_q):
            e = _stretched(x, cells[c], slopes[c, q], f)
            W = k1 / (2 * k2) * np.expm1(k2 * e * e) if k2 > 0 else k1 / 2 * e * e
            energies[c] += dV[c, q] * W
    return energies


@njit(cache=True, parallel=True)
def _gradients(
    x: np.ndarray, cells: np.ndarray, slopes: np.ndarray, dV: np.ndarray, k1: float, k2: float
) -> np.ndarray:
    n_cell, n_q = dV.shape
    ge = np.zeros((n_cell, 10, 3))
    for c in prange(n_cell):
        f = np.empty(3)
        for q in range(n_q):
            e = _stretched(x, cells[c], slopes[c, q], f)
            W1 = k1 * e * np.exp(k2 * e * e)
            for a in range(10):
                for i in range(3):
                    ge[c, a, i] += dV[c, q] * 2 * W1 * slopes[c, q, a] * f[i]
    return ge


@njit(cache=True, parallel=True)
def _tangents(
    x: np.ndarray, cells: np.ndarray, slopes: np.ndarray, dV: np.ndarray, k1: float, k2: float
) -> np.ndarray:
    n_cell, n_q = dV.shape
    Ke = np.empty((n_cell, 10, 10, 3, 3))
    for c in prange(n_cell):
        f, M = np.empty(3), np.zeros((n_q, 3, 3))
        for q in range(n_q):
            e = _stretched(x, cells[c], slopes[c, q], f)
            if e > 0:
                growth = np.exp(k2 * e * e)
                W1, W2 = k1 * e * growth, k1 * (1 + 2 * k2 * e * e) * growth
                for i in range(3):
                    for j in range(i, 3):
                        M[q, i, j] = dV[c, q] * 4 * W2 * f[i] * f[j]
                    M[q, i, i] += dV[c, q] * 2 * W1
        spread(slopes[c], M, Ke[c])
    return Ke
