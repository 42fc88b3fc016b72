"""Forces and stiffnesses that depend on the position of integration points alone, gathered to nodes.

y_q = sum_a N_a(q) x_a;  g_a = sum_q N_a(q) t_q;  K_ab = sum_q N_a(q) N_b(q) M_q
"""

import numpy as np

from mammosim.io.compiled import njit, prange


def positions(x: np.ndarray, elements: np.ndarray, N: np.ndarray) -> np.ndarray:
    """y (n_element, n_q, 3) of elements (n_element, m) with shape functions N (n_q, m) in x (n_node, 3)."""
    return _positions(x, elements, N)


def gathered_forces(t: np.ndarray, N: np.ndarray) -> np.ndarray:
    """g (n_element, m, 3) of forces t (n_element, n_q, 3) at the points."""
    return _gathered_forces(t, N)


def gathered_stiffness(M: np.ndarray, N: np.ndarray) -> np.ndarray:
    """K (n_element, m, m, 3, 3) of symmetric stiffnesses M (n_element, n_q, 3, 3), symmetric to the last bit.

    Of M only the upper triangles are read.
    """
    return _gathered_stiffness(M, N)


@njit(cache=True, parallel=True)
def _positions(x: np.ndarray, elements: np.ndarray, N: np.ndarray) -> np.ndarray:
    n_element, n_q = len(elements), len(N)
    y = np.zeros((n_element, n_q, 3))
    for e in prange(n_element):
        for q in range(n_q):
            for a in range(elements.shape[1]):
                for i in range(3):
                    y[e, q, i] += N[q, a] * x[elements[e, a], i]
    return y


@njit(cache=True, parallel=True)
def _gathered_forces(t: np.ndarray, N: np.ndarray) -> np.ndarray:
    n_element, n_q = t.shape[:2]
    ge = np.zeros((n_element, N.shape[1], 3))
    for e in prange(n_element):
        for q in range(n_q):
            for a in range(N.shape[1]):
                for i in range(3):
                    ge[e, a, i] += N[q, a] * t[e, q, i]
    return ge


@njit(cache=True, inline="always")
def spread(w: np.ndarray, M: np.ndarray, K: np.ndarray) -> None:
    """K_ab = sum_q w_qa w_qb M_q with symmetric M_q (3 x 3): each block is symmetric, and K_ba = K_ab."""
    n_q, m = w.shape
    for a in range(m):
        for b in range(a, m):
            k00, k01, k02, k11, k12, k22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for q in range(n_q):
                ww = w[q, a] * w[q, b]
                k00 += ww * M[q, 0, 0]
                k01 += ww * M[q, 0, 1]
                k02 += ww * M[q, 0, 2]
                k11 += ww * M[q, 1, 1]
                k12 += ww * M[q, 1, 2]
                k22 += ww * M[q, 2, 2]
            for c, d in ((a, b), (b, a)):
                K[c, d, 0, 0] = k00
                K[c, d, 1, 1] = k11
                K[c, d, 2, 2] = k22
                K[c, d, 0, 1] = K[c, d, 1, 0] = k01
                K[c, d, 0, 2] = K[c, d, 2, 0] = k02
                K[c, d, 1, 2] = K[c, d, 2, 1] = k12


@njit(cache=True, parallel=True)
def _gathered_stiffness(M: np.ndarray, N: np.ndarray) -> np.ndarray:
    n_element, m = len(M), N.shape[1]
    Ke = np.empty((n_element, m, m, 3, 3))
    for e in prange(n_element):
        if np.any(M[e]):
            spread(N, M[e], Ke[e])
        else:
            Ke[e] = 0.0
    return Ke


@njit(cache=True, inline="always")
def mirror(K: np.ndarray) -> None:
    """Make element tangents symmetric to the last bit: only the upper half was summed."""
    for a in range(K.shape[0]):
        for i in range(3):
            for j in range(i):
                K[a, a, i, j] = K[a, a, j, i]
        for b in range(a):
            for i in range(3):
                for j in range(3):
                    K[a, b, i, j] = K[b, a, j, i]
