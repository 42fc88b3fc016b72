"""The sparsity pattern that all effects of a mesh share, and the tangent matrix stored in it.

K is kept as 3x3 blocks in compressed rows over the nodes, both triangles. Element tangents are computed into
arrays of their own and then gathered block by block, always in the order of the elements: the sum is the same
for any number of threads.
"""

from dataclasses import dataclass, field

import numba
import numpy as np
from scipy import sparse
from scipy.sparse.linalg import SuperLU


@dataclass(frozen=True)
class Scatter:
    """Block p sums the entries order[start[p]:start[p + 1]] of element tangents (n_element * m * m, 3, 3)."""

    order: np.ndarray
    start: np.ndarray


@dataclass(frozen=True)
class Pattern:
    """Blocks of the rows of all nodes: columns[row_start[i]:row_start[i + 1]], ascending."""

    row_start: np.ndarray
    columns: np.ndarray
    _scatters: dict[int, tuple[np.ndarray, Scatter]] = field(default_factory=dict, repr=False)

    @property
    def n_node(self) -> int:
        """Number of block rows."""
        return len(self.row_start) - 1

    def scatter(self, connectivity: np.ndarray) -> Scatter:
        """The scatter of elements (n_element, m); computed once for each connectivity array."""
        if id(connectivity) not in self._scatters:
            where = _positions(self.row_start, self.columns, connectivity).ravel()
            order = np.argsort(where, kind="stable").astype(np.int32)
            counts = np.bincount(where, minlength=len(self.columns))
            start = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
            self._scatters[id(connectivity)] = (connectivity, Scatter(order, start))
        return self._scatters[id(connectivity)][1]


def pattern_of(n_node: int, connectivities: list[np.ndarray]) -> Pattern:
    """The pattern in which every two nodes of an element have a block."""
    incidences = []
    for nodes in connectivities:
        rows = np.repeat(np.arange(len(nodes)), nodes.shape[1])
        ones = np.ones(nodes.size, dtype=np.int8)
        incidences.append(sparse.csr_matrix((ones, (rows, nodes.ravel())), (len(nodes), n_node)))
    incidence = sparse.vstack(incidences, format="csr").astype(bool)
    adjacency = (incidence.T @ incidence).tocsr()
    adjacency.sort_indices()
    return Pattern(adjacency.indptr.astype(np.int32), adjacency.indices.astype(np.int32))


@dataclass(frozen=True)
class Constraint:
    """B^T M^-1 B without its products, which would couple too many nodes: volumes that pressures hold.

    B (n_p, 3 n_node) mm2; M (n_p, n_p) mm3/kPa, symmetric and positive definite, with its factors;
    softness (n_p,): B K^-1 B^T of the blocks K is about softness times M, in every row.
    """

    B: sparse.csr_matrix
    M: sparse.csr_matrix
    factors: SuperLU
    softness: np.ndarray


@dataclass
class Tangent:
    """K [mN/mm]: blocks (n_block, 3, 3) in a pattern, to which effects add, and one effect's constraint."""

    pattern: Pattern
    blocks: np.ndarray
    constraint: Constraint | None = None

    @classmethod
    def zero(cls, pattern: Pattern) -> "Tangent":
        """An empty matrix."""
        return cls(pattern, np.zeros((len(pattern.columns), 3, 3)))

    def add(self, connectivity: np.ndarray, Ke: np.ndarray) -> None:
        """K += the element tangents Ke (n_element, m, m, 3, 3) of elements (n_element, m)."""
        scatter = self.pattern.scatter(connectivity)
        _gather(scatter.order, scatter.start, Ke.reshape(-1, 3, 3), self.blocks)

    def to_csr(self) -> sparse.csr_matrix:
        """The full matrix (3 n_node, 3 n_node), constraints multiplied out: for small meshes."""
        n = self.pattern.n_node
        K = sparse.bsr_matrix(
            (self.blocks, self.pattern.columns, self.pattern.row_start), shape=(3 * n, 3 * n)
        ).tocsr()
        if self.constraint is None:
            return K
        B = self.constraint.B.toarray()
        stiff = B.T @ self.constraint.factors.solve(B)
        return K + sparse.csr_matrix((stiff + stiff.T) / 2)


@dataclass(frozen=True)
class UpperRows:
    """The upper triangle of the free part of a pattern, in compressed rows, and the place of its values.

    free (n_free,): degrees of freedom 3 * node + component, ascending; source: where K.blocks has the values.
    """

    free: np.ndarray
    row_start: np.ndarray
    columns: np.ndarray
    source: np.ndarray

    def values(self, K: Tangent) -> np.ndarray:
        """The values of the rows' entries, (n_entry,)."""
        return K.blocks.reshape(-1)[self.source]


def upper_rows(pattern: Pattern, held: np.ndarray) -> UpperRows:
    """The upper triangle over the degrees of freedom that are not held, held (n_node, 3) bool."""
    free = np.flatnonzero(~held.ravel())
    number = np.full(held.size, -1, dtype=np.int32)
    number[free] = np.arange(len(free))
    row_start, columns, source = _upper(pattern.row_start, pattern.columns, number.reshape(-1, 3))
    return UpperRows(free, row_start, columns, source)


def with_pressures(rows: UpperRows, K: Tangent, constraint: Constraint) -> sparse.csr_matrix:
    """The upper triangle of [[K, B^T], [B, -M]] over the free degrees of freedom and the pressures."""
    n = len(rows.free)
    upper = sparse.csr_matrix((rows.values(K), rows.columns, rows.row_start), shape=(n, n))
    B = constraint.B.tocsc()[:, rows.free]
    matrix = sparse.bmat([[upper, B.T], [None, -sparse.triu(constraint.M)]], format="csr")
    matrix.sort_indices()
    return matrix


def add_to_nodes(connectivity: np.ndarray, ge: np.ndarray, g: np.ndarray) -> None:
    """g += the element vectors ge (n_element, m, 3), in the order of the elements."""
    _add_to_nodes(connectivity, ge, g)


@numba.njit(cache=True)
def _add_to_nodes(connectivity, ge, g):  # type: ignore[no-untyped-def]
    for e in range(connectivity.shape[0]):
        for a in range(connectivity.shape[1]):
            for i in range(3):
                g[connectivity[e, a], i] += ge[e, a, i]


@numba.njit(cache=True, parallel=True)
def _positions(row_start, columns, connectivity):  # type: ignore[no-untyped-def]
    n_element, m = connectivity.shape
    where = np.empty((n_element, m, m), dtype=np.int32)
    for e in numba.prange(n_element):
        for a in range(m):
            low = row_start[connectivity[e, a]]
            row = columns[low : row_start[connectivity[e, a] + 1]]
            for b in range(m):
                where[e, a, b] = low + np.searchsorted(row, connectivity[e, b])
    return where


@numba.njit(cache=True, parallel=True)
def _gather(order, start, Ke, blocks):  # type: ignore[no-untyped-def]
    for p in numba.prange(blocks.shape[0]):
        for t in range(start[p], start[p + 1]):
            for i in range(3):
                for j in range(3):
                    blocks[p, i, j] += Ke[order[t], i, j]


@numba.njit(cache=True)
def _upper(row_start, columns, number):  # type: ignore[no-untyped-def]
    n_free = number.max() + 1
    counts = np.zeros(n_free + 1, dtype=np.int32)
    for a in range(number.shape[0]):
        for i in range(3):
            if number[a, i] >= 0:
                for p in range(row_start[a], row_start[a + 1]):
                    for j in range(3):
                        if number[columns[p], j] >= number[a, i]:
                            counts[number[a, i] + 1] += 1
    start = np.cumsum(counts).astype(np.int32)
    upper = np.empty(start[-1], dtype=np.int32)
    source = np.empty(start[-1], dtype=np.int64)
    for a in range(number.shape[0]):
        for i in range(3):
            if number[a, i] >= 0:
                t = start[number[a, i]]
                for p in range(row_start[a], row_start[a + 1]):
                    for j in range(3):
                        if number[columns[p], j] >= number[a, i]:
                            upper[t] = number[columns[p], j]
                            source[t] = 9 * np.int64(p) + 3 * i + j
                            t += 1
    return start, upper, source
