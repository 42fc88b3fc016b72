"""Bulk tissue: compressible neo-Hookean solid elements.

W = mu/2 (I1bar - 3) + k/2 (J - 1)^2,  I1bar = J^(-2/3) I1,  I1 = tr(F^T F),  J = det F,  C = cof F = J F^-T
P = dW/dF = mu J^(-2/3) F + s C,  s = p - mu/3 J^(-5/3) I1,  p = k (J - 1)
dP = mu J^(-2/3) dF - 2/3 mu J^(-5/3) (F (C:dF) + C (F:dF)) + (5/9 mu J^(-8/3) I1 + k) C (C:dF) + s dC
"""

# ASSUME: the bulk law has the isochoric I1bar where the report prints I1, which would stress the rest state.

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numba
import numpy as np

from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import Tissue, tissue_of
from mammosim.mechanics.pattern import Tangent, add_to_nodes
from mammosim.mechanics.reference import CellQuadrature, cell_quadrature


@dataclass(frozen=True)
class NeoHookean:
    """The elastic energy of all cells.

    cells (n_cell, 10); mu, k (n_cell,) kPa; pressure (n_cell, 4) kPa: p of the tangent if predicted.
    """

    cells: np.ndarray
    quadrature: CellQuadrature
    mu: np.ndarray
    k: np.ndarray
    pressure: np.ndarray | None = None

    @classmethod
    def of(cls, mesh: TetMesh, tissues: Mapping[Label, Tissue]) -> "NeoHookean":
        """The cells of a mesh whose points are the reference. Raises MechanicsError for an unknown tissue."""
        labels, index = np.unique(mesh.tissue, return_inverse=True)
        mu = np.array([tissue_of(label, tissues).shear_modulus_kpa for label in labels])
        k = np.array([tissue_of(label, tissues).bulk_modulus_kpa for label in labels])
        return cls(mesh.cells, cell_quadrature(mesh.points, mesh.cells), mu[index], k[index])

    @property
    def connectivity(self) -> np.ndarray:
        """The cells."""
        return self.cells

    def energy(self, x: np.ndarray) -> float:
        """The integral of W; infinite where J <= 0 at an integration point."""
        q = self.quadrature
        return float(np.sum(_energies(x, self.cells, q.gradients, q.volumes, self.mu, self.k)))

    def add_gradient(self, x: np.ndarray, g: np.ndarray) -> None:
        """g_a += integral of P dN_a/dX."""
        self.add_gradient_under(x, self.k[:, None] * (self.volume_ratios(x) - 1), g)

    def add_tangent(self, x: np.ndarray, K: Tangent, *, projected: bool = False) -> None:
        """K_ab += integral of dN_a/dX . d2W/dF2 . dN_b/dX."""
        self.add_tangent_under(x, self.tangent_pressure(x), K, projected=projected)

    def add_gradient_under(self, x: np.ndarray, p: np.ndarray, g: np.ndarray) -> None:
        """As add_gradient, with given pressures p (n_cell, 4) kPa."""
        q = self.quadrature
        add_to_nodes(self.cells, _gradients(x, self.cells, q.gradients, q.volumes, self.mu, p), g)

    def add_tangent_under(self, x: np.ndarray, p: np.ndarray, K: Tangent, *, projected: bool) -> None:
        """As add_tangent, with given pressures p (n_cell, 4) kPa; dp = k dJ as ever."""
        q = self.quadrature
        kernel = _projected_tangents if projected else _tangents
        each = (self.cells, q.gradients, q.volumes, self.mu, self.k, p)
        K.add_in_batches(self.cells, lambda batch: kernel(x, *(values[batch] for values in each)))

    def tangent_pressure(self, x: np.ndarray) -> np.ndarray:
        """p (n_cell, 4) kPa of the tangent: predicted, or else k (J - 1)."""
        return self.k[:, None] * (self.volume_ratios(x) - 1) if self.pressure is None else self.pressure

    def volume_ratios(self, x: np.ndarray) -> np.ndarray:
        """J (n_cell, 4) at the integration points."""
        return _volume_ratios(x, self.cells, self.quadrature.gradients)

    def smallest_J(self, x: np.ndarray) -> float:
        """The smallest J of the integration points."""
        return float(self.volume_ratios(x).min())

    def softened(self, ratio: float) -> "NeoHookean":
        """The law with k' = min(k, ratio mu): the part of it that displacements alone can follow."""
        return replace(self, k=np.minimum(self.k, ratio * self.mu))

    def predicted(self, x: np.ndarray, dx: np.ndarray) -> "NeoHookean":
        """The law with the pressure that the step predicts, p = k (J - 1 + C : grad dx), in its tangent.

        Newton with mixed integration points (Magisano, Leonetti & Garcea 2017): near incompressibility the
        pressure of the displaced shape is wrong by k times the square of the step, the predicted one is not.
        """
        return replace(self, pressure=self.k[:, None] * self.predicted_changes(x, dx))

    def predicted_changes(self, x: np.ndarray, dx: np.ndarray) -> np.ndarray:
        """J - 1 + C : grad dx (n_cell, 4)."""
        return _predicted_changes(x, dx, self.cells, self.quadrature.gradients)


def volume_gradients(
    x: np.ndarray, cells: np.ndarray, dN: np.ndarray, dV: np.ndarray, N: np.ndarray
) -> np.ndarray:
    """B_va = integral of N_v C dN_a/dX, (n_cell, 4, 10, 3) mm2, N (4, 4) of the points and vertices."""
    return _volume_gradients(x, cells, dN, dV, N)


@numba.njit(cache=True, inline="always")
def _deformation(x, nodes, dN, F):  # type: ignore[no-untyped-def]
    """F = sum_a x_a (x) dN_a/dX."""
    for i in range(3):
        for j in range(3):
            s = 0.0
            for a in range(10):
                s += x[nodes[a], i] * dN[a, j]
            F[i, j] = s


@numba.njit(cache=True, inline="always")
def _cofactor(F, C):  # type: ignore[no-untyped-def]
    """C = cof F; returns J."""
    for i in range(3):
        m, n = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            k, l = (j + 1) % 3, (j + 2) % 3
            C[i, j] = F[m, k] * F[n, l] - F[m, l] * F[n, k]
    return F[0, 0] * C[0, 0] + F[0, 1] * C[0, 1] + F[0, 2] * C[0, 2]


@numba.njit(cache=True, parallel=True)
def _volume_ratios(x, cells, dN):  # type: ignore[no-untyped-def]
    n_cell, n_q = dN.shape[:2]
    J = np.empty((n_cell, n_q))
    for e in numba.prange(n_cell):
        F, C = np.empty((3, 3)), np.empty((3, 3))
        for q in range(n_q):
            _deformation(x, cells[e], dN[e, q], F)
            J[e, q] = _cofactor(F, C)
    return J


@numba.njit(cache=True, parallel=True)
def _volume_gradients(x, cells, dN, dV, N):  # type: ignore[no-untyped-def]
    n_cell, n_q = dV.shape
    Be = np.zeros((n_cell, N.shape[1], 10, 3))
    for e in numba.prange(n_cell):
        F, C = np.empty((3, 3)), np.empty((3, 3))
        for q in range(n_q):
            _deformation(x, cells[e], dN[e, q], F)
            _cofactor(F, C)
            for a in range(10):
                for i in range(3):
                    c = 0.0
                    for j in range(3):
                        c += C[i, j] * dN[e, q, a, j]
                    for v in range(N.shape[1]):
                        Be[e, v, a, i] += dV[e, q] * N[q, v] * c
    return Be


@numba.njit(cache=True, parallel=True)
def _predicted_changes(x, dx, cells, dN):  # type: ignore[no-untyped-def]
    n_cell, n_q = dN.shape[:2]
    change = np.empty((n_cell, n_q))
    for e in numba.prange(n_cell):
        F, C, dF = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
        for q in range(n_q):
            _deformation(x, cells[e], dN[e, q], F)
            _deformation(dx, cells[e], dN[e, q], dF)
            change[e, q] = _cofactor(F, C) - 1 + np.sum(C * dF)
    return change


@numba.njit(cache=True, parallel=True)
def _energies(x, cells, dN, dV, mu, k):  # type: ignore[no-untyped-def]
    n_cell, n_q = dV.shape
    energies = np.zeros(n_cell)
    for e in numba.prange(n_cell):
        F, C = np.empty((3, 3)), np.empty((3, 3))
        for q in range(n_q):
            _deformation(x, cells[e], dN[e, q], F)
            J = _cofactor(F, C)
            if J <= 0:
                energies[e] = np.inf
            else:
                I1bar = J ** (-2 / 3) * np.sum(F * F)
                W = mu[e] / 2 * (I1bar - 3) + k[e] / 2 * (J - 1) ** 2
                energies[e] += dV[e, q] * W
    return energies


@numba.njit(cache=True, parallel=True)
def _gradients(x, cells, dN, dV, mu, p):  # type: ignore[no-untyped-def]
    n_cell, n_q = dV.shape
    ge = np.zeros((n_cell, 10, 3))
    for e in numba.prange(n_cell):
        F, C = np.empty((3, 3)), np.empty((3, 3))
        for q in range(n_q):
            _deformation(x, cells[e], dN[e, q], F)
            J = _cofactor(F, C)
            m = mu[e] * J ** (-2 / 3)
            s = p[e, q] - m / (3 * J) * np.sum(F * F)
            for a in range(10):
                for i in range(3):
                    P_dN = 0.0
                    for j in range(3):
                        P_dN += (m * F[i, j] + s * C[i, j]) * dN[e, q, a, j]
                    ge[e, a, i] += dV[e, q] * P_dN
    return ge


@numba.njit(cache=True, parallel=True)
def _tangents(x, cells, dN, dV, mu, k, p):  # type: ignore[no-untyped-def]
    n_cell, n_q = dV.shape
    Ke = np.zeros((n_cell, 10, 10, 3, 3))
    for e in numba.prange(n_cell):
        F, C = np.empty((3, 3)), np.empty((3, 3))
        f, c = np.empty((10, 3)), np.empty((10, 3))
        for q in range(n_q):
            g, w = dN[e, q], dV[e, q]
            _deformation(x, cells[e], g, F)
            J = _cofactor(F, C)
            I1 = np.sum(F * F)
            m = w * mu[e] * J ** (-2 / 3)
            h = -2 / 3 * m / J
            r = 5 / 9 * m / (J * J) * I1 + w * k[e]
            s = w * p[e, q] - m / (3 * J) * I1
            for a in range(10):
                for i in range(3):
                    f[a, i] = F[i, 0] * g[a, 0] + F[i, 1] * g[a, 1] + F[i, 2] * g[a, 2]
                    c[a, i] = C[i, 0] * g[a, 0] + C[i, 1] * g[a, 1] + C[i, 2] * g[a, 2]
            for a in range(10):
                for b in range(a, 10):
                    gg = m * (g[a, 0] * g[b, 0] + g[a, 1] * g[b, 1] + g[a, 2] * g[b, 2])
                    # dC: its block is eps_ijk v_k with v = s F (dN_a x dN_b).
                    y0 = s * (g[a, 1] * g[b, 2] - g[a, 2] * g[b, 1])
                    y1 = s * (g[a, 2] * g[b, 0] - g[a, 0] * g[b, 2])
                    y2 = s * (g[a, 0] * g[b, 1] - g[a, 1] * g[b, 0])
                    v0 = F[0, 0] * y0 + F[0, 1] * y1 + F[0, 2] * y2
                    v1 = F[1, 0] * y0 + F[1, 1] * y1 + F[1, 2] * y2
                    v2 = F[2, 0] * y0 + F[2, 1] * y1 + F[2, 2] * y2
                    for i in range(3):
                        hc = h * c[a, i]
                        hf = h * f[a, i] + r * c[a, i]
                        for j in range(3):
                            Ke[e, a, b, i, j] += hf * c[b, j] + hc * f[b, j]
                        Ke[e, a, b, i, i] += gg
                    Ke[e, a, b, 0, 1] += v2
                    Ke[e, a, b, 1, 0] -= v2
                    Ke[e, a, b, 1, 2] += v0
                    Ke[e, a, b, 2, 1] -= v0
                    Ke[e, a, b, 2, 0] += v1
                    Ke[e, a, b, 0, 2] -= v1
        _mirror(Ke[e])
    return Ke


@numba.njit(cache=True, inline="always")
def _mirror(K):  # type: ignore[no-untyped-def]
    """Make element tangents symmetric to the last bit: only the upper half was summed."""
    for a in range(K.shape[0]):
        for i in range(3):
            for j in range(i):
                K[a, a, i, j] = K[a, a, j, i]
        for b in range(a):
            for i in range(3):
                for j in range(3):
                    K[a, b, i, j] = K[b, a, j, i]


@numba.njit(cache=True, parallel=True)
def _projected_tangents(x, cells, dN, dV, mu, k, p):  # type: ignore[no-untyped-def]
    """As _tangents, with the negative eigenvalues of d2W/dF2 (9 x 9) set to zero at each point."""
    n_cell, n_q = dV.shape
    Ke = np.zeros((n_cell, 10, 10, 3, 3))
    for e in numba.prange(n_cell):
        F, C, A = np.empty((3, 3)), np.empty((3, 3)), np.empty((9, 9))
        B = np.zeros((9, 30))
        for q in range(n_q):
            _deformation(x, cells[e], dN[e, q], F)
            J = _cofactor(F, C)
            I1 = np.sum(F * F)
            m = mu[e] * J ** (-2 / 3)
            _second_derivative(F, C, A, m, -2 / 3 * m / J, 5 / 9 * m / (J * J) * I1 + k[e])
            _add_cofactor_part(F, A, p[e, q] - m / (3 * J) * I1)
            values, vectors = np.linalg.eigh(A)
            for a in range(10):
                for i in range(3):
                    for j in range(3):
                        B[3 * i + j, 3 * a + i] = dN[e, q, a, j]
            root = np.sqrt(dV[e, q] * np.maximum(values, 0.0)).reshape(9, 1) * (vectors.T @ B)
            block = root.T @ root
            for a in range(10):
                for b in range(10):
                    for i in range(3):
                        for j in range(3):
                            Ke[e, a, b, i, j] += block[3 * a + i, 3 * b + j]
        _mirror(Ke[e])
    return Ke


@numba.njit(cache=True, inline="always")
def _second_derivative(F, C, A, m, h, r):  # type: ignore[no-untyped-def]
    """A = m 1 + h (F (x) C + C (x) F) + r C (x) C."""
    for i in range(9):
        Fi, Ci = F[i // 3, i % 3], C[i // 3, i % 3]
        for j in range(9):
            Fj, Cj = F[j // 3, j % 3], C[j // 3, j % 3]
            A[i, j] = h * (Fi * Cj + Ci * Fj) + r * Ci * Cj
        A[i, i] += m


@numba.njit(cache=True, inline="always")
def _add_cofactor_part(F, A, s):  # type: ignore[no-untyped-def]
    """A += s d2J/dF2, d2J/dF_iA dF_jB = eps_ijk eps_ABC F_kC."""
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        for c in range(3):
            a, b = (c + 1) % 3, (c + 2) % 3
            v = s * F[k, c]
            A[3 * i + a, 3 * j + b] += v
            A[3 * j + b, 3 * i + a] += v
            A[3 * i + b, 3 * j + a] -= v
            A[3 * j + a, 3 * i + b] -= v
