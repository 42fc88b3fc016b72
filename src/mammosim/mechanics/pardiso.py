"""Factors by MKL PARDISO, which exists for x86-64 alone.

pypardiso's public functions know the unsymmetric type only, twice the memory and three times the work; the
symmetric type goes through its private call, with the upper triangle in compressed rows.
"""

import copy
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import numpy as np
from scipy import sparse

from mammosim.core.errors import MechanicsError


@contextmanager
def _told_where_mkl_is() -> Iterator[None]:
    """Otherwise pypardiso walks through every folder of the environment at each start: 0.2 s, twice."""
    name, found = "PYPARDISO_MKL_RT", next(Path(sys.prefix, "lib").glob("libmkl_rt.*"), None)
    untold = name not in os.environ and found is not None
    if untold:
        os.environ[name] = str(found)
    yield
    if untold:
        del os.environ[name]  # a child process may have an environment, and an MKL, of its own


with _told_where_mkl_is():
    from pypardiso import PyPardisoSolver
    from pypardiso.pardiso_wrapper import PyPardisoError
    from pypardiso.scipy_aliases import pypardiso_solver

_SYMMETRIC_INDEFINITE = -2
_MKL_CBWR_AUTO = 2
_ANALYSE, _FACTORISE, _SOLVE, _RELEASE = 11, 22, 33, -1


@cache
def _library() -> PyPardisoSolver:
    """MKL, told to give the same bits in every run and for any number of threads."""
    solver: PyPardisoSolver = pypardiso_solver
    solver.libmkl.MKL_CBWR_Set(_MKL_CBWR_AUTO)
    return solver


class PardisoFactors:
    """See linear.Factors."""

    def __init__(self, upper: sparse.csr_matrix) -> None:
        n = upper.shape[0]
        self._upper = upper
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
        iparm[27] = int(upper.dtype == np.float32)
        iparm[33] = 1  # sums as one thread would, whatever the number of threads

    def analyse(self) -> None:
        """See linear.Factors."""
        self._call(_ANALYSE)

    def factorise(self) -> None:
        """See linear.Factors."""
        try:
            self._call(_FACTORISE)
        except PyPardisoError as error:
            raise MechanicsError(
                f"PARDISO failed with code {error.value} on {self._upper.shape[0]} unknowns "
                f"({self.memory_mb:.0f} MB); -2 means too little memory: use a coarser mesh"
            ) from error

    def solve(self, b: np.ndarray) -> np.ndarray:
        """See linear.Factors."""
        self._pardiso.phase = _SOLVE
        x: np.ndarray = self._pardiso._call_pardiso(self._upper, np.asfortranarray(b))
        return x

    @property
    def negative_pivots(self) -> int:
        """See linear.Factors."""
        return int(self._pardiso.iparm[22])

    @property
    def memory_mb(self) -> float:
        """See linear.Factors."""
        iparm = self._pardiso.iparm
        return float(max(iparm[14], iparm[15] + iparm[16])) / 1e3

    def release(self) -> None:
        """See linear.Factors."""
        self._call(_RELEASE)

    def _call(self, phase: int) -> None:
        self._pardiso.phase = phase
        self._pardiso._call_pardiso(self._upper, np.zeros(self._upper.shape[0], dtype=self._upper.dtype))
