"""Skin as a membrane on the surface: quadratic triangles that resist tension and wrinkle under compression.

    W_m = h mu/2 (tr C + 1/det C - 3) per reference area,  C = F^T F (2 x 2),  F = dx/ds (3 x 2)
    P = h mu (F - M / d^2),  M = F adj C,  d = det C

With the principal values c1 >= c2 of C, a strip pulled to c1 is free of stress at the width c2 = c1^(-1/2).
A narrower one wrinkles and costs no more (relaxed energy, Pipkin 1986):

    W_m = h mu/2 (c1 + 2 c1^(-1/2) - 3) where c2 < c1^(-1/2),  and 0 where c1 < 1
"""

# ASSUME: skin as a membrane wrinkles under compression without resistance, as it has no bending stiffness.
# ASSUME: skin as a membrane is incompressible (thickness follows from area) and has no weight of its own.

from dataclasses import dataclass
from typing import Any

import numpy as np

from mammosim.io.compiled import njit, prange
from mammosim.mechanics.effects.pointwise import mirror
from mammosim.mechanics.effects.protocol import WithoutVolume
from mammosim.mechanics.pattern import Tangent, add_to_nodes
from mammosim.mechanics.reference import FaceQuadrature


@dataclass(frozen=True)
class SkinMembrane(WithoutVolume):
    """faces (n_face, 6); stiffness h mu (n_face,) kPa mm."""

    faces: np.ndarray
    quadrature: FaceQuadrature
    stiffness: np.ndarray

    @property
    def connectivity(self) -> np.ndarray:
        """The faces."""
        return self.faces

    def energy(self, x: np.ndarray) -> float:
        """The integral of W_m; infinite where a face has no area."""
        q = self.quadrature
        return float(np.sum(_energies(x, self.faces, q.gradients, q.areas, self.stiffness)))

    def add_gradient(self, x: np.ndarray, g: np.ndarray) -> None:
        """g_a += integral of P dN_a/ds."""
        q = self.quadrature
        add_to_nodes(self.faces, _gradients(x, self.faces, q.gradients, q.areas, self.stiffness), g)

    def add_tangent(self, x: np.ndarray, K: Tangent, *, projected: bool = False) -> None:
        """K_ab += integral of dN_a/ds . d2W_m/dF2 . dN_b/ds, positive semidefinite as W_m is convex."""
        q = self.quadrature
        K.add(self.faces, _tangents(x, self.faces, q.gradients, q.areas, self.stiffness))


@njit(cache=True, inline="always")
def _deformation(
    x: np.ndarray, nodes: np.ndarray, dN: np.ndarray, F: np.ndarray, C: np.ndarray, M: np.ndarray
) -> Any:
    """F = sum_a x_a (x) dN_a/ds, C = F^T F, M = F adj C; returns det C."""
    for i in range(3):
        for j in range(2):
            s = 0.0
            for a in range(6):
                s += x[nodes[a], i] * dN[a, j]
            F[i, j] = s
    for i in range(2):
        for j in range(2):
            C[i, j] = F[0, i] * F[0, j] + F[1, i] * F[1, j] + F[2, i] * F[2, j]
    for i in range(3):
        M[i, 0] = F[i, 0] * C[1, 1] - F[i, 1] * C[0, 1]
        M[i, 1] = F[i, 1] * C[0, 0] - F[i, 0] * C[0, 1]
    return C[0, 0] * C[1, 1] - C[0, 1] * C[0, 1]


@njit(cache=True, inline="always")
def _principal(C: np.ndarray, n: np.ndarray) -> tuple[float, float]:
    """The principal values c1 >= c2 of C, and the direction n of c1."""
    mean, half = (C[0, 0] + C[1, 1]) / 2, (C[0, 0] - C[1, 1]) / 2
    r = np.hypot(half, C[0, 1])
    angle = np.arctan2(C[0, 1], half) / 2
    n[0], n[1] = np.cos(angle), np.sin(angle)
    return mean + r, mean - r


@njit(cache=True, parallel=True)
def _energies(
    x: np.ndarray, faces: np.ndarray, dN: np.ndarray, dA: np.ndarray, stiffness: np.ndarray
) -> np.ndarray:
    n_face, n_q = dA.shape
    energies = np.zeros(n_face)
    for e in prange(n_face):
        F, C, M, n = np.empty((3, 2)), np.empty((2, 2)), np.empty((3, 2)), np.empty(2)
        for q in range(n_q):
            d = _deformation(x, faces[e], dN[e, q], F, C, M)
            c1, c2 = _principal(C, n)
            w = dA[e, q] * stiffness[e] / 2
            if c2 * np.sqrt(c1) >= 1:
                energies[e] += w * (C[0, 0] + C[1, 1] + 1 / d - 3)
            elif c1 > 1:
                energies[e] += w * (c1 + 2 / np.sqrt(c1) - 3)
    return energies


@njit(cache=True, parallel=True)
def _gradients(
    x: np.ndarray, faces: np.ndarray, dN: np.ndarray, dA: np.ndarray, stiffness: np.ndarray
) -> np.ndarray:
    n_face, n_q = dA.shape
    ge = np.zeros((n_face, 6, 3))
    for e in prange(n_face):
        F, C, M, n = np.empty((3, 2)), np.empty((2, 2)), np.empty((3, 2)), np.empty(2)
        for q in range(n_q):
            d = _deformation(x, faces[e], dN[e, q], F, C, M)
            c1, c2 = _principal(C, n)
            w = dA[e, q] * stiffness[e]
            if c2 * np.sqrt(c1) < 1 and c1 <= 1:
                continue
            taut = c2 * np.sqrt(c1) >= 1
            for i in range(3):
                if taut:
                    P0, P1 = F[i, 0] - M[i, 0] / (d * d), F[i, 1] - M[i, 1] / (d * d)
                else:
                    s = (1 - c1**-1.5) * (F[i, 0] * n[0] + F[i, 1] * n[1])
                    P0, P1 = s * n[0], s * n[1]
                for a in range(6):
                    ge[e, a, i] += w * (P0 * dN[e, q, a, 0] + P1 * dN[e, q, a, 1])
    return ge


@njit(cache=True, inline="always")
def _taut(F: np.ndarray, C: np.ndarray, M: np.ndarray, d: float, A: np.ndarray) -> None:
    """A (6 x 6) = d2/dF2 of (tr C + 1/d) / 2, rows and columns 2 i + j of F_ij."""
    for i in range(3):
        for j in range(3):
            FF = F[i, 0] * F[j, 0] + F[i, 1] * F[j, 1]
            for s in range(2):
                for t in range(2):
                    adj_C = C[1 - s, 1 - t] if s == t else -C[s, t]
                    dM = 2 * F[i, s] * F[j, t] - F[i, t] * F[j, s] - (FF if s == t else 0.0)
                    if i == j:
                        dM += adj_C
                    A[2 * i + s, 2 * j + t] = 4 / d**3 * M[i, s] * M[j, t] - dM / d**2
                    if i == j and s == t:
                        A[2 * i + s, 2 * j + t] += 1.0


@njit(cache=True, inline="always")
def _wrinkled(F: np.ndarray, n: np.ndarray, c1: float, c2: float, A: np.ndarray) -> None:
    """A (6 x 6) = d2/dF2 of (c1 + 2 c1^(-1/2)) / 2.

    dc1 = a.dF with a = 2 Fn (x) n;  d2c1 = 2 |dF n|^2 + 2 (b.dF)^2 / (c1 - c2), b = Fn (x) m + Fm (x) n.
    """
    w1, w2 = (1 - c1**-1.5) / 2, 0.75 * c1**-2.5
    m = np.array([-n[1], n[0]])
    for i in range(3):
        Fn_i, Fm_i = F[i, 0] * n[0] + F[i, 1] * n[1], F[i, 0] * m[0] + F[i, 1] * m[1]
        for j in range(3):
            Fn_j, Fm_j = F[j, 0] * n[0] + F[j, 1] * n[1], F[j, 0] * m[0] + F[j, 1] * m[1]
            for s in range(2):
                for t in range(2):
                    bb = (Fn_i * m[s] + Fm_i * n[s]) * (Fn_j * m[t] + Fm_j * n[t])
                    entry = w2 * 4 * Fn_i * n[s] * Fn_j * n[t] + 2 * w1 * bb / (c1 - c2)
                    if i == j:
                        entry += 2 * w1 * n[s] * n[t]
                    A[2 * i + s, 2 * j + t] = entry


@njit(cache=True, parallel=True)
def _tangents(
    x: np.ndarray, faces: np.ndarray, dN: np.ndarray, dA: np.ndarray, stiffness: np.ndarray
) -> np.ndarray:
    n_face, n_q = dA.shape
    Ke = np.zeros((n_face, 6, 6, 3, 3))
    for e in prange(n_face):
        F, C, M, A = np.empty((3, 2)), np.empty((2, 2)), np.empty((3, 2)), np.empty((6, 6))
        n = np.empty(2)
        for q in range(n_q):
            d = _deformation(x, faces[e], dN[e, q], F, C, M)
            c1, c2 = _principal(C, n)
            if c2 * np.sqrt(c1) >= 1:
                _taut(F, C, M, d, A)
            elif c1 > 1:
                _wrinkled(F, n, c1, c2, A)
            else:
                continue
            _add_product(A, dN[e, q], dA[e, q] * stiffness[e], Ke[e])
        mirror(Ke[e])
    return Ke


@njit(cache=True, inline="always")
def _add_product(A: np.ndarray, dN: np.ndarray, w: float, K: np.ndarray) -> None:
    """K_ab += w dN_a . A . dN_b for b >= a."""
    for a in range(6):
        for b in range(a, 6):
            for i in range(3):
                for j in range(3):
                    s = 0.0
                    for t in range(2):
                        for u in range(2):
                            s += dN[a, t] * A[2 * i + t, 2 * j + u] * dN[b, u]
                    K[a, b, i, j] += w * s
