"""Forces and stiffnesses that depend on the position of integration points alone, gathered to nodes.

y_q = sum_a N_a(q) x_a;  g_a = sum_q N_a(q) t_q;  K_ab = sum_q N_a(q) N_b(q) M_q
"""

import numba
import numpy as np


def positions(x: np.ndarray, elements: np.ndarray, N: np.ndarray) -> np.ndarray:
    """y (n_element, n_q, 3) of elements (n_element, m) with shape functions N (n_q, m) in x (n_node, 3)."""
    return _positions(x, elements, N)


def gathered_forces(t: np.ndarray, N: np.ndarray) -> np.ndarray:
    """g (n_element, m, 3) of forces t (n_element, n_q, 3) at the points."""
    return _gathered_forces(t, N)


def gathered_stiffness(M: np.ndarray, N: np.ndarray) -> np.ndarray:
    """K (n_element, m, m, 3, 3) of stiffnesses M (n_element, n_q, 3, 3); symmetric to the last bit."""
    return _gathered_stiffness(M + np.swapaxes(M, 2, 3), N)


@numba.njit(cache=True, parallel=True)
def _positions(x, elements, N):  # type: ignore[no-untyped-def]
    n_element, n_q = len(elements), len(N)
    y = np.zeros((n_element, n_q, 3))
    for e in numba.prange(n_element):
        for q in range(n_q):
            for a in range(elements.shape[1]):
                for i in range(3):
                    y[e, q, i] += N[q, a] * x[elements[e, a], i]
    return y


@numba.njit(cache=True, parallel=True)
def _gathered_forces(t, N):  # type: ignore[no-untyped-def]
    n_element, n_q = t.shape[:2]
    ge = np.zeros((n_element, N.shape[1], 3))
    for e in numba.prange(n_element):
        for q in range(n_q):
            for a in range(N.shape[1]):
                for i in range(3):
                    ge[e, a, i] += N[q, a] * t[e, q, i]
    return ge


@numba.njit(cache=True, parallel=True)
def _gathered_stiffness(twice_M, N):  # type: ignore[no-untyped-def]
    n_element, n_q = twice_M.shape[:2]
    m = N.shape[1]
    Ke = np.zeros((n_element, m, m, 3, 3))
    for e in numba.prange(n_element):
        for q in range(n_q):
            M = twice_M[e, q] / 2
            if np.any(M):
                for a in range(m):
                    for b in range(m):
                        NN = N[q, a] * N[q, b]
                        for i in range(3):
                            for j in range(3):
                                Ke[e, a, b, i, j] += NN * M[i, j]
    return Ke
