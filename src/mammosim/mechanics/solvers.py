"""Linear systems of Newton's method: solved directly, or by conjugate gradients under a V-cycle."""

import logging

import numpy as np
from scipy.linalg import eigh_tridiagonal

from mammosim.core.rng import generator
from mammosim.mechanics.direct import DirectSolver, TangentSolver
from mammosim.mechanics.multigrid import IndefiniteTangent, VCycle
from mammosim.mechanics.pattern import Constraint, Pattern, Tangent, UpperRows
from mammosim.mechanics.saddle import SaddlePoint
from mammosim.mechanics.smoother import dot

log = logging.getLogger(__name__)

# From this number of unknowns on, the V-cycle is faster in all cases (decisions/mechanics_multigrid.md).
MULTIGRID_ABOVE = 15_000
# Where the linear solver or Lanczos needs more steps, the matrix is factorised after all.
MAX_ITERATIONS = 200
MAX_LANCZOS_STEPS = 300
# With a constraint: at nu = 0.4999 steps of 1e-2 left volumes so wrong that Newton took 9 instead of 7.
CONSTRAINED_ACCURACY = 1e-3
# The probability of overlooking a negative eigenvalue; for the bound see MultigridSolver.is_definite.
OVERLOOKED = 1e-6


class _TooManySteps(Exception):
    """Conjugate gradients or Lanczos came to no end."""


class MultigridSolver:
    """Conjugate gradients under a V-cycle whose coarse level, the linear elements, is factorised.

    A tangent is rejected as indefinite when a diagonal block, the coarse matrix or p . K p of a search
    direction is not positive, each of which is a proof, and to be safe when r . M^-1 r is not, which may also
    mean that the smoother's bound was too low. That a tangent is definite is an estimate, see is_definite.
    A mesh on which too many iterations were needed once is solved directly from then on.
    """

    def __init__(self, pattern: Pattern, cells: np.ndarray, rows: UpperRows, held: np.ndarray) -> None:
        self._cycle = VCycle(pattern, cells, held)
        self._rows = rows
        self._held, self._order = held[pattern.order], pattern.order
        self._direct: DirectSolver | None = None
        self._last: Tangent | None = None
        self.iterations = 0

    @property
    def stability(self) -> str:
        """Lanczos, or inertia where the matrix was factorised."""
        return "Lanczos" if self._direct is None else self._direct.stability

    @property
    def factorisations(self) -> int:
        """Of the coarse matrix, and of the whole one."""
        return self._cycle.factorisations + (self._direct.factorisations if self._direct else 0)

    def solve(self, K: Tangent, b: np.ndarray, tolerance: float) -> np.ndarray:
        """See TangentSolver."""
        if self._direct is not None:
            return self._direct.solve(K, b, tolerance)
        self._cycle.prepare(K)
        self._last = K
        return self.again(b, tolerance)

    def again(self, b: np.ndarray, tolerance: float) -> np.ndarray:
        """See TangentSolver."""
        if self._direct is not None:
            return self._direct.again(b, tolerance)
        if self._last is None:
            raise ValueError("no tangent was solved with before")
        try:
            if self._last.constraint is not None:
                return self._constrained(self._last.constraint, b, tolerance)
            return self._conjugate_gradients(b, tolerance)
        except _TooManySteps:
            return self._direct_from_now_on().solve(self._last, b, tolerance)

    def solve_projected(self, K: Tangent, b: np.ndarray, tolerance: float) -> np.ndarray:
        """See TangentSolver; ends at a direction of descent where rounding makes p . K p negative."""
        if self._direct is not None:
            return self._direct.solve_projected(K, b, tolerance)
        try:
            self._cycle.prepare(K, semidefinite=True)
            if K.constraint is not None:
                return self._constrained(K.constraint, b, tolerance)
            return self._conjugate_gradients(b, tolerance, semidefinite=True)
        except _TooManySteps:
            return self._direct_from_now_on().solve_projected(K, b, tolerance)

    def _constrained(self, constraint: Constraint, b: np.ndarray, tolerance: float) -> np.ndarray:
        """By GMRES with pressures as unknowns; a step that does not descend proves K indefinite."""
        system = SaddlePoint(self._cycle, constraint, self._order, self._held)
        x, iterations = system.solve(self._spread(b), min(tolerance, CONSTRAINED_ACCURACY), MAX_ITERATIONS)
        self.iterations += iterations
        if x is None:
            raise _TooManySteps
        step = self._free(x)
        if not np.sum(step * b) > 0:
            raise IndefiniteTangent(1)
        return step

    def _direct_from_now_on(self) -> DirectSolver:
        log.info("too many iterations are needed: the matrix is factorised from now on")
        self._cycle.release()
        self._direct = DirectSolver(self._rows)
        return self._direct

    def _conjugate_gradients(
        self, b: np.ndarray, tolerance: float, *, semidefinite: bool = False
    ) -> np.ndarray:
        r = self._spread(b)
        x = np.zeros_like(r)
        enough = tolerance**2 * dot(r, r)
        p, rz = np.zeros_like(r), np.inf
        for _ in range(MAX_ITERATIONS):
            if dot(r, r) <= enough:
                return self._free(x)
            p, rz = self._next_direction(r, p, rz)
            Kp = self._cycle.times(p)
            pKp = dot(p, Kp)
            if not (pKp > 0 and rz > 0):
                if not semidefinite:
                    raise IndefiniteTangent(1)
                if x.any():
                    return self._free(x)
                break
            x += (rz / pKp) * p
            r -= (rz / pKp) * Kp
        raise _TooManySteps

    def _next_direction(self, r: np.ndarray, p: np.ndarray, rz: float) -> tuple[np.ndarray, float]:
        """p = z + beta p with z = M^-1 r, and r . z; beta = 0 when the last r . z is infinite."""
        self.iterations += 1
        z = self._cycle(r)
        following = dot(r, z)
        return z + (following / rz) * p, following

    def is_definite(self, K: Tangent) -> bool:
        """Whether the smallest eigenvalue of M^-1 K is positive, by Lanczos from a random vector.

        The bound of Kuczynski & Wozniakowski (1992): after k steps the smallest Ritz value t of a spectrum
        below L is above the smallest eigenvalue by less than e L, except with a probability of
        1.648 sqrt(m) exp(-(2 k - 1) sqrt(e)). Steps are added until e = t / (L + t) makes that OVERLOOKED.
        m is their number of unknowns where v = M^-1/2 r is equally long in all directions on average; with
        r = D^1/2 g, g normal, no direction has less than the share M^-1 D > least of |v|^2 = r . M^-1 r, so
        that m = r . M^-1 r / least.
        """
        if self._direct is not None:
            return self._direct.is_definite(K)
        try:
            self._cycle.prepare(K)
            t, steps = self._smallest_ritz_value()
            log.debug("Lanczos: smallest eigenvalue of M^-1 K about %.3g after %d steps", t, steps)
        except IndefiniteTangent:
            # With a constraint the whole matrix may yet be definite: its factors tell.
            return K.constraint is not None and self._direct_from_now_on().is_definite(K)
        except _TooManySteps:
            return self._direct_from_now_on().is_definite(K)
        return True

    def _smallest_ritz_value(self) -> tuple[float, int]:
        """t of is_definite, and how many steps it took."""
        r = self._cycle.noise(generator("stability"))
        p, rz, last_rz = np.zeros_like(r), np.inf, np.inf
        diagonal: list[float] = []
        beside: list[float] = []
        steepness = 0.0  # p . K p / r . z
        odds = np.inf
        for k in range(1, MAX_LANCZOS_STEPS + 1):
            p, rz = self._next_direction(r, p, last_rz)
            Kp = self._cycle.times(p)
            pKp = dot(p, Kp)
            if not (pKp > 0 and rz > 0):
                raise IndefiniteTangent(1)
            if k == 1:
                odds = np.log(1.648 * np.sqrt(rz / self._cycle.least) / OVERLOOKED)
            ratio = rz / last_rz  # 0 in the first step
            diagonal.append(pKp / rz + ratio * steepness)
            if k > 1:
                beside.append(np.sqrt(ratio) * steepness)
            steepness, last_rz = pKp / rz, rz
            r -= (rz / pKp) * Kp
            ritz = eigh_tridiagonal(diagonal, beside, eigvals_only=True)
            t, L = ritz[0], ritz[-1]
            if t > 0 and (2 * k - 1) * np.sqrt(t / (L + t)) > odds:
                return float(t), k
        raise _TooManySteps

    def _spread(self, b: np.ndarray) -> np.ndarray:
        """b (n_free,) as (n_node, 3) in the order of the rows of K, zero where held."""
        r = np.zeros(self._held.size)
        r[self._rows.entries] = b
        return r.reshape(self._held.shape)

    def _free(self, x: np.ndarray) -> np.ndarray:
        """The free entries (n_free,) of x (n_node, 3), which is in the order of the rows of K."""
        free: np.ndarray = x.ravel()[self._rows.entries]
        return free

    def preconditioned(self, r: np.ndarray) -> np.ndarray:
        """See TangentSolver."""
        if self._direct is not None:
            return self._direct.preconditioned(r)
        return self._free(self._cycle(self._spread(r)))

    @property
    def memory_mb(self) -> float:
        """Of the factors of the coarse matrix, and of the whole one."""
        return self._cycle.memory_mb + (self._direct.memory_mb if self._direct else 0.0)

    def release(self) -> None:
        """Give back what memory is not Python's."""
        self._cycle.release()
        if self._direct is not None:
            self._direct.release()


def tangent_solver(
    pattern: Pattern,
    rows: UpperRows,
    held: np.ndarray,
    elements: list[np.ndarray],
    multigrid_above: int | None = None,
) -> TangentSolver:
    """The solver for a mesh: multigrid for many unknowns on quadratic tetrahedra, direct for all others."""
    tetrahedra = [cells for cells in elements if cells.shape[1] == 10]
    limit = MULTIGRID_ABOVE if multigrid_above is None else multigrid_above
    if len(rows.free) <= limit or not tetrahedra:
        return DirectSolver(rows)
    cells = np.vstack(tetrahedra)
    if len(np.unique(cells)) < pattern.n_node:
        return DirectSolver(rows)
    return MultigridSolver(pattern, cells, rows, held)
