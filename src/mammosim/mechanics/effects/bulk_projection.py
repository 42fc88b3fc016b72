"""The bulk law without its directions of negative curvature, in closed form; names as in bulk_kernels.

With F = U diag(sigma) V^T and dF' = U^T dF V, the second derivative of W couples only (Smith, de Goes & Kim
[@smith2019]; i, j, l all different, c_i = sigma_j sigma_l, m = mu J^(-2/3), s = p - m / (3 J) I1)

- the stretches dF'_ii, by S_ij = m 1_ij + h (sigma_i c_j + c_i sigma_j) + r c_i c_j (+ s sigma_l if i != j),
  h = -2/3 m / J, r = 5/9 m I1 / J^2 + k;
- dF'_ij and dF'_ji, by [[m, -s sigma_l], [-s sigma_l, m]] with the eigenvalues m -+ s sigma_l of (1, +-1).
"""

import numpy as np

from mammosim.io.compiled import njit, prange
from mammosim.mechanics.effects.bulk_kernels import _deformation
from mammosim.mechanics.effects.pointwise import mirror

SWEEPS = 30  # of Jacobi's rotations, which converge quadratically: 4 to 6 are usual


@njit(cache=True, inline="always")
def _eigen(A: np.ndarray, V: np.ndarray) -> None:
    """Jacobi's method: A (3, 3) symmetric becomes diag(lambda), V its eigenvectors in columns."""
    for i in range(3):
        for j in range(3):
            V[i, j] = 1.0 if i == j else 0.0
    for _ in range(SWEEPS):
        off = abs(A[0, 1]) + abs(A[0, 2]) + abs(A[1, 2])
        if off <= 1e-18 * (abs(A[0, 0]) + abs(A[1, 1]) + abs(A[2, 2])):
            break
        for i, j in ((0, 1), (0, 2), (1, 2)):
            if A[i, j] == 0.0:
                continue
            theta = (A[j, j] - A[i, i]) / (2 * A[i, j])
            t = 1.0 / (abs(theta) + np.sqrt(theta * theta + 1))
            t = t if theta >= 0 else -t
            cos = 1.0 / np.sqrt(t * t + 1)
            sin = t * cos
            l = 3 - i - j
            A[i, i], A[j, j] = A[i, i] - t * A[i, j], A[j, j] + t * A[i, j]
            A[i, j] = A[j, i] = 0.0
            li, lj = A[l, i], A[l, j]
            A[l, i] = A[i, l] = cos * li - sin * lj
            A[l, j] = A[j, l] = sin * li + cos * lj
            for n in range(3):
                vi, vj = V[n, i], V[n, j]
                V[n, i], V[n, j] = cos * vi - sin * vj, sin * vi + cos * vj


@njit(cache=True, inline="always")
def _frame(F: np.ndarray, U: np.ndarray, sigma: np.ndarray, V: np.ndarray, G: np.ndarray) -> None:
    """F = U diag(sigma) V^T with orthonormal U, V, for J > 0; G: room for a (3, 3)."""
    for i in range(3):
        for j in range(3):
            G[i, j] = F[0, i] * F[0, j] + F[1, i] * F[1, j] + F[2, i] * F[2, j]
    _eigen(G, V)
    # The columns of F V are orthogonal; the shortest is the least certain, and follows from the others.
    last = 0
    for c in range(1, 3):
        if G[c, c] < G[last, last]:
            last = c
    a, b = (last + 1) % 3, (last + 2) % 3
    for c in (a, b):
        norm = 0.0
        for i in range(3):
            U[i, c] = F[i, 0] * V[0, c] + F[i, 1] * V[1, c] + F[i, 2] * V[2, c]
            norm += U[i, c] * U[i, c]
        sigma[c] = np.sqrt(norm)
        for i in range(3):
            U[i, c] /= sigma[c]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        U[i, last] = U[j, a] * U[k, b] - U[k, a] * U[j, b]
    sigma[last] = 0.0
    for i in range(3):
        sigma[last] += U[i, last] * (F[i, 0] * V[0, last] + F[i, 1] * V[1, last] + F[i, 2] * V[2, last])
    if sigma[last] < 0:  # V is a reflection
        sigma[last] = -sigma[last]
        for i in range(3):
            U[i, last] = -U[i, last]


@njit(cache=True, inline="always")
def _stretches(sigma: np.ndarray, S: np.ndarray, mu: float, k: float, p: float) -> tuple[float, float]:
    """S (3, 3); returns m and s."""
    J = sigma[0] * sigma[1] * sigma[2]
    I1 = sigma[0] ** 2 + sigma[1] ** 2 + sigma[2] ** 2
    m = mu * J ** (-2 / 3)
    h, r = -2 / 3 * m / J, 5 / 9 * m / (J * J) * I1 + k
    s = p - m / (3 * J) * I1
    for i in range(3):
        ci = J / sigma[i]
        for j in range(3):
            cj = J / sigma[j]
            S[i, j] = h * (sigma[i] * cj + ci * sigma[j]) + r * ci * cj
            if i == j:
                S[i, j] += m
            else:
                S[i, j] += s * sigma[3 - i - j]
    return m, s


@njit(cache=True, inline="always")
def _is_positive(S: np.ndarray) -> bool:
    """Whether the pivots of S (3, 3) are positive."""
    if S[0, 0] <= 0:
        return False
    b = S[1, 1] - S[1, 0] * S[0, 1] / S[0, 0]
    if b <= 0:
        return False
    c = S[1, 2] - S[1, 0] * S[0, 2] / S[0, 0]
    return bool(S[2, 2] - S[2, 0] * S[0, 2] / S[0, 0] - c * c / b > 0)


@njit(cache=True, inline="always")
def _leave_out(Ke: np.ndarray, weight: float, v: np.ndarray, U: np.ndarray, u: np.ndarray) -> None:
    """K_ab -= weight (U v_a) (U v_b)^T of the upper half; u: room for U v (10, 3)."""
    for a in range(10):
        for i in range(3):
            u[a, i] = U[i, 0] * v[a, 0] + U[i, 1] * v[a, 1] + U[i, 2] * v[a, 2]
    for a in range(10):
        for b in range(a, 10):
            for i in range(3):
                for j in range(3):
                    Ke[a, b, i, j] -= weight * u[a, i] * u[b, j]


@njit(cache=True, parallel=True)
def project_tangents(
    Ke: np.ndarray,
    x: np.ndarray,
    cells: np.ndarray,
    dN: np.ndarray,
    dV: np.ndarray,
    mu: np.ndarray,
    k: np.ndarray,
    p: np.ndarray,
) -> None:
    """Leave out of tangents Ke (n_cell, 10, 10, 3, 3) the negative eigenvalues of d2W/dF2 at each point."""
    n_cell, n_q = dV.shape
    for e in prange(n_cell):
        F, U, V, G = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
        S, sigma = np.empty((3, 3)), np.empty(3)
        g, v, u = np.empty((10, 3)), np.zeros((10, 3)), np.empty((10, 3))
        changed = False
        for q in range(n_q):
            _deformation(x, cells[e], dN[e, q], F)
            _frame(F, U, sigma, V, G)
            m, s = _stretches(sigma, S, mu[e], k[e], p[e, q])
            stretched = not _is_positive(S)
            if not stretched and abs(s) * max(sigma[0], sigma[1], sigma[2]) <= m:
                continue
            changed = True
            for a in range(10):
                for i in range(3):
                    g[a, i] = dN[e, q, a, 0] * V[0, i] + dN[e, q, a, 1] * V[1, i] + dN[e, q, a, 2] * V[2, i]
            if stretched:
                _eigen(S, G)
                for n in range(3):
                    if S[n, n] < 0:
                        for a in range(10):
                            for i in range(3):
                                v[a, i] = G[i, n] * g[a, i]
                        _leave_out(Ke[e], dV[e, q] * S[n, n], v, U, u)
            for i in range(3):
                j, l = (i + 1) % 3, (i + 2) % 3
                for sign in (1.0, -1.0):
                    value = m - sign * s * sigma[l]
                    if value < 0:
                        for a in range(10):
                            v[a, i], v[a, j], v[a, l] = g[a, j], sign * g[a, i], 0.0
                        _leave_out(Ke[e], dV[e, q] * value / 2, v, U, u)
        if changed:
            mirror(Ke[e])
