"""Symmetric sparse systems through MKL PARDISO: analysed once, factorised at every Newton iteration.

pypardiso's public functions know the unsymmetric type only, twice the memory and three times the work; the
symmetric type goes through its private call, with the upper triangle in compressed rows.
"""

import copy
from functools import cache
from types import TracebackType

import numpy as np
from pypardiso import PyPardisoSolver
from pypardiso.pardiso_wrapper import PyPardisoError
from scipy import sparse

from mammosim.core.errors import MechanicsError

_SYMMETRIC_INDEFINITE = -2
_MKL_CBWR_AUTO = 2
_ANALYSE, _FACTORISE, _SOLVE, _RELEASE = 11, 22, 33, -1


@cache
def _library() -> PyPardisoSolver:
    """MKL, told to give the same bits in every run and for any number of threads."""
    solver = PyPardisoSolver()
    solver.libmkl.MKL_CBWR_Set(_MKL_CBWR_AUTO)
    return solver


class SymmetricSolver:
    """One symmetric matrix pattern, K = L D L^T. Use as a context manager, which releases PARDISO's memory.

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
        self._pardiso = copy.copy(_library())
        self._pardiso.pt = np.zeros(64, dtype=np.int64)
        self._pardiso.iparm = np.zeros(64, dtype=np.int32)
        self._pardiso.perm = np.zeros(n, dtype=np.int32)
        self._pardiso.mtype = _SYMMETRIC_INDEFINITE
        iparm = self._pardiso.iparm
        iparm[0] = 1  # no defaults
        iparm[1] = 2  # nested dissection, serial: the same order whatever the number of threads
        iparm[9] = 8  # perturb pivots below 1e-8
        iparm[20] = 1  # Bunch-Kaufman pivots
        iparm[27] = int(single)
        iparm[33] = 1  # sums as one thread would, whatever the number of threads
        self._analysed = False

    def factorise(self, values: np.ndarray) -> bool:
        """Factorise the matrix with these values of the upper triangle; whether it is positive definite."""
        self._upper.data = np.asarray(values, dtype=self._precision)
        if not self._analysed:
            self._call(_ANALYSE)
            self._analysed = True
        self.factorisations += 1
        try:
            self._call(_FACTORISE)
        except PyPardisoError as error:
            raise MechanicsError(
                f"PARDISO failed with code {error.value} on {self._upper.shape[0]} unknowns "
                f"({self.memory_mb:.0f} MB); -2 means too little memory: use a coarser mesh"
            ) from error
        return self.negative_pivots == 0

    def solve(self, b: np.ndarray) -> np.ndarray:
        """x of K x = b with the last factors, (n,) or (n, m)."""
        self._pardiso.phase = _SOLVE
        x = self._pardiso._call_pardiso(self._upper, np.asfortranarray(b, dtype=self._precision))
        return np.ascontiguousarray(x)

    @property
    def negative_pivots(self) -> int:
        """Number of negative eigenvalues of the last matrix."""
        return int(self._pardiso.iparm[22])

    @property
    def memory_mb(self) -> float:
        """Peak memory of analysis and factors."""
        iparm = self._pardiso.iparm
        return float(max(iparm[14], iparm[15] + iparm[16])) / 1e3

    def _call(self, phase: int) -> None:
        self._pardiso.phase = phase
        self._pardiso._call_pardiso(self._upper, np.zeros(self._upper.shape[0], dtype=self._precision))

    def release(self) -> None:
        """Give PARDISO's memory back."""
        if self._analysed:
            self._call(_RELEASE)
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
