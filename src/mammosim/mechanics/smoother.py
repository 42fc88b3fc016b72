"""The smoother of the quadratic level: a Chebyshev polynomial in the scaled tangent, in single precision.

D = L L^T are the 3x3 blocks of the diagonal of K. The smoother works on A = L^-1 K L^-T, whose diagonal is 1,
with residuals L^-1 r and corrections L^T z, which is the polynomial in D^-1 K of Adams, Brezina, Hu &
Tuminaro (2003). Rows and columns that are held are zero. Every row is summed in the order of its columns.
"""

from dataclasses import dataclass

import numpy as np

from mammosim.io.compiled import njit, prange
from mammosim.mechanics.pattern import Pattern, Tangent

# The polynomial acts on eigenvalues of A from top / SPAN to top; top is above the largest one by MARGIN.
SPAN, MARGIN, DEGREE = 30.0, 1.15, 4


@dataclass(frozen=True)
class Scaling:
    """L (n_node, 3, 3) with D = L L^T, and its inverse; both zero in the rows and columns that are held."""

    L: np.ndarray
    inverse: np.ndarray

    @classmethod
    def of(cls, K: Tangent, free: np.ndarray) -> tuple["Scaling", int]:
        """The scaling of a tangent, free (n_node, 3) bool, and how many blocks are not positive definite.

        Those blocks are taken as 1.
        """
        L = np.zeros((K.pattern.n_node, 3, 3))
        inverse = np.zeros_like(L)
        bad = _cholesky(K.pattern.row_start, K.pattern.columns, K.blocks, free, L, inverse)
        return cls(L, inverse), int(bad.sum())


class Smoother:
    """z = q(A) r, q of Chebyshev; all vectors (n_node, 3) float32 and scaled."""

    def __init__(self, pattern: Pattern) -> None:
        self._row_start, self._columns = pattern.row_start, pattern.columns
        self._blocks = np.zeros((len(pattern.columns), 3, 3), dtype=np.float32)
        self._top = 1.0

    def prepare(self, K: Tangent, scaling: Scaling) -> None:
        """Take A of a tangent."""
        _scale(self._row_start, self._columns, K.blocks, scaling.inverse, self._blocks)

    def bound(self, direction: np.ndarray, steps: int) -> np.ndarray:
        """Bound the largest eigenvalue of A by power steps from a direction, which it returns improved."""
        v, value = direction, 1.0
        for _ in range(steps):
            w = np.zeros_like(v)
            _subtract_times(self._row_start, self._columns, self._blocks, v, w)
            value = np.sqrt(dot(w, w))
            v = w / np.float32(value)
        self._top = MARGIN * value
        return v

    @property
    def least(self) -> float:
        """Below all eigenvalues of q(A) (2 - A q(A)), the smoother applied twice, were A positive or not.

        1 - s q(s) is at most 1 / T(sigma) from low to top, T the Chebyshev polynomial of DEGREE, and below
        low the smoother only grows.
        """
        sigma = (SPAN + 1) / (SPAN - 1)
        remains = 1 / np.cosh(DEGREE * np.arccosh(sigma))
        return float((1 - remains**2) / self._top)

    def smooth(self, z: np.ndarray, r: np.ndarray, *, leave_residual: bool) -> None:
        """z += q(A) r; r becomes the residual of the new z if asked."""
        top, low = self._top, self._top / SPAN
        middle, half = (top + low) / 2, (top - low) / 2
        sigma = middle / half
        rho = 1 / sigma
        p = r * np.float32(1 / middle)
        for _ in range(DEGREE - 1):
            following = 1 / (2 * sigma - rho)
            a, b = np.float32(following * rho), np.float32(2 * following / half)
            p = _chebyshev(self._row_start, self._columns, self._blocks, p, r, z, a, b)
            rho = following
        z += p
        if leave_residual:
            self.subtract_times(p, r)

    def subtract_times(self, x: np.ndarray, r: np.ndarray) -> None:
        """r -= A x."""
        _subtract_times(self._row_start, self._columns, self._blocks, x, r)


def dot(a: np.ndarray, b: np.ndarray) -> float:
    """a . b of (n, 3), the same to the last bit for any number of threads."""
    return float(np.sum(_row_products(a, b)))


@njit(cache=True, parallel=True)
def _row_products(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    s = np.empty(a.shape[0])
    for i in prange(a.shape[0]):
        s[i] = np.float64(a[i, 0]) * b[i, 0] + np.float64(a[i, 1]) * b[i, 1] + np.float64(a[i, 2]) * b[i, 2]
    return s


@njit(cache=True, inline="always")
def row_times(
    i: int, row_start: np.ndarray, columns: np.ndarray, blocks: np.ndarray, x: np.ndarray
) -> tuple[float, float, float]:
    """Row i of the matrix times x, in the precision of both."""
    s0 = s1 = s2 = x.dtype.type(0)
    for p in range(np.uint64(row_start[i]), np.uint64(row_start[i + 1])):
        j = np.uint64(columns[p])
        x0, x1, x2 = x[j, 0], x[j, 1], x[j, 2]
        s0 += blocks[p, 0, 0] * x0 + blocks[p, 0, 1] * x1 + blocks[p, 0, 2] * x2
        s1 += blocks[p, 1, 0] * x0 + blocks[p, 1, 1] * x1 + blocks[p, 1, 2] * x2
        s2 += blocks[p, 2, 0] * x0 + blocks[p, 2, 1] * x1 + blocks[p, 2, 2] * x2
    return s0, s1, s2


@njit(cache=True, parallel=True)
def _subtract_times(
    row_start: np.ndarray, columns: np.ndarray, blocks: np.ndarray, x: np.ndarray, r: np.ndarray
) -> None:
    """r -= A x."""
    for i in prange(x.shape[0]):
        s0, s1, s2 = row_times(i, row_start, columns, blocks, x)
        r[i, 0] -= s0
        r[i, 1] -= s1
        r[i, 2] -= s2


@njit(cache=True, parallel=True)
def _chebyshev(
    row_start: np.ndarray,
    columns: np.ndarray,
    blocks: np.ndarray,
    p: np.ndarray,
    r: np.ndarray,
    z: np.ndarray,
    a: np.float32,
    b: np.float32,
) -> np.ndarray:
    """z += p, r -= A p; returns a p + b r."""
    following = np.empty_like(p)
    for i in prange(p.shape[0]):
        s0, s1, s2 = row_times(i, row_start, columns, blocks, p)
        r[i, 0] -= s0
        r[i, 1] -= s1
        r[i, 2] -= s2
        for c in range(3):
            z[i, c] += p[i, c]
            following[i, c] = a * p[i, c] + b * r[i, c]
    return following


@njit(cache=True, parallel=True)
def _cholesky(
    row_start: np.ndarray,
    columns: np.ndarray,
    blocks: np.ndarray,
    free: np.ndarray,
    L: np.ndarray,
    inverse: np.ndarray,
) -> np.ndarray:
    """L and L^-1 of the diagonal blocks, zero where held; returns (n_node,) which are not definite."""
    bad = np.zeros(free.shape[0], dtype=np.bool_)
    for i in prange(free.shape[0]):
        p = row_start[i] + np.searchsorted(columns[row_start[i] : row_start[i + 1]], i)
        D = np.eye(3)
        for c in range(3):
            for d in range(3):
                if free[i, c] and free[i, d]:
                    D[c, d] = blocks[p, c, d]
        two = D[0, 0] * D[1, 1] - D[1, 0] * D[1, 0]
        three = np.linalg.det(D)
        if not (D[0, 0] > 0 and two > 0 and three > 0):
            bad[i] = True
            D = np.eye(3)
            two = three = 1.0
        l00 = np.sqrt(D[0, 0])
        l10, l20 = D[1, 0] / l00, D[2, 0] / l00
        l11 = np.sqrt(two / D[0, 0])
        l21 = (D[2, 1] - l20 * l10) / l11
        l22 = np.sqrt(three / two)
        L[i, 0, 0], L[i, 1, 0], L[i, 1, 1] = l00, l10, l11
        L[i, 2, 0], L[i, 2, 1], L[i, 2, 2] = l20, l21, l22
        inverse[i, 0, 0], inverse[i, 1, 1], inverse[i, 2, 2] = 1 / l00, 1 / l11, 1 / l22
        inverse[i, 1, 0] = -l10 / (l00 * l11)
        inverse[i, 2, 1] = -l21 / (l11 * l22)
        inverse[i, 2, 0] = (l10 * l21 - l11 * l20) / (l00 * l11 * l22)
        for c in range(3):
            if not free[i, c]:
                L[i, c, c] = inverse[i, c, c] = 0.0
    return bad


@njit(cache=True, parallel=True)
def _scale(
    row_start: np.ndarray, columns: np.ndarray, blocks: np.ndarray, inverse: np.ndarray, scaled: np.ndarray
) -> None:
    """scaled_ij = L_i^-1 K_ij L_j^-T."""
    for i in prange(len(row_start) - 1):
        half = np.empty((3, 3))
        for p in range(row_start[i], row_start[i + 1]):
            j = columns[p]
            for c in range(3):
                for d in range(3):
                    s = 0.0
                    for k in range(c + 1):
                        s += inverse[i, c, k] * blocks[p, k, d]
                    half[c, d] = s
            for c in range(3):
                for d in range(3):
                    s = 0.0
                    for k in range(d + 1):
                        s += half[c, k] * inverse[j, d, k]
                    scaled[p, c, d] = s


@njit(cache=True, parallel=True)
def scaled_residual(inverse: np.ndarray, r: np.ndarray) -> np.ndarray:
    """L^-1 r, float32."""
    s = np.empty(r.shape, dtype=np.float32)
    for i in prange(r.shape[0]):
        for c in range(3):
            s[i, c] = inverse[i, c, 0] * r[i, 0] + inverse[i, c, 1] * r[i, 1] + inverse[i, c, 2] * r[i, 2]
    return s


@njit(cache=True, parallel=True)
def unscaled_correction(inverse: np.ndarray, z: np.ndarray) -> np.ndarray:
    """L^-T z, float64."""
    s = np.empty(z.shape)
    for i in prange(z.shape[0]):
        for c in range(3):
            s[i, c] = inverse[i, 0, c] * z[i, 0] + inverse[i, 1, c] * z[i, 1] + inverse[i, 2, c] * z[i, 2]
    return s
