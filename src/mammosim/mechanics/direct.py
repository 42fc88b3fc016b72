"""What Newton asks of a solver of its tangents, and the one that factorises them."""

from typing import Protocol

import numpy as np

from mammosim.mechanics.linear import SymmetricSolver
from mammosim.mechanics.multigrid import IndefiniteTangent
from mammosim.mechanics.pattern import Tangent, UpperRows, with_pressures


class TangentSolver(Protocol):
    """Solves K x = b on the free degrees of freedom.

    stability: how is_definite knows; factorisations and iterations, of conjugate gradients, so far.
    """

    iterations: int

    @property
    def stability(self) -> str:
        """inertia or Lanczos."""

    @property
    def factorisations(self) -> int:
        """How many so far."""

    def solve(self, K: Tangent, b: np.ndarray, tolerance: float) -> np.ndarray:
        """x (n_free,), |K x - b| <= tolerance |b|. Raises IndefiniteTangent when K is found not definite."""
        ...

    def again(self, b: np.ndarray, tolerance: float) -> np.ndarray:
        """As solve, with the K of the last solve, which must not have been given back."""
        ...

    def solve_projected(self, K: Tangent, b: np.ndarray, tolerance: float) -> np.ndarray:
        """As solve, of a K that is positive semidefinite by construction, up to rounding."""
        ...

    def is_definite(self, K: Tangent) -> bool:
        """Whether K is positive definite."""
        ...

    def preconditioned(self, r: np.ndarray) -> np.ndarray:
        """M^-1 r (n_free,), M the last tangent or its approximation, symmetric and positive definite."""
        ...

    @property
    def memory_mb(self) -> float:
        """Of the factors."""

    def release(self) -> None:
        """Give back what memory is not Python's."""


class DirectSolver:
    """LDL^T of the whole matrix; the tolerance is not used. The inertia proves whether K is definite.

    A constraint is factorised with its pressures as unknowns, [[K, B^T], [B, -M]]: of the negative pivots one
    for each pressure belongs to -M, the others to K + B^T M^-1 B (additivity of the inertia).
    """

    stability = "inertia"

    def __init__(self, rows: UpperRows) -> None:
        self.iterations = 0
        self._rows = rows
        self._pressures = 0
        self._symmetric = SymmetricSolver(rows.row_start, rows.columns)

    @property
    def factorisations(self) -> int:
        """Of the whole matrix."""
        return self._symmetric.factorisations

    def solve(self, K: Tangent, b: np.ndarray, tolerance: float) -> np.ndarray:
        """See TangentSolver."""
        negative = self._negative_pivots(K)
        if negative:
            raise IndefiniteTangent(negative)
        return self._solved(b)

    def again(self, b: np.ndarray, tolerance: float) -> np.ndarray:
        """See TangentSolver."""
        return self._solved(b)

    def solve_projected(self, K: Tangent, b: np.ndarray, tolerance: float) -> np.ndarray:
        """See TangentSolver."""
        self._negative_pivots(K)
        return self._solved(b)

    def is_definite(self, K: Tangent) -> bool:
        """Whether no pivot is negative."""
        return self._negative_pivots(K) == 0

    def _negative_pivots(self, K: Tangent) -> int:
        """Factorise; how many eigenvalues of K are negative."""
        if K.constraint is not None:
            upper = with_pressures(self._rows, K, K.constraint)
            if self._pressures != upper.shape[0] - len(self._rows.free):
                self._symmetric = self._symmetric.successor(upper.indptr, upper.indices)
                self._pressures = upper.shape[0] - len(self._rows.free)
            self._symmetric.factorise(upper.data)
        else:
            self._symmetric.factorise(self._rows.values(K))
        return self._symmetric.negative_pivots - self._pressures

    def _solved(self, b: np.ndarray) -> np.ndarray:
        return self._symmetric.solve(np.concatenate([b, np.zeros(self._pressures)]))[: len(b)]

    def preconditioned(self, r: np.ndarray) -> np.ndarray:
        """See TangentSolver."""
        return self._solved(r)

    @property
    def memory_mb(self) -> float:
        """Of the factors of the whole matrix."""
        return self._symmetric.memory_mb

    def release(self) -> None:
        """Give back what memory is not Python's."""
        self._symmetric.release()
