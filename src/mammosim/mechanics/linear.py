"""Symmetric sparse systems: analysed once, factorised at every Newton iteration, by PARDISO or by RSLAB.

PARDISO is the faster one (decisions/mechanics_direct.md) and is taken where MKL is installed; the answers
are the same up to rounding. MAMMOSIM_DIRECT_SOLVER names one.
"""

import os
from importlib.util import find_spec
from types import TracebackType
from typing import Protocol

import numpy as np
from scipy import sparse

from mammosim.core.errors import ConfigurationError

CHOICE = "MAMMOSIM_DIRECT_SOLVER"
PARDISO, RSLAB = "pardiso", "rslab"


class Factors(Protocol):
    """K = L D L^T of the upper triangle that it was made with, whose values are replaced in place.

    memory_mb: the peak of analysis and factors; negative_pivots: of the last factors.
    """

    def analyse(self) -> None:
        """Order the unknowns and lay out the factors; once, before the first factorisation."""

    def factorise(self) -> None:
        """Factorise the present values. Raises MechanicsError where there are no factors."""

    def solve(self, b: np.ndarray) -> np.ndarray:
        """x of K x = b with the last factors, (n,) or (n, m), in the precision of the matrix."""
        ...

    @property
    def negative_pivots(self) -> int:
        """How many eigenvalues are negative."""

    @property
    def memory_mb(self) -> float:
        """The peak of analysis and factors."""

    def release(self) -> None:
        """Give back what memory is not Python's; after an analysis."""


def direct_solver() -> str:
    """Which library factorises here. Raises ConfigurationError for an unknown choice."""
    chosen = os.environ.get(CHOICE) or (PARDISO if find_spec("pypardiso") else RSLAB)
    if chosen not in (PARDISO, RSLAB):
        raise ConfigurationError(f"{CHOICE} is {chosen!r}: {PARDISO} (x86-64 alone) or {RSLAB} can be chosen")
    if chosen == PARDISO and not find_spec("pypardiso"):
        raise ConfigurationError(f"{CHOICE} is {PARDISO}, but pypardiso is not installed: choose {RSLAB}")
    return chosen


def _factors(upper: sparse.csr_matrix) -> Factors:
    if direct_solver() == PARDISO:
        from mammosim.mechanics.pardiso import PardisoFactors

        return PardisoFactors(upper)
    from mammosim.mechanics.rslab import RslabFactors

    return RslabFactors(upper)


class SymmetricSolver:
    """One symmetric matrix pattern, K = L D L^T. Use as a context manager, which gives its memory back.

    The signs of D are those of the eigenvalues of K (Sylvester's law of inertia), so that every factorisation
    tells whether K is positive definite; Cholesky was no faster.
    single: factors in single precision, for a preconditioner, in half the time and memory.
    """

    def __init__(self, row_start: np.ndarray, columns: np.ndarray, *, single: bool = False) -> None:
        n = len(row_start) - 1
        self.factorisations = 0
        self._precision = np.float32 if single else np.float64
        values = np.zeros(len(columns), dtype=self._precision)
        self._upper = sparse.csr_matrix((values, columns, row_start), shape=(n, n))
        self._factors = _factors(self._upper)
        self._analysed = False

    def factorise(self, values: np.ndarray) -> bool:
        """Factorise the matrix with these values of the upper triangle; whether it is positive definite."""
        self._upper.data = np.asarray(values, dtype=self._precision)
        if not self._analysed:
            self._factors.analyse()
            self._analysed = True
        self.factorisations += 1
        self._factors.factorise()
        return self.negative_pivots == 0

    def solve(self, b: np.ndarray) -> np.ndarray:
        """x of K x = b with the last factors, (n,) or (n, m)."""
        return np.ascontiguousarray(self._factors.solve(np.asarray(b, dtype=self._precision)))

    @property
    def negative_pivots(self) -> int:
        """Number of negative eigenvalues of the last matrix."""
        return self._factors.negative_pivots

    @property
    def memory_mb(self) -> float:
        """Peak memory of analysis and factors."""
        return self._factors.memory_mb

    def release(self) -> None:
        """Give back what memory is not Python's."""
        if self._analysed:
            self._factors.release()
            self._analysed = False

    def successor(self, row_start: np.ndarray, columns: np.ndarray) -> "SymmetricSolver":
        """A solver of another pattern in place of this one, which is released and whose count goes on."""
        self.release()
        solver = SymmetricSolver(row_start, columns)
        solver.factorisations = self.factorisations
        return solver

    def __enter__(self) -> "SymmetricSolver":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.release()
