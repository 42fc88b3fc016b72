"""The bulk law at the integration points of quadratic tetrahedra, compiled; formulas in effects.bulk.

x (n_node, 3); cells (n_cell, 10); dN (n_cell, n_q, 10, 3) 1/mm; dV (n_cell, n_q) mm3; mu, k (n_cell,) kPa;
p (n_cell, n_q) kPa. Parallel over the cells, each of which is summed by one thread.
"""

from typing import Any

import numpy as np

from mammosim.io.compiled import njit, prange
from mammosim.mechanics.effects.pointwise import mirror


@njit(cache=True, inline="always")
def _deformation(x: np.ndarray, nodes: np.ndarray, dN: np.ndarray, F: np.ndarray) -> None:
    """F = sum_a x_a (x) dN_a/dX."""
    for i in range(3):
        for j in range(3):
            s = 0.0
            for a in range(10):
                s += x[nodes[a], i] * dN[a, j]
            F[i, j] = s


@njit(cache=True, inline="always")
def _cofactor(F: np.ndarray, C: np.ndarray) -> Any:
    """C = cof F; returns J."""
    for i in range(3):
        m, n = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            k, l = (j + 1) % 3, (j + 2) % 3
            C[i, j] = F[m, k] * F[n, l] - F[m, l] * F[n, k]
    return F[0, 0] * C[0, 0] + F[0, 1] * C[0, 1] + F[0, 2] * C[0, 2]


@njit(cache=True, parallel=True)
def volume_ratios(x: np.ndarray, cells: np.ndarray, dN: np.ndarray) -> np.ndarray:
    """J (n_cell, n_q)."""
    n_cell, n_q = dN.shape[:2]
    J = np.empty((n_cell, n_q))
    for e in prange(n_cell):
        F, C = np.empty((3, 3)), np.empty((3, 3))
        for q in range(n_q):
            _deformation(x, cells[e], dN[e, q], F)
            J[e, q] = _cofactor(F, C)
    return J


@njit(cache=True, parallel=True)
def volume_gradients(
    x: np.ndarray, cells: np.ndarray, dN: np.ndarray, dV: np.ndarray, N: np.ndarray
) -> np.ndarray:
    """B_va = integral of N_v C dN_a/dX (n_cell, 4, 10, 3) mm2, N (n_q, 4) at the points."""
    n_cell, n_q = dV.shape
    Be = np.zeros((n_cell, N.shape[1], 10, 3))
    for e in prange(n_cell):
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


@njit(cache=True, parallel=True)
def predicted_changes(x: np.ndarray, dx: np.ndarray, cells: np.ndarray, dN: np.ndarray) -> np.ndarray:
    """J - 1 + C : grad dx (n_cell, n_q)."""
    n_cell, n_q = dN.shape[:2]
    change = np.empty((n_cell, n_q))
    for e in prange(n_cell):
        F, C, dF = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
        for q in range(n_q):
            _deformation(x, cells[e], dN[e, q], F)
            _deformation(dx, cells[e], dN[e, q], dF)
            change[e, q] = _cofactor(F, C) - 1 + np.sum(C * dF)
    return change


@njit(cache=True, parallel=True)
def energies(
    x: np.ndarray, cells: np.ndarray, dN: np.ndarray, dV: np.ndarray, mu: np.ndarray, k: np.ndarray
) -> np.ndarray:
    """The integral of W (n_cell,) uJ, infinite where J <= 0 at a point."""
    n_cell, n_q = dV.shape
    E = np.zeros(n_cell)
    for e in prange(n_cell):
        F, C = np.empty((3, 3)), np.empty((3, 3))
        for q in range(n_q):
            _deformation(x, cells[e], dN[e, q], F)
            J = _cofactor(F, C)
            if J <= 0:
                E[e] = np.inf
            else:
                I1bar = J ** (-2 / 3) * np.sum(F * F)
                W = mu[e] / 2 * (I1bar - 3) + k[e] / 2 * (J - 1) ** 2
                E[e] += dV[e, q] * W
    return E


@njit(cache=True, parallel=True)
def gradients(
    x: np.ndarray, cells: np.ndarray, dN: np.ndarray, dV: np.ndarray, mu: np.ndarray, p: np.ndarray
) -> np.ndarray:
    """The integral of P dN_a/dX (n_cell, 10, 3) mN under the pressures p (n_cell, n_q) kPa."""
    n_cell, n_q = dV.shape
    ge = np.zeros((n_cell, 10, 3))
    for e in prange(n_cell):
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


@njit(cache=True, parallel=True)
def tangents(
    x: np.ndarray,
    cells: np.ndarray,
    dN: np.ndarray,
    dV: np.ndarray,
    mu: np.ndarray,
    k: np.ndarray,
    p: np.ndarray,
) -> np.ndarray:
    """The integral of dN_a/dX . d2W/dF2 . dN_b/dX (n_cell, 10, 10, 3, 3) mN/mm, dp = k dJ."""
    n_cell, n_q = dV.shape
    Ke = np.zeros((n_cell, 10, 10, 3, 3))
    for e in prange(n_cell):
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
        mirror(Ke[e])
    return Ke
