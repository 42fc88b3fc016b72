"""The sparsity pattern that all effects of a mesh share, and the tangent matrix stored in it.

K is kept as 3x3 blocks in compressed rows over the nodes, both triangles. Element tangents are computed a
batch of elements at a time, so that they stay in the cache, and then gathered block by block, always in the
order of the elements: the sum is the same for any number of threads. The rows of K are not in the order of
the nodes but in one that puts neighbours near each other (Cuthill & McKee 1969), which memory likes.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import SuperLU

from mammosim.io.compiled import njit, prange

# Elements whose tangents are in memory at the same time; 1.8 MB of quadratic tetrahedra.
BATCH = 256


@dataclass(frozen=True)
class Scatter:
    """Where the element tangents of a batch, (n_element * m * m, 3, 3), go.

    Block target[t] sums the entries order[start[t]:start[t + 1]].
    """

    batch: slice
    order: np.ndarray
    start: np.ndarray
    target: np.ndarray

    @classmethod
    def of(cls, batch: slice, where: np.ndarray) -> "Scatter":
        """The scatter of entries that go to the blocks `where`, (n_element * m * m,)."""
        order = np.argsort(where, kind="stable").astype(np.int32)
        target, first = np.unique(where[order], return_index=True)
        return cls(batch, order, np.append(first, len(order)).astype(np.int32), target)


@dataclass(frozen=True)
class Pattern:
    """Row i, of node order[i], has the blocks columns[row_start[i]:row_start[i + 1]], ascending rows.

    number (n_node,): the rows of the nodes, the inverse of order.
    """

    row_start: np.ndarray
    columns: np.ndarray
    order: np.ndarray
    number: np.ndarray
    _scatters: dict[int, tuple[np.ndarray, list[Scatter]]] = field(default_factory=dict, repr=False)
    _spare: list[np.ndarray] = field(default_factory=list, repr=False)

    @property
    def n_node(self) -> int:
        """Number of block rows."""
        return len(self.row_start) - 1

    def scatters(self, connectivity: np.ndarray) -> list[Scatter]:
        """Those of the batches of elements (n_element, m); computed once for each connectivity array."""
        if id(connectivity) not in self._scatters:
            rows = self.number[connectivity]
            batches = [slice(e, e + BATCH) for e in range(0, len(connectivity), BATCH)]
            found = [
                Scatter.of(part, _positions(self.row_start, self.columns, rows[part]).ravel())
                for part in batches
            ]
            self._scatters[id(connectivity)] = (connectivity, found)
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
    order = reverse_cuthill_mckee(adjacency, symmetric_mode=True)
    adjacency = adjacency[order][:, order].tocsr()
    adjacency.sort_indices()
    number = np.empty_like(order)
    number[order] = np.arange(n_node, dtype=order.dtype)
    return Pattern(adjacency.indptr.astype(np.int32), adjacency.indices.astype(np.int32), order, number)


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
        """An empty matrix, in the memory of one that was given back if there is any."""
        if pattern._spare:
            blocks = pattern._spare.pop()
            blocks.fill(0.0)
            return cls(pattern, blocks)
        return cls(pattern, np.zeros((len(pattern.columns), 3, 3)))

    def give_back(self) -> None:
        """Leave the memory to the next tangent: new pages cost more than filling them. No use after that."""
        self.pattern._spare.append(self.blocks)
        self.blocks = np.zeros((0, 3, 3))

    def diagonal(self) -> np.ndarray:
        """The diagonal (n_node, 3) by nodes, without the constraint."""
        rows = np.repeat(np.arange(self.pattern.n_node), np.diff(self.pattern.row_start))
        middle = np.flatnonzero(self.pattern.columns == rows)
        diagonal: np.ndarray = np.einsum("nii->ni", self.blocks[middle])[self.pattern.number]
        return diagonal

    def add(self, connectivity: np.ndarray, Ke: np.ndarray) -> None:
        """K += the element tangents Ke (n_element, m, m, 3, 3) of elements (n_element, m)."""
        self.add_in_batches(connectivity, lambda batch: Ke[batch])

    def add_in_batches(self, connectivity: np.ndarray, tangents: Callable[[slice], np.ndarray]) -> None:
        """As add, with tangents(batch) (n_in_batch, m, m, 3, 3) of a slice of the elements at a time."""
        blocks = self.blocks.reshape(-1, 9)
        for scatter in self.pattern.scatters(connectivity):
            Ke = tangents(scatter.batch).reshape(-1, 9)
            _gather(scatter.order, scatter.start, scatter.target, Ke, blocks)

    def to_csr(self) -> sparse.csr_matrix:
        """The full matrix (3 n_node, 3 n_node) by nodes, constraints multiplied out: for small meshes."""
        n, dofs = self.pattern.n_node, block_entries(self.pattern.number)
        K = sparse.bsr_matrix(
            (self.blocks, self.pattern.columns, self.pattern.row_start), shape=(3 * n, 3 * n)
        ).tocsr()[dofs][:, dofs]
        if self.constraint is None:
            return K
        B = self.constraint.B.toarray()
        stiff = B.T @ self.constraint.factors.solve(B)
        return K + sparse.csr_matrix((stiff + stiff.T) / 2)


@dataclass(frozen=True)
class UpperRows:
    """The upper triangle of the free part of a pattern, in compressed rows, and the place of its values.

    free (n_free,): degrees of freedom 3 * node + component in the order of the rows of K, where they are
    3 * row + component = entries, ascending. row_start and columns are found when asked for.
    """

    pattern: Pattern
    free: np.ndarray
    entries: np.ndarray

    @property
    def row_start(self) -> np.ndarray:
        """(n_free + 1,)."""
        return self._rows[0]

    @property
    def columns(self) -> np.ndarray:
        """(n_entry,) numbers of free degrees of freedom."""
        return self._rows[1]

    @cached_property
    def _rows(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """row_start, columns, and where K.blocks has their values."""
        number = np.full(3 * self.pattern.n_node, -1, dtype=np.int32)
        number[self.entries] = np.arange(len(self.entries))
        return _upper(self.pattern.row_start, self.pattern.columns, number.reshape(-1, 3))

    def values(self, K: Tangent) -> np.ndarray:
        """The values of the rows' entries, (n_entry,)."""
        values: np.ndarray = K.blocks.reshape(-1)[self._rows[2]]
        return values


def upper_rows(pattern: Pattern, held: np.ndarray) -> UpperRows:
    """The upper triangle over the degrees of freedom that are not held, held (n_node, 3) bool."""
    entries = np.flatnonzero(~held[pattern.order])
    return UpperRows(pattern, block_entries(pattern.order)[entries], entries)


def block_entries(rows: np.ndarray) -> np.ndarray:
    """3 * row + component of rows (n,), as (3 n,)."""
    return (3 * rows[:, None] + np.arange(3)).ravel()


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


@njit(cache=True)
def _add_to_nodes(connectivity: np.ndarray, ge: np.ndarray, g: np.ndarray) -> None:
    for e in range(connectivity.shape[0]):
        for a in range(connectivity.shape[1]):
            for i in range(3):
                g[connectivity[e, a], i] += ge[e, a, i]


@njit(cache=True, parallel=True)
def _positions(row_start: np.ndarray, columns: np.ndarray, connectivity: np.ndarray) -> np.ndarray:
    n_element, m = connectivity.shape
    where = np.empty((n_element, m, m), dtype=np.int32)
    for e in prange(n_element):
        for a in range(m):
            low = row_start[connectivity[e, a]]
            row = columns[low : row_start[connectivity[e, a] + 1]]
            for b in range(m):
                where[e, a, b] = low + np.searchsorted(row, connectivity[e, b])
    return where


@njit(cache=True, parallel=True)
def _gather(
    order: np.ndarray, start: np.ndarray, target: np.ndarray, Ke: np.ndarray, blocks: np.ndarray
) -> None:
    """blocks (n_block, 9) at the targets += the sums of their entries of Ke (n_entry, 9)."""
    for s in prange(len(target)):
        a0 = a1 = a2 = a3 = a4 = a5 = a6 = a7 = a8 = 0.0
        for t in range(np.uint64(start[s]), np.uint64(start[s + 1])):
            e = np.uint64(order[t])
            a0 += Ke[e, 0]
            a1 += Ke[e, 1]
            a2 += Ke[e, 2]
            a3 += Ke[e, 3]
            a4 += Ke[e, 4]
            a5 += Ke[e, 5]
            a6 += Ke[e, 6]
            a7 += Ke[e, 7]
            a8 += Ke[e, 8]
        p = np.uint64(target[s])
        blocks[p, 0] += a0
        blocks[p, 1] += a1
        blocks[p, 2] += a2
        blocks[p, 3] += a3
        blocks[p, 4] += a4
        blocks[p, 5] += a5
        blocks[p, 6] += a6
        blocks[p, 7] += a7
        blocks[p, 8] += a8


@njit(cache=True)
def _upper(
    row_start: np.ndarray, columns: np.ndarray, number: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
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
