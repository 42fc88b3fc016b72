"""Equilibrium: a verified minimum of the potential energy of a scene.

Newton's method on the free degrees of freedom, with the pressure of the bulk predicted at the integration
points (see NeoHookean.predicted). Steps are cut so that J stays positive at every integration point; energy
may rise for a few steps (a watchdog, Chamberlain et al. 1982), after which the solver returns to the best
shape and searches along the line for a lower energy. When a load step fails it is halved.
"""

import logging
import time
from dataclasses import dataclass, field, replace

import numpy as np

from mammosim.core.errors import EquilibriumError
from mammosim.core.mesh import TetMesh
from mammosim.mechanics.effects.protocol import Effect
from mammosim.mechanics.newton import Iteration, NewtonSettings, StepFailed, System, converge, is_stable
from mammosim.mechanics.potential import Potential
from mammosim.mechanics.soundness import require_well_posed

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Settings:
    """How the loads are applied.

    load_steps: how many equal steps to begin with; smallest_step: of the load factor, then the solver gives
    up.
    """

    newton: NewtonSettings = field(default_factory=NewtonSettings)
    load_steps: int = 1
    smallest_step: float = 1 / 64


@dataclass(frozen=True)
class Equilibrium:
    """A verified state of equilibrium.

    points (n_node, 3) mm; history: one row per Newton iteration; residual: the free forces relative to the
    load; smallest_J at the integration points; positive_definite: the exact tangent is, so a stable minimum;
    stability: how that is known, by the `inertia` of its factors or by `Lanczos`, see mechanics.solvers;
    energy uJ; factorisations (of the coarse level under conjugate gradients); cg_iterations; seconds of wall
    time.
    """

    points: np.ndarray
    history: tuple[Iteration, ...]
    residual: float
    smallest_J: float
    positive_definite: bool
    stability: str
    energy: float
    factorisations: int
    cg_iterations: int
    seconds: float


def held_nodes(mesh: TetMesh) -> np.ndarray:
    """(n_node, 3) bool: every component of the nodes of `posterior`."""
    held = np.zeros(mesh.points.shape, dtype=bool)
    held[mesh.boundary_nodes("posterior")] = True
    return held


def equilibrium(
    mesh: TetMesh,
    effects: tuple[Effect, ...],
    *,
    loads: tuple[Effect, ...] = (),
    start: np.ndarray | None = None,
    held: np.ndarray | None = None,
    settings: Settings | None = None,
) -> Equilibrium:
    """The equilibrium of effects and loads on a mesh whose points are the reference configuration.

    start (n_node, 3): where to begin, and where the held degrees of freedom stay (default: the reference);
    held (n_node, 3) bool (default: all components of the nodes of `posterior`).
    Raises MechanicsError for an ill-posed problem, EquilibriumError when no verified equilibrium was reached.
    """
    held = held_nodes(mesh) if held is None and "posterior" in mesh.boundaries else held
    held = require_well_posed(mesh, held)
    with System.of(Potential(effects, loads), held) as system:
        return solve(system, mesh.points, start=start, settings=settings)


def solve(
    system: System,
    reference: np.ndarray,
    *,
    start: np.ndarray | None = None,
    settings: Settings | None = None,
) -> Equilibrium:
    """The equilibrium of a system already checked, with reference X (n_node, 3); see `equilibrium`."""
    began, solver = time.perf_counter(), system.solver
    before = solver.factorisations, solver.iterations
    settings = settings or Settings()
    history: list[Iteration] = []
    x = _under_full_load(system, reference, start, settings, history)
    state = _verified(system, x, settings, history)
    return replace(
        state,
        factorisations=solver.factorisations - before[0],
        cg_iterations=solver.iterations - before[1],
        seconds=time.perf_counter() - began,
    )


def _under_full_load(
    system: System,
    reference: np.ndarray,
    start: np.ndarray | None,
    settings: Settings,
    history: list[Iteration],
) -> np.ndarray:
    """x at load factor 1; steps are halved when they fail and doubled when they succeed."""
    x = reference if start is None else start
    reached, step = 0.0, 1 / settings.load_steps if start is None else 1.0
    while reached < 1.0:
        target = min(1.0, reached + step)
        try:
            x = converge(system.under(target), x, settings.newton, history)
            reached, step = target, 2 * step
        except StepFailed as failure:
            log.info("load factor %.3f failed: %s", target, failure)
            step = (target - reached) / 2
            if step < settings.smallest_step or not system.potential.loads:
                raise EquilibriumError(
                    f"no equilibrium beyond load factor {reached:.3f}: {failure}. {_ADVICE}",
                    history=tuple(history),
                    load_factor=reached,
                ) from failure
            if reached == 0.0:
                x = np.where(system.held, x, reference)
    return x


_ADVICE = (
    "The shape may have lost its stability: add skin, stiffen the tissue, "
    "let the chest wall carry it, or start from a neighbouring equilibrium"
)


def _verified(system: System, x: np.ndarray, settings: Settings, history: list[Iteration]) -> Equilibrium:
    """The result, or EquilibriumError when residual, J or stability does not hold at x."""
    residual = system.relative_residual(x)
    smallest_J = system.potential.smallest_J(x)
    stable = is_stable(system, x)
    if residual > settings.newton.tolerance or smallest_J <= 0 or not stable:
        raise EquilibriumError(
            f"the shape found is no verified equilibrium: residual {residual:.1e} (at most "
            f"{settings.newton.tolerance:g}), smallest J {smallest_J:.3f} (above 0), "
            f"{'stable' if stable else 'unstable'}. {_ADVICE}",
            history=tuple(history),
        )
    return Equilibrium(
        x,
        tuple(history),
        residual,
        smallest_J,
        stable,
        system.solver.stability,
        system.potential.energy(x),
        factorisations=0,
        cg_iterations=0,
        seconds=0.0,
    )
