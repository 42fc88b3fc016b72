"""Newton's method on a potential, guarded: every shape it visits has J > 0 at all integration points."""

from dataclasses import dataclass, field, replace
from types import TracebackType
from typing import NamedTuple

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.mechanics.budget import Spending
from mammosim.mechanics.direct import TangentSolver
from mammosim.mechanics.multigrid import IndefiniteTangent
from mammosim.mechanics.pattern import Pattern, UpperRows, pattern_of, upper_rows
from mammosim.mechanics.potential import Potential
from mammosim.mechanics.solvers import tangent_solver

# Residuals are not measured against less than this, the weight of 0.1 g: without load, forces are rounding.
SMALLEST_FORCE_MN = 1.0
_COARSEST_ACCURACY = 1e-2
# A residual that rounding explains is accepted up to here: stiff thin layers leave some 1e-7.
LARGEST_ROUNDING = 1e-6


class Iteration(NamedTuple):
    """One Newton iteration: the state it began with, and what it did."""

    load_factor: float
    residual: float
    energy: float
    smallest_J: float
    negative_pivots: int
    step_length: float


class StepFailed(Exception):
    """Newton did not converge at this load; internal to the package, caught by the load control.

    x (n_node, 3): the last shape; indefinite: whether its tangent had negative eigenvalues.
    """

    def __init__(self, message: str, x: np.ndarray, *, indefinite: bool = False) -> None:
        super().__init__(message)
        self.x = x
        self.indefinite = indefinite


@dataclass(frozen=True)
class NewtonSettings:
    """How one load step is solved.

    tolerance: of the free forces relative to the load; trusted: steps in which the energy may rise;
    stagnation: iterations without halving the residual after which it gives up; projection: whether it goes
    on, with the positive semidefinite part, where the tangent is indefinite.
    """

    tolerance: float = 1e-8
    max_iterations: int = 40
    trusted: int = 2
    smallest_step: float = 2.0**-10
    stagnation: int = 12
    projection: bool = True


@dataclass(frozen=True)
class System:
    """A potential with the degrees of freedom that are free, the solver of its tangent, and what is spent."""

    potential: Potential
    held: np.ndarray
    pattern: Pattern
    rows: UpperRows
    solver: TangentSolver
    spending: Spending = field(default_factory=Spending)

    @classmethod
    def of(cls, potential: Potential, held: np.ndarray, multigrid_above: int | None = None) -> "System":
        """The system of a potential, held (n_node, 3) bool; see tangent_solver."""
        elements = [term.connectivity for term in potential.terms if len(term.connectivity)]
        pattern = pattern_of(len(held), elements)
        rows = upper_rows(pattern, held)
        return cls(
            potential, held, pattern, rows, tangent_solver(pattern, rows, held, elements, multigrid_above)
        )

    def under(self, load_factor: float) -> "System":
        """The same system under a part of its loads."""
        return replace(self, potential=self.potential.at(load_factor))

    def free_gradient(self, x: np.ndarray) -> np.ndarray:
        """dPi/dx of the free degrees of freedom (n_free,), mN."""
        g: np.ndarray = self.potential.gradient(x).ravel()[self.rows.free]
        return g

    def relative_residual(self, x: np.ndarray) -> float:
        """Norm of the free forces relative to the largest of any effect, at least SMALLEST_FORCE_MN."""
        return float(np.linalg.norm(self.free_gradient(x))) / self._scale(x)

    def is_balanced(self, x: np.ndarray, residual: float, tolerance: float) -> bool:
        """Whether the relative residual at x is within the tolerance, or is explained by rounding.

        Positions rounded to eps |x| leave forces of eps |diag(K) x|: with a skin 1e5 times stiffer than what
        it covers more than 1e-8 of the load.
        """
        if residual <= tolerance or residual > LARGEST_ROUNDING:
            return residual <= tolerance
        K = self.potential.tangent(x, self.pattern)
        left = np.finfo(float).eps * np.linalg.norm((K.diagonal() * x)[~self.held])
        K.give_back()
        return bool(residual * self._scale(x) <= left)

    def _scale(self, x: np.ndarray) -> float:
        return max(SMALLEST_FORCE_MN, self.potential.force_scale(x, ~self.held))

    def spread(self, step: np.ndarray) -> np.ndarray:
        """A step of the free degrees of freedom (n_free,) as (n_node, 3), zero where held."""
        dx = np.zeros(self.held.size)
        dx[self.rows.free] = step
        return dx.reshape(self.held.shape)

    def __enter__(self) -> "System":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.solver.release()


def is_stable(system: System, x: np.ndarray) -> bool:
    """Whether the exact tangent at x is positive definite."""
    K = system.potential.tangent(x, system.pattern)
    definite = system.solver.is_definite(K)
    K.give_back()
    return definite


@dataclass
class _Watchdog:
    """The shape of lowest energy so far, the Newton step from it, and how many steps did not improve it."""

    x: np.ndarray
    energy: float
    dx: np.ndarray
    slope: float
    patience: int = 0


@dataclass
class _Progress:
    """The smallest residual of an iteration, and when it was last halved."""

    smallest: float = np.inf
    halved: int = 0

    def stagnates(self, iteration: int, residual: float, patience: int) -> bool:
        """Whether `patience` iterations have not halved the smallest residual."""
        if residual <= self.smallest / 2:
            self.smallest, self.halved = residual, iteration
        return iteration - self.halved >= patience


def converge(system: System, x: np.ndarray, settings: NewtonSettings, history: list[Iteration]) -> np.ndarray:
    """x (n_node, 3) in equilibrium, found from a start x. Extends the history.

    Raises StepFailed, and BudgetSpent.
    """
    potential, tangent_of = system.potential, system.potential
    best: _Watchdog | None = None
    last, progress = 0.0, _Progress()
    for iteration in range(settings.max_iterations):
        system.spending.iterate(x)
        energy, residual = potential.energy(x), system.relative_residual(x)
        smallest_J = potential.smallest_J(x)
        if not np.isfinite(energy) or smallest_J <= 0:
            raise StepFailed(f"the start has J = {smallest_J:.3f} at an integration point", x)
        row = Iteration(potential.load_factor, residual, energy, smallest_J, 0, 0.0)
        if system.is_balanced(x, residual, settings.tolerance):
            history.append(row)
            return x
        if progress.stagnates(iteration, residual, settings.stagnation):
            raise StepFailed(f"the residual stagnates at {progress.smallest:.1e}", x)
        accuracy = _accuracy(residual, last, settings)
        try:
            dx, slope, negative = _newton_step(system, tangent_of, x, settings, accuracy)
        except IndefiniteTangent as found:
            history.append(row._replace(negative_pivots=found.negative))
            raise StepFailed("the tangent is indefinite", x, indefinite=True) from found
        last = residual
        if best is None or energy <= best.energy + 1e-4 * best.slope + _rounding(best.energy):
            best = _Watchdog(x, energy, dx, slope)
        elif best.patience < settings.trusted:
            best.patience += 1
        else:
            x, energy, dx, slope = best.x, best.energy, best.dx, best.slope
            best = _Watchdog(x, energy, dx, slope, patience=settings.trusted)
        searching = best.patience >= settings.trusted and x is best.x
        length = _step_length(potential, x, dx, settings, slope if searching else None)
        history.append(row._replace(negative_pivots=negative, step_length=length))
        tangent_of = potential.predicted(x, length * dx)
        x = x + length * dx
    raise StepFailed(f"{settings.max_iterations} iterations left a residual of {residual:.1e}", x)


def _rounding(energy: float) -> float:
    """What rounding may change an energy by."""
    return 1e-11 * abs(energy)


def _newton_step(
    system: System, tangent_of: Potential, x: np.ndarray, settings: NewtonSettings, accuracy: float
) -> tuple[np.ndarray, float, int]:
    """dx (n_node, 3), the slope g . dx, and the negative pivots of the tangent, which is then projected.

    Raises IndefiniteTangent when it may not be projected.
    """
    g = system.free_gradient(x)
    K = tangent_of.tangent(x, system.pattern)
    try:
        step, negative = system.solver.solve(K, -g, accuracy), 0
    except IndefiniteTangent as found:
        if not settings.projection:
            raise
        K.give_back()
        K = tangent_of.tangent(x, system.pattern, projected=True)
        step, negative = system.solver.solve_projected(K, -g, accuracy), found.negative
    K.give_back()
    if not np.all(np.isfinite(step)):
        raise MechanicsError("the tangent is singular: is part of the mesh not attached to the held nodes?")
    return system.spread(step), float(g @ step), negative


def _accuracy(residual: float, last: float, settings: NewtonSettings) -> float:
    """Of the linear system, relative: what quadratic convergence can use (Eisenstat & Walker 1996)."""
    useful = min(_COARSEST_ACCURACY, 0.5 * (residual / last) ** 2 if last else 1.0)
    return max(useful, min(_COARSEST_ACCURACY, 0.3 * settings.tolerance / residual))


def _step_length(
    potential: Potential, x: np.ndarray, dx: np.ndarray, settings: NewtonSettings, slope: float | None
) -> float:
    """The largest of 1, 1/2, 1/4... that keeps J > 0, and with a slope also lowers the energy (Armijo)."""
    smallest = 0.1 * min(1.0, potential.smallest_J(x))
    energy = potential.energy(x)
    length = 1.0
    while length >= settings.smallest_step:
        trial = x + length * dx
        if potential.smallest_J(trial) >= smallest and (
            slope is None or potential.energy(trial) <= energy + 1e-4 * length * slope + _rounding(energy)
        ):
            return length
        length /= 2
    raise StepFailed(f"no step keeps J > 0 and lowers the energy; smallest J is {smallest * 10:.3f}", x)
