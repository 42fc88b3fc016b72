"""A symmetric V-cycle of two levels, quadratic and linear elements of the same tetrahedra.

The nodes of a mid-edge mean its two vertices: x = P y. The coarse matrix is the Galerkin product P^T K P,
factorised; before and after it a Chebyshev polynomial smooths (mechanics.smoother). Degrees of freedom that
are held stay zero. Every sum is taken row by row in the order of the columns, so that results do not depend
on the number of threads.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from mammosim.core.mesh import EDGES
from mammosim.core.rng import generator
from mammosim.io.compiled import njit, prange
from mammosim.mechanics.linear import SymmetricSolver
from mammosim.mechanics.pattern import Pattern, Tangent, UpperRows, upper_rows
from mammosim.mechanics.smoother import Scaling, Smoother, row_times, scaled_residual, unscaled_correction

FIRST_POWER_STEPS, POWER_STEPS = 15, 5


class IndefiniteTangent(Exception):
    """The tangent was found not to be positive definite; internal to the package, caught by Newton."""

    def __init__(self, negative: int) -> None:
        super().__init__(f"{negative} negative eigenvalues or more")
        self.negative = negative


@dataclass(frozen=True)
class LinearLevel:
    """The vertices of quadratic tetrahedra as a coarse level; fine nodes are numbered by the rows of K.

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
        """The level below quadratic tetrahedra cells (n_cell, 10), held (n_node, 3) bool, in rows of K."""
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
        same = np.arange(len(vertices), dtype=np.int32)
        coarse_pattern = Pattern(
            coarse.indptr.astype(np.int32), coarse.indices.astype(np.int32), order=same, number=same
        )
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
    """z = M^-1 r, symmetric and positive definite when K is.

    Vectors (n_node, 3) are in the order of the rows of K, and zero where held. The cycle computes in single
    precision, which rounds M^-1, not the solution; times is K in double.
    """

    def __init__(self, pattern: Pattern, cells: np.ndarray, held: np.ndarray) -> None:
        held = held[pattern.order]
        self.level = LinearLevel.of(pattern, pattern.number[cells], held)
        rows = self.level.rows
        self._single = SymmetricSolver(rows.row_start, rows.columns, single=True)
        self._double = SymmetricSolver(rows.row_start, rows.columns)
        self._coarse = self._single
        self._free = ~held
        self._smoother = Smoother(pattern)
        self._direction = generator("largest eigenvalue").standard_normal(held.shape, dtype=np.float32)
        self._power_steps = FIRST_POWER_STEPS

    def prepare(self, K: Tangent, *, semidefinite: bool = False) -> None:
        """Take the matrix. Raises IndefiniteTangent when a block of D or P^T K P is not positive definite.

        semidefinite: the matrix is known to have no negative eigenvalue but by rounding.
        """
        self._K = K
        self._scaling, bad = Scaling.of(K, self._free)
        if bad and not semidefinite:
            raise IndefiniteTangent(1)
        self._coarse, values = self._single, self.level.restricted(K, self._free)
        if not self._single.factorise(values) and not semidefinite:
            self._coarse = self._double  # rounding, or the truth
            if not self._double.factorise(values):
                raise IndefiniteTangent(self._double.negative_pivots)
        self._smoother.prepare(K, self._scaling)
        self._direction = self._smoother.bound(self._direction, self._power_steps)
        self._power_steps = POWER_STEPS

    @property
    def factorisations(self) -> int:
        """Of the coarse matrix."""
        return self._single.factorisations + self._double.factorisations

    @property
    def memory_mb(self) -> float:
        """Of the factors of the coarse matrix."""
        return max(self._single.memory_mb, self._double.memory_mb)

    def release(self) -> None:
        """Give back what memory is not Python's."""
        self._single.release()
        self._double.release()

    def times(self, x: np.ndarray) -> np.ndarray:
        """K x."""
        pattern = self._K.pattern
        return _times(pattern.row_start, pattern.columns, self._K.blocks, self._free, x)

    @property
    def least(self) -> float:
        """Below all eigenvalues of M^-1 D: smoothing alone is Smoother.least, correction only adds to it."""
        return self._smoother.least

    def noise(self, stream: np.random.Generator) -> np.ndarray:
        """Random forces D^1/2 g (n_node, 3), g standard normal."""
        g = stream.standard_normal(self._free.shape)
        return np.ascontiguousarray(np.einsum("icd,id->ic", self._scaling.L, g))

    def __call__(self, r: np.ndarray) -> np.ndarray:
        """One V-cycle from zero: smooth, correct on the linear elements, smooth."""
        L, level = self._scaling.L, self.level
        r = scaled_residual(self._scaling.inverse, r)
        z = np.zeros_like(r)
        self._smoother.smooth(z, r, leave_residual=True)
        coarse_r = _restrict(level.child_start, level.children, level.parents, L, r)
        y = np.zeros_like(coarse_r)
        y.reshape(-1)[level.rows.free] = self._coarse.solve(coarse_r.reshape(-1)[level.rows.free])
        dz = _prolong(level.parents, L, y)
        z += dz
        self._smoother.subtract_times(dz, r)
        self._smoother.smooth(z, r, leave_residual=False)
        return unscaled_correction(self._scaling.inverse, z)


@njit(cache=True, parallel=True)
def _times(
    row_start: np.ndarray, columns: np.ndarray, blocks: np.ndarray, free: np.ndarray, x: np.ndarray
) -> np.ndarray:
    y = np.empty_like(x)
    for i in prange(x.shape[0]):
        s0, s1, s2 = row_times(i, row_start, columns, blocks, x)
        y[i, 0] = s0 * free[i, 0]
        y[i, 1] = s1 * free[i, 1]
        y[i, 2] = s2 * free[i, 2]
    return y


@njit(cache=True, parallel=True)
def _galerkin(
    K: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray],
    parents: np.ndarray,
    child_start: np.ndarray,
    children: np.ndarray,
    row_start_c: np.ndarray,
    columns_c: np.ndarray,
    coarse: np.ndarray,
) -> None:
    """coarse = P^T K P, the blocks (a, b) with b >= a; P is 1 at a vertex and 1/2 at its mid-edges."""
    row_start, columns, blocks, free = K
    for a in prange(len(row_start_c) - 1):
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


@njit(cache=True, parallel=True)
def _restrict(
    child_start: np.ndarray, children: np.ndarray, parents: np.ndarray, L: np.ndarray, r: np.ndarray
) -> np.ndarray:
    """P^T L r."""
    y = np.zeros((len(child_start) - 1, 3), dtype=np.float32)
    for a in prange(y.shape[0]):
        for t in range(child_start[a], child_start[a + 1]):
            i = children[t]
            w = 1.0 if parents[i, 0] == parents[i, 1] else 0.5
            for c in range(3):
                y[a, c] += w * (L[i, c, 0] * r[i, 0] + L[i, c, 1] * r[i, 1] + L[i, c, 2] * r[i, 2])
    return y


@njit(cache=True, parallel=True)
def _prolong(parents: np.ndarray, L: np.ndarray, y: np.ndarray) -> np.ndarray:
    """L^T P y."""
    x = np.empty((parents.shape[0], 3), dtype=np.float32)
    for i in prange(x.shape[0]):
        u0 = 0.5 * (y[parents[i, 0], 0] + y[parents[i, 1], 0])
        u1 = 0.5 * (y[parents[i, 0], 1] + y[parents[i, 1], 1])
        u2 = 0.5 * (y[parents[i, 0], 2] + y[parents[i, 1], 2])
        for c in range(3):
            x[i, c] = L[i, 0, c] * u0 + L[i, 1, c] * u1 + L[i, 2, c] * u2
    return x
