"""Factors by RSLAB, which is compiled for every processor: supernodal L D L^T with Bunch-Kaufman pivots.

Its factors are the same bits for any number of threads.
"""

import numba
import numpy as np
import rslab
from scipy import sparse

from mammosim.core.errors import MechanicsError

# Of the scaled matrix: what PARDISO, too, makes of a pivot that is nearly zero.
LEAST_PIVOT = 1e-8


class RslabFactors:
    """See linear.Factors."""

    def __init__(self, upper: sparse.csr_matrix) -> None:
        self._upper = upper
        self._symbolic: rslab.LdltSymbolic | None = None
        self._factors: rslab.Ldlt | None = None

    def analyse(self) -> None:
        """See linear.Factors."""
        upper = self._upper
        # The upper rows of a symmetric matrix are its lower columns.
        lower = sparse.csc_matrix((upper.data, upper.indices, upper.indptr), shape=upper.shape)
        self._symbolic = rslab.analyze(lower, path="ldlt", threads=numba.get_num_threads())

    def factorise(self) -> None:
        """See linear.Factors."""
        if self._symbolic is None:
            raise ValueError("the pattern was not analysed")
        try:
            self._factors = self._factorised(self._symbolic)
        except RuntimeError as error:
            raise MechanicsError(
                f"RSLAB failed on {self._upper.shape[0]} unknowns ({self.memory_mb:.0f} MB): {error}; "
                "where memory is short, use a coarser mesh"
            ) from error

    def _factorised(self, symbolic: rslab.LdltSymbolic) -> rslab.Ldlt:
        values = self._upper.data
        try:
            return symbolic.factor(values)
        except RuntimeError:  # a pivot is zero
            return symbolic.factor(values, preconditioner=LEAST_PIVOT)

    def solve(self, b: np.ndarray) -> np.ndarray:
        """See linear.Factors."""
        if self._factors is None:
            raise ValueError("nothing was factorised")
        x: np.ndarray = self._factors.solve(b) if b.ndim == 1 else self._factors.solve_many(b)
        return x

    @property
    def negative_pivots(self) -> int:
        """See linear.Factors."""
        return 0 if self._factors is None else int(self._factors.inertia[1])

    @property
    def memory_mb(self) -> float:
        """See linear.Factors."""
        if self._symbolic is None:
            return 0.0
        return float(self._symbolic.memory_plan(self._upper.dtype.name)["peak_bytes"]) / 1e6

    def release(self) -> None:
        """See linear.Factors."""
        self._symbolic = self._factors = None
