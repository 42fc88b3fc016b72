"""A symmetric V-cycle of two levels, quadratic and linear elements of the same tetrahedra.

The nodes of a mid-edge mean its two vertices: x = P y. The coarse matrix is the Galerkin product P^T K P,
factorised exactly; before and after it a Chebyshev polynomial in D^-1 K smooths, D the 3x3 blocks of the
diagonal (Adams, Brezina, Hu & Tuminaro 2003). Degrees of freedom that are held stay zero. Every sum is taken
row by row in the order of the columns, so that results do not depend on the number of threads.
"""

from dataclasses import dataclass

import numba
import numpy as np
from scipy import sparse

from mammosim.core.mesh import EDGES
from mammosim.core.rng import generator
from mammosim.mechanics.linear import SymmetricSolver
from mammosim.mechanics.pattern import Pattern, Tangent, UpperRows, upper_rows

# The smoother acts on eigenvalues of D^-1 K from top / SPAN to top; top is above the largest one by MARGIN.
SPAN, MARGIN, DEGREE = 12.0, 1.15, 3
FIRST_POWER_STEPS, POWER_STEPS = 15, 5


class IndefiniteTangent(Exception):
    """The tangent was found not to be positive definite; internal to the package, caught by Newton."""

    def __init__(self, negative: int) -> None:
        super().__init__(f"{negative} negative eigenvalues or more")
        self.negative = negative


@dataclass(frozen=True)
class LinearLevel:
    """The vertices of quadratic tetrahedra as a coarse level.

    parents (n_node, 2): the coarse numbers of a node's two vertices, twice the same for a vertex;
    child_start, children: fine nodes of each coarse node; held (n_coarse, 3) bool; pattern of P^T K P.
    """

    parents: np.ndarray
    child_start: np.ndarray
    children: np.ndarray
    held: np.ndarray
    pattern: Pattern
    rows: UpperRows

    @classmethod
    def of(cls, pattern: Pattern, cells: np.ndarray, held: np.ndarray) -> "LinearLevel":
        """The level below quadratic tetrahedra cells (n_cell, 10), held (n_node, 3) bool."""
        vertices = np.unique(cells[:, :4])
        number = np.full(pattern.n_node, -1, dtype=np.int32)
        number[vertices] = np.arange(len(vertices))
        parents = np.repeat(number[:, None], 2, axis=1)
        parents[cells[:, 4:]] = number[cells[:, list(EDGES)]]
        P = sparse.csr_matrix(
            (np.full(parents.size, 0.5), parents.ravel(), np.arange(0, parents.size + 1, 2)),
            shape=(pattern.n_node, len(vertices)),
        )
        A = sparse.csr_matrix(
            (np.ones(len(pattern.columns), dtype=np.float32), pattern.columns, pattern.row_start)
        )
        children = P.T.tocsr()
        coarse = (children @ A @ P).tocsr()
        coarse.sort_indices()
        coarse_pattern = Pattern(coarse.indptr.astype(np.int32), coarse.indices.astype(np.int32))
        children.sum_duplicates()
        coarse_held = held[vertices]
        return cls(
            parents,
            children.indptr.astype(np.int32),
            children.indices.astype(np.int32),
            coarse_held,
            coarse_pattern,
            upper_rows(coarse_pattern, coarse_held),
        )

    def restricted(self, K: Tangent, free: np.ndarray) -> np.ndarray:
        """The values of the upper rows of P^T K P."""
        coarse = Tangent.zero(self.pattern)
        _galerkin(
            (K.pattern.row_start, K.pattern.columns, K.blocks, free),
            self.parents,
            self.child_start,
            self.children,
            self.pattern.row_start,
            self.pattern.columns,
            coarse.blocks,
        )
        return self.rows.values(coarse)


class VCycle:
    """z = M^-1 r, symmetric and positive definite when K is. Vectors (n_node, 3) are zero where held."""

    def __init__(self, pattern: Pattern, cells: np.ndarray, held: np.ndarray) -> None:
        self.level = LinearLevel.of(pattern, cells, held)
        self.coarse = SymmetricSolver(self.level.rows.row_start, self.level.rows.columns)
        self._free = (~held).astype(np.float64)
        self._direction = generator("largest eigenvalue").standard_normal(held.shape) * self._free
        self._power_steps = FIRST_POWER_STEPS

    def prepare(self, K: Tangent, *, semidefinite: bool = False) -> None:
        """Take the matrix. Raises IndefiniteTangent when a block of D or P^T K P is not positive definite.

        semidefinite: the matrix is known to have no negative eigenvalue but by rounding.
        """
        self._K = (K.pattern.row_start, K.pattern.columns, K.blocks, self._free)
        self._inverse = np.zeros((K.pattern.n_node, 3, 3))
        bad = _inverse_diagonal(*self._K, self._inverse)
        if bad and not semidefinite:
            raise IndefiniteTangent(1)
        definite = self.coarse.factorise(self.level.restricted(K, self._free))
        if not definite and not semidefinite:
            raise IndefiniteTangent(self.coarse.negative_pivots)
        self._top = MARGIN * self._largest_eigenvalue()

    def times(self, x: np.ndarray) -> np.ndarray:
        """K x."""
        return _times(*self._K, x)

    def __call__(self, r: np.ndarray) -> np.ndarray:
        """One V-cycle from zero: smooth, correct on the linear elements, smooth."""
        z = np.zeros_like(r)
        r = r.copy()
        self._smooth(z, r, leave_residual=True)
        coarse_r = _restrict(self.level.child_start, self.level.children, self.level.parents, r)
        free = self.level.rows.free
        y = np.zeros_like(coarse_r)
        y.reshape(-1)[free] = self.coarse.solve(coarse_r.reshape(-1)[free])
        dz = _prolong(self.level.parents, y, self._free)
        z += dz
        r -= self.times(dz)
        self._smooth(z, r, leave_residual=False)
        return z

    def _smooth(self, z: np.ndarray, r: np.ndarray, *, leave_residual: bool) -> None:
        """z += q(D^-1 K) D^-1 r, q of Chebyshev; r becomes the residual of the new z if asked."""
        top, low = self._top, self._top / SPAN
        middle, half = (top + low) / 2, (top - low) / 2
        sigma = middle / half
        rho = 1 / sigma
        p = np.zeros_like(r)
        _scaled(self._inverse, r, 1 / middle, p)
        for _ in range(DEGREE - 1):
            following = 1 / (2 * sigma - rho)
            p = _chebyshev(*self._K, self._inverse, p, r, z, following * rho, 2 * following / half)
            rho = following
        z += p
        if leave_residual:
            r -= self.times(p)

    def _largest_eigenvalue(self) -> float:
        """Of D^-1 K, by power steps from the last tangent's eigenvector."""
        v, value = self._direction, 1.0
        for _ in range(self._power_steps):
            w = np.empty_like(v)
            _scaled(self._inverse, self.times(v / np.sqrt(dot(v, v))), 1.0, w)
            v, value = w, np.sqrt(dot(w, w))
        self._direction, self._power_steps = v, POWER_STEPS
        return float(value)


def dot(a: np.ndarray, b: np.ndarray) -> float:
    """a . b of (n, 3), the same to the last bit for any number of threads."""
    return float(np.sum(_row_products(a, b)))


@numba.njit(cache=True, parallel=True)
def _row_products(a, b):  # type: ignore[no-untyped-def]
    s = np.empty(a.shape[0])
    for i in numba.prange(a.shape[0]):
        s[i] = a[i, 0] * b[i, 0] + a[i, 1] * b[i, 1] + a[i, 2] * b[i, 2]
    return s


@numba.njit(cache=True, inline="always")
def _row(i, row_start, columns, blocks, x):  # type: ignore[no-untyped-def]
    """Row i of K x."""
    s0, s1, s2 = 0.0, 0.0, 0.0
    for p in range(row_start[i], row_start[i + 1]):
        j = columns[p]
        x0, x1, x2 = x[j, 0], x[j, 1], x[j, 2]
        s0 += blocks[p, 0, 0] * x0 + blocks[p, 0, 1] * x1 + blocks[p, 0, 2] * x2
        s1 += blocks[p, 1, 0] * x0 + blocks[p, 1, 1] * x1 + blocks[p, 1, 2] * x2
        s2 += blocks[p, 2, 0] * x0 + blocks[p, 2, 1] * x1 + blocks[p, 2, 2] * x2
    return s0, s1, s2


@numba.njit(cache=True, parallel=True)
def _times(row_start, columns, blocks, free, x):  # type: ignore[no-untyped-def]
    y = np.empty_like(x)
    for i in numba.prange(x.shape[0]):
        s0, s1, s2 = _row(i, row_start, columns, blocks, x)
        y[i, 0] = s0 * free[i, 0]
        y[i, 1] = s1 * free[i, 1]
        y[i, 2] = s2 * free[i, 2]
    return y


@numba.njit(cache=True, parallel=True)
def _scaled(inverse, r, factor, p):  # type: ignore[no-untyped-def]
    """p = factor D^-1 r."""
    for i in numba.prange(r.shape[0]):
        for c in range(3):
            D_r = inverse[i, c, 0] * r[i, 0] + inverse[i, c, 1] * r[i, 1] + inverse[i, c, 2] * r[i, 2]
            p[i, c] = factor * D_r


@numba.njit(cache=True, parallel=True)
def _chebyshev(row_start, columns, blocks, free, inverse, p, r, z, a, b):  # type: ignore[no-untyped-def]
    """z += p, r -= K p; returns a p + b D^-1 r."""
    following = np.empty_like(p)
    for i in numba.prange(p.shape[0]):
        s0, s1, s2 = _row(i, row_start, columns, blocks, p)
        r[i, 0] -= s0 * free[i, 0]
        r[i, 1] -= s1 * free[i, 1]
        r[i, 2] -= s2 * free[i, 2]
        for c in range(3):
            z[i, c] += p[i, c]
            D_r = inverse[i, c, 0] * r[i, 0] + inverse[i, c, 1] * r[i, 1] + inverse[i, c, 2] * r[i, 2]
            following[i, c] = a * p[i, c] + b * D_r
    return following


@numba.njit(cache=True)
def _inverse_diagonal(row_start, columns, blocks, free, inverse):  # type: ignore[no-untyped-def]
    """Inverse blocks of D, zero where held; returns how many are not positive definite."""
    bad = 0
    for i in range(free.shape[0]):
        p = row_start[i] + np.searchsorted(columns[row_start[i] : row_start[i + 1]], i)
        D = np.eye(3)
        for c in range(3):
            for d in range(3):
                if free[i, c] * free[i, d] > 0:
                    D[c, d] = blocks[p, c, d]
        two = D[0, 0] * D[1, 1] - D[0, 1] * D[1, 0]
        three = np.linalg.det(D)
        if not (D[0, 0] > 0 and two > 0 and three > 0):
            bad += 1
        else:
            D_inverse = np.linalg.inv(D)
            for c in range(3):
                for d in range(3):
                    both = free[i, c] * free[i, d]
                    inverse[i, c, d] = both * 0.5 * (D_inverse[c, d] + D_inverse[d, c])
    return bad


@numba.njit(cache=True, parallel=True)
def _galerkin(K, parents, child_start, children, row_start_c, columns_c, coarse):  # type: ignore[no-untyped-def]
    """coarse = P^T K P, the blocks (a, b) with b >= a; P is 1 at a vertex and 1/2 at its mid-edges."""
    row_start, columns, blocks, free = K
    for a in numba.prange(len(row_start_c) - 1):
        row = columns_c[row_start_c[a] : row_start_c[a + 1]]
        for t in range(child_start[a], child_start[a + 1]):
            i = children[t]
            w_i = 1.0 if parents[i, 0] == parents[i, 1] else 0.5
            for p in range(row_start[i], row_start[i + 1]):
                j = columns[p]
                w = 0.5 * w_i
                for side in range(2):
                    b = parents[j, side]
                    if b >= a:
                        q = row_start_c[a] + np.searchsorted(row, b)
                        for c in range(3):
                            for d in range(3):
                                coarse[q, c, d] += w * free[i, c] * free[j, d] * blocks[p, c, d]


@numba.njit(cache=True, parallel=True)
def _restrict(child_start, children, parents, r):  # type: ignore[no-untyped-def]
    """P^T r."""
    y = np.zeros((len(child_start) - 1, 3))
    for a in numba.prange(y.shape[0]):
        for t in range(child_start[a], child_start[a + 1]):
            i = children[t]
            w = 1.0 if parents[i, 0] == parents[i, 1] else 0.5
            for c in range(3):
                y[a, c] += w * r[i, c]
    return y


@numba.njit(cache=True, parallel=True)
def _prolong(parents, y, free):  # type: ignore[no-untyped-def]
    """P y, zero where held."""
    x = np.empty((parents.shape[0], 3))
    for i in numba.prange(x.shape[0]):
        for c in range(3):
            x[i, c] = 0.5 * (y[parents[i, 0], c] + y[parents[i, 1], c]) * free[i, c]
    return x
