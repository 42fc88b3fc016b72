"""Equilibrium: a verified minimum of the potential energy of a body.

Newton's method on the free degrees of freedom, with the pressure of the bulk predicted at the integration
points (see NeoHookean.predicted). Steps are cut so that J stays positive at every integration point; energy
may rise for a few steps (a watchdog, Chamberlain et al. 1982), after which the solver returns to the best
shape and searches along the line for a lower energy. Load control, and what happens where stability is lost,
stand in mechanics.loading.
"""

import resource
import time
from dataclasses import dataclass, replace

import numpy as np

from mammosim.core.errors import EquilibriumError
from mammosim.core.mesh import TetMesh
from mammosim.mechanics.analysis import system_of
from mammosim.mechanics.budget import Spending
from mammosim.mechanics.effects.protocol import Effect
from mammosim.mechanics.loading import Loading, Settings
from mammosim.mechanics.newton import Iteration, System, is_stable
from mammosim.mechanics.potential import Potential, energy_imbalance
from mammosim.mechanics.reference import require_well_posed
from mammosim.mechanics.rigid_motions import require_held

__all__ = [
    "LARGEST_IMBALANCE",
    "Equilibrium",
    "Iteration",
    "Settings",
    "equilibrium",
    "held_nodes",
    "solve",
]

# Quadrature of the work follows contact and wrinkling to 1e-4; a gradient that is wrong leaves its own size.
LARGEST_IMBALANCE = 1e-2
_KIB_PER_MB = 1e6 / 1024


@dataclass(frozen=True)
class Equilibrium:
    """A verified state of equilibrium.

    points (n_node, 3) mm; history: one row per Newton iteration; residual: the free forces relative to the
    load; smallest_J at the integration points; positive_definite: the exact tangent is, so a stable minimum;
    stability: how that is known, by the `inertia` of its factors or by `Lanczos`, see mechanics.solvers;
    energy uJ; energy_imbalance: of the work of the inner forces along the path against the stored energy,
    relative, see mechanics.potential; load_factors: of the states on that path, which begins at the reference
    or at a start; factorisations (of the coarse level under conjugate gradients); cg_iterations; seconds of
    wall time; memory_mb: the largest of the process so far; solver_mb: of it, for factors.
    """

    points: np.ndarray
    history: tuple[Iteration, ...]
    residual: float
    smallest_J: float
    positive_definite: bool
    stability: str
    energy: float
    energy_imbalance: float
    load_factors: tuple[float, ...]
    factorisations: int
    cg_iterations: int
    seconds: float
    memory_mb: float
    solver_mb: float


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
    with system_of(Potential(effects, loads), held) as system:
        require_held(system, effects, mesh.points)
        return solve(system, mesh.points, start=start, settings=settings)


def solve(
    system: System,
    reference: np.ndarray,
    *,
    start: np.ndarray | None = None,
    settings: Settings | None = None,
) -> Equilibrium:
    """The equilibrium of a system already checked, with reference X (n_node, 3); see `equilibrium`."""
    settings = settings or Settings()
    began, solver = time.perf_counter(), system.solver
    before = solver.factorisations, solver.iterations
    system = replace(system, spending=Spending(settings.budget))
    loading = Loading(system, reference, settings)
    if start is None:
        loading.from_rest(reference)
    else:
        loading.from_start(start)
    verified = _verified(loading)
    return Equilibrium(
        points=loading.path[-1],
        history=tuple(loading.history),
        positive_definite=True,
        stability=solver.stability,
        energy=system.potential.energy(loading.path[-1]),
        load_factors=loading.load_factors,
        factorisations=solver.factorisations - before[0],
        cg_iterations=solver.iterations - before[1],
        seconds=time.perf_counter() - began,
        memory_mb=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / _KIB_PER_MB,
        solver_mb=solver.memory_mb,
        **verified,
    )


def _verified(loading: Loading) -> dict[str, float]:
    """Residual, smallest J and energy imbalance of the last shape, or EquilibriumError where one is wrong."""
    system, x, tolerance = loading.system, loading.path[-1], loading.settings.newton.tolerance
    residual = system.relative_residual(x)
    smallest_J = system.potential.smallest_J(x)
    imbalance = energy_imbalance(system.potential, loading.path)
    stable = is_stable(system, x)
    balanced = system.is_balanced(x, residual, tolerance)
    if not balanced or smallest_J <= 0 or not stable or imbalance > LARGEST_IMBALANCE:
        raise EquilibriumError(
            f"the shape found is no verified equilibrium: residual {residual:.1e} (at most {tolerance:g}), "
            f"smallest J {smallest_J:.3f} (above 0), energy imbalance {imbalance:.1e} (at most "
            f"{LARGEST_IMBALANCE:g}), {'stable' if stable else 'unstable: stability was lost on the way'}; "
            "apply the load in more steps, or start from a neighbouring equilibrium",
            history=tuple(loading.history),
        )
    return {"residual": residual, "smallest_J": smallest_J, "energy_imbalance": imbalance}
