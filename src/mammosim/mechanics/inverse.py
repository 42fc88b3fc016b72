"""The inverse formulation: the reference X whose equilibrium under gravity is the measured shape x.

R(X) = dE/dx (x; X) = 0 at the free nodes, X = x at the held ones,  J dX = -R,  J = dR/dX

Newton's method on X (Govindjee & Mihalic 1996, Pathmanathan et al. 2006). The forces are those of the forward
problem on the same elements, so that X loaded again is x to the tolerance, whatever the mesh. J is not
symmetric; J v is a difference of forces along v, which holds for every effect, and J = -K at small strain
with the forward tangent K = d2E/dx2, so that GMRES preconditioned by -K^-1 needs few iterations.
"""

import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import LinearOperator, gcrotmk

from mammosim.core.errors import EquilibriumError, UnloadingError
from mammosim.core.mesh import TetMesh
from mammosim.mechanics.analysis import shared_analysis, system_of
from mammosim.mechanics.body import Body
from mammosim.mechanics.effects import Scaled
from mammosim.mechanics.equilibrium import Equilibrium, equilibrium
from mammosim.mechanics.multigrid import IndefiniteTangent
from mammosim.mechanics.newton import System, is_stable
from mammosim.mechanics.pattern import Tangent
from mammosim.mechanics.potential import Potential
from mammosim.mechanics.reference import require_well_posed, smallest_jacobians
from mammosim.mechanics.unloaded import Unloaded, UnloadingStep

log = logging.getLogger(__name__)

# Length of the difference that J v is taken from: the root of rounding, relative to a body of 100 mm.
_DIFFERENCE_MM = 1e-6
_PRECONDITIONER_ACCURACY = 1e-2
_RESTART, _CYCLES = 20, 3
_LARGEST_GROWTH = 4.0
# Residual that is enough under a part of the weight.
_ON_THE_WAY = 1e-3


@dataclass(frozen=True)
class InverseSettings:
    """tolerance: of the free forces relative to the weight, met in max_iterations.

    smallest_step: of a Newton step, relative;
    linear_accuracy: of each linear system, relative; smallest_load_step: of the weight, before it gives up.
    """

    tolerance: float = 1e-6
    max_iterations: int = 30
    smallest_step: float = 1 / 64
    linear_accuracy: float = 0.02
    smallest_load_step: float = 1 / 32


@dataclass(frozen=True)
class Measured:
    """A shape x = mesh.points, measured under gravity (3,), of a body whose reference is unknown."""

    mesh: TetMesh
    body: Body
    gravity: np.ndarray

    def potential(self, X: np.ndarray, load_factor: float = 1.0) -> Potential:
        """Of the body with the reference X (n_node, 3)."""
        mesh = self.mesh.moved_to(X)
        return Potential(self.body.effects(mesh), (self.body.weight(mesh, self.gravity),), load_factor)

    def forces(self, X: np.ndarray, load_factor: float = 1.0) -> np.ndarray:
        """dE/dx (n_node, 3) mN at the measured shape, for the reference X."""
        return self.potential(X, load_factor).gradient(self.mesh.points)


@dataclass(frozen=True)
class Linearised:
    """R and J at one reference X: what Newton and sensitivities solve with."""

    measured: Measured
    system: System
    X: np.ndarray
    R: np.ndarray
    K: Tangent

    @property
    def load_factor(self) -> float:
        """Of the weight."""
        return self.system.potential.load_factor

    def along(self, V: np.ndarray) -> np.ndarray:
        """J V (n_node, 3) mN/mm of a change of the reference V (n_node, 3)."""
        largest = float(np.abs(V).max())
        if largest == 0.0:
            return np.zeros_like(V)
        h = _DIFFERENCE_MM / largest
        JV: np.ndarray = (self.measured.forces(self.X + h * V, self.load_factor) - self.R) / h
        return JV

    def solved(self, b: np.ndarray, accuracy: float) -> np.ndarray:
        """V (n_node, 3) with J V = b (n_node, 3) at the free nodes, zero at the held ones.

        Raises IndefiniteTangent when K is not positive definite.
        """
        free, n, solver = self.system.rows.free, len(self.system.rows.free), self.system.solver
        b = b.ravel()[free]
        first = -solver.solve(self.K, b, _PRECONDITIONER_ACCURACY)

        def J(v: np.ndarray) -> np.ndarray:
            Jv: np.ndarray = self.along(self.system.spread(v)).ravel()[free]
            return Jv

        def M(r: np.ndarray) -> np.ndarray:
            return -solver.again(r, _PRECONDITIONER_ACCURACY)

        operator, preconditioner = (LinearOperator((n, n), matvec=f, dtype=float) for f in (J, M))
        v, unfinished = gcrotmk(
            operator, b, x0=first, M=preconditioner, rtol=accuracy, atol=0.0, m=_RESTART, maxiter=_CYCLES
        )
        if unfinished:
            log.warning("inverse: a linear system was not solved to %g in %d cycles", accuracy, _CYCLES)
        return self.system.spread(v)


@contextmanager
def linearised(measured: Measured, X: np.ndarray, load_factor: float = 1.0) -> Iterator[Linearised]:
    """The linearisation at a reference X (n_node, 3); cheap inside `shared_analysis`."""
    x = measured.mesh.points
    potential = measured.potential(X, load_factor)
    with system_of(potential, measured.body.held(measured.mesh)) as system:
        K = potential.tangent(x, system.pattern)
        yield Linearised(measured, system, X, potential.gradient(x), K)
        K.give_back()


@shared_analysis()
def inverse(
    measured: TetMesh,
    body: Body,
    *,
    gravity: np.ndarray,
    start: np.ndarray | None = None,
    settings: InverseSettings | None = None,
) -> Unloaded:
    """The shape without gravity by the inverse formulation: Newton on X (Govindjee & Mihalic 1996).

    measured: the mesh as it was measured, points in mm; body: what it is made of; gravity (3,): unit vector;
    start (n_node, 3) mm: a first guess; settings: tolerances. Returns points (n_node, 3) mm and a row per
    iteration.
    The history's distances are those of each correction. Without a start it begins with reverse gravity,
    under as much of the weight as Newton can begin with, and brings on the rest.
    Raises MechanicsError for an ill-posed problem, EquilibriumError when no reference was found, or when the
    measured shape would be no stable equilibrium of it, UnloadingError where only a part of the weight was
    brought on.
    """
    settings = settings or InverseSettings()
    require_well_posed(measured, body.held(measured))
    problem = Measured(measured, body, np.asarray(gravity, dtype=float))
    history: list[UnloadingStep] = []
    if start is not None:
        X = _newton(problem, start, 1.0, settings, history)
    else:
        X = _continued(problem, settings, history)
    _require_stable(problem, X)
    return Unloaded(X, tuple(history))


def _continued(problem: Measured, settings: InverseSettings, history: list[UnloadingStep]) -> np.ndarray:
    """The reference under the whole weight, which is brought on in steps where it must."""
    X, reached = _first(problem, settings, history)
    slope, step = (X - problem.mesh.points) / reached, reached
    while reached < 1.0:
        target = min(1.0, reached + step)
        try:
            X_new = _newton(problem, X + (target - reached) * slope, target, settings, history)
        except EquilibriumError as failure:
            log.info("inverse: load factor %.3f failed: %s", target, failure)
            step /= 2
            if step < settings.smallest_load_step:
                raise UnloadingError(str(failure), load_factor=reached) from failure
        else:
            slope = (X_new - X) / (target - reached)
            X, reached, step = X_new, target, 1.5 * step
    return X


def _first(
    problem: Measured, settings: InverseSettings, history: list[UnloadingStep]
) -> tuple[np.ndarray, float]:
    """A reference (n_node, 3), found from reverse gravity, and the load factor it is for: 1, 1/2, 1/4...

    At X = x itself the skin is at rest, neither taut nor slack, and J has no value.
    """
    mesh, factor = problem.mesh, 1.0
    effects, weight = problem.body.effects(mesh), problem.body.weight(mesh, -problem.gravity)
    while True:
        try:
            state = equilibrium(mesh, effects, loads=(Scaled(weight, factor),), held=problem.body.held(mesh))
            history.append(_reversed(len(history), mesh, state))
            return _newton(problem, state.points, factor, settings, history), factor
        except EquilibriumError as failure:
            log.info("inverse: reverse gravity, load factor %.3f failed: %s", factor, failure)
            if factor / 2 < settings.smallest_load_step:
                raise UnloadingError(str(failure), load_factor=0.0) from failure
            factor /= 2


def _reversed(iteration: int, mesh: TetMesh, state: Equilibrium) -> UnloadingStep:
    """Reverse gravity as the first correction of the measured shape."""
    skin = mesh.boundary_nodes("skin")
    distance = np.linalg.norm((state.points - mesh.points)[skin], axis=1)
    cost = state.factorisations, state.seconds
    return UnloadingStep(iteration, float(distance.mean()), float(distance.max()), 1.0, *cost)


def _require_stable(problem: Measured, X: np.ndarray) -> None:
    """Raises EquilibriumError when the measured shape is no minimum of the energy of the reference X."""
    with linearised(problem, X) as found:
        if not is_stable(found.system, problem.mesh.points):
            raise EquilibriumError(
                "the measured shape is an equilibrium of the reference that was found, but no stable one: "
                "the tissue is too soft for it; raise its modulus, or add skin"
            )


def _newton(
    problem: Measured,
    X: np.ndarray,
    load_factor: float,
    settings: InverseSettings,
    history: list[UnloadingStep],
) -> np.ndarray:
    """X with R(X) = 0 under a part of the weight, from a start; extends the history."""
    skin = problem.mesh.boundary_nodes("skin")
    for _ in range(settings.max_iterations):
        began = time.perf_counter()
        with linearised(problem, X, load_factor) as at:
            before = at.system.solver.factorisations
            residual = at.system.relative_residual(problem.mesh.points)
            log.info("inverse %d: residual %.1e of the weight", len(history), residual)
            if residual <= (settings.tolerance if load_factor == 1.0 else _ON_THE_WAY):
                return X
            try:
                dX = at.solved(-at.R, settings.linear_accuracy)
            except IndefiniteTangent:
                raise _no_reference(load_factor, "the measured shape is not stable on the way") from None
            length = _step_length(problem, at, X, dX, settings)
            distance = np.linalg.norm(dX[skin], axis=1)
            factorisations = at.system.solver.factorisations - before
        X = X + length * dX
        history.append(
            UnloadingStep(
                len(history),
                float(distance.mean()),
                float(distance.max()),
                length,
                factorisations,
                time.perf_counter() - began,
            )
        )
    raise _no_reference(
        load_factor, f"{settings.max_iterations} iterations left a residual of {residual:.1e} of the weight"
    )


def _no_reference(load_factor: float, reason: str) -> EquilibriumError:
    return EquilibriumError(
        f"the inverse formulation found no reference under {load_factor:.3f} of the weight: {reason}. The "
        "tissue may be too soft for the measured shape: raise its modulus, or add skin"
    )


def _step_length(
    problem: Measured, at: Linearised, X: np.ndarray, dX: np.ndarray, settings: InverseSettings
) -> float:
    """The largest of 1, 1/2, 1/4... after which no cell is inverted and the forces have not grown much."""
    free = at.system.rows.free
    now, length = float(np.linalg.norm(at.R.ravel()[free])), 1.0
    while length >= settings.smallest_step:
        trial = X + length * dX
        if np.all(np.isfinite(trial)) and smallest_jacobians(trial, problem.mesh.cells).min() > 0:
            R = problem.forces(trial, at.load_factor).ravel()[free]
            if np.linalg.norm(R) <= _LARGEST_GROWTH * now:
                return length
        length /= 2
    raise _no_reference(at.load_factor, "no step keeps the cells of the reference from inverting")
