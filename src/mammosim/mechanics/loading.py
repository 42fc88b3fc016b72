"""Load control: from the reference to the full load, along equilibria that are stable.

The whole load is tried in one step. A step counts only if every tangent that Newton met was positive
definite: a step that passes an indefinite one may end on the other side of a wall, in a state that no body
loaded from rest reaches. It is given up there and then, and halved. Where a small step from a stable state
still meets an indefinite tangent, stability is lost; that is diagnosed, not passed over.

How a body loses its stability: the lowest mode of its tangent, and what would help.
"""

import logging
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.sparse.linalg import LinearOperator, aslinearoperator

from mammosim.core.errors import EquilibriumError, OutOfBudget
from mammosim.core.rng import generator
from mammosim.mechanics.budget import Budget, BudgetSpent
from mammosim.mechanics.effects import RigidContact, SkinMembrane
from mammosim.mechanics.newton import Iteration, NewtonSettings, StepFailed, System, converge, is_stable
from mammosim.mechanics.potential import Potential

_MAX_STEPS = 60
_ACCURACY = 1e-3
# A mode in which fewer than this part of the nodes takes part is a local fold.
LOCAL = 0.15


@dataclass(frozen=True)
class Mode:
    """The lowest mode of a tangent: eigenvalue w [mN/mm] and v (n_node, 3) of K v = w v, largest |v_a| 1."""

    eigenvalue: float
    shape: np.ndarray

    @property
    def participation(self) -> float:
        """The part of the nodes that moves: (sum |v|^2)^2 / sum |v|^4 / n_node."""
        square = np.sum(self.shape**2, axis=1)
        return float(square.sum() ** 2 / np.sum(square**2) / len(square))

    def words(self, points: np.ndarray) -> str:
        """Where the tissue moves most, by its reference points (n_node, 3), and in which direction."""
        most = int(np.argmax(np.linalg.norm(self.shape, axis=1)))
        doing = "folds locally" if self.participation < LOCAL else "gives way as a whole"
        where, along = _listed(points[most], 0), _listed(self.shape[most], 2)
        return f"the tissue {doing}, most at {where} mm of the reference, along {along}"


def lowest_mode(system: System, x: np.ndarray, stable: np.ndarray) -> Mode:
    """The lowest mode at a shape x (n_node, 3), found from the tangent at a stable one.

    Locally optimal conjugate gradients (Knyazev 2001): the Rayleigh quotient is minimised over the last
    vector, its preconditioned residual and the last change.
    """
    free, solver = system.rows.free, system.solver
    A = _free_operator(system, x)
    solver.is_definite(system.potential.tangent(stable, system.pattern))
    v = solver.preconditioned(generator("lowest mode").standard_normal(len(free)))
    directions, last = [v], np.inf
    for _ in range(_MAX_STEPS):
        Q, _ = np.linalg.qr(np.column_stack(directions))
        values, vectors = np.linalg.eigh(Q.T @ (A @ Q))
        following, w = Q @ vectors[:, 0], float(values[0])
        if abs(w - last) <= _ACCURACY * abs(w):
            break
        change = following - v * (v @ following) / (v @ v)
        v, last = following, w
        directions = [v, solver.preconditioned(A @ v - w * v), change]
    shape = system.spread(following)
    most = shape[np.argmax(np.linalg.norm(shape, axis=1))]
    return Mode(w, shape / np.linalg.norm(most))


def _free_operator(system: System, x: np.ndarray) -> LinearOperator:
    """K + B^T M^-1 B on the free degrees of freedom, its parts kept apart."""
    free, tangent = system.rows.free, system.potential.tangent(x, system.pattern)
    K = replace(tangent, constraint=None).to_csr()[free][:, free]
    if tangent.constraint is None:
        return aslinearoperator(K)
    B, factors = tangent.constraint.B.tocsc()[:, free].tocsr(), tangent.constraint.factors
    return LinearOperator(K.shape, matvec=lambda v: K @ v + B.T @ factors.solve(B @ v), dtype=float)


def advice(system: System, points: np.ndarray, load_factor: float) -> str:
    """What would keep the body, with reference points (n_node, 3), stable beyond this part of its loads."""
    effects, helps = system.potential.effects, []
    if any(isinstance(effect, SkinMembrane) for effect in effects):
        helps.append("make the skin stiffer or thicker")
    else:
        helps.append("add skin, which holds soft tissue")
    in_contact = any(isinstance(effect, RigidContact) for effect in effects)
    if not in_contact and not _hangs(system, points):
        helps.append("let the chest wall carry what is pressed towards it (chest_wall_contact)")
    if load_factor > 0:
        helps.append(f"make all stiffnesses {1.05 / load_factor:.2g} times larger, which is certain to help")
    return "; or ".join(helps)


def _hangs(system: System, points: np.ndarray) -> bool:
    """Whether the loads pull away from the held nodes, within 45 degrees."""
    held = system.held.any(axis=1)
    away = points[~held].mean(axis=0) - points[held].mean(axis=0)
    pull = -Potential(system.potential.loads).gradient(points).sum(axis=0)
    return bool(pull @ away > np.sqrt(0.5) * np.linalg.norm(pull) * np.linalg.norm(away))


def _listed(vector: np.ndarray, digits: int) -> str:
    return "(" + ", ".join(f"{value + 0.0:.{digits}f}" for value in vector) + ")"


log = logging.getLogger(__name__)

# Iterations that a small step over an indefinite tangent may take, to see what lies there.
_PATIENCE = 20
# Below this load factor steps do not become smaller any more.
_LEAST = 1 / 16


@dataclass(frozen=True)
class Settings:
    """How the loads are applied.

    load_steps: how many equal steps to begin with; smallest_step: relative to the load factor reached, then
    the solver gives up; it is also how closely a loss of stability is located; budget: of the whole solve.
    """

    newton: NewtonSettings = field(default_factory=NewtonSettings)
    load_steps: int = 1
    smallest_step: float = 1 / 64
    budget: Budget = field(default_factory=Budget)


@dataclass
class Loading:
    """A system on its way to the full load: the shapes it passed, and the iterations it took."""

    system: System
    reference: np.ndarray
    settings: Settings
    history: list[Iteration] = field(default_factory=list)
    path: list[np.ndarray] = field(default_factory=list)
    load_factors: tuple[float, ...] = ()

    def from_start(self, start: np.ndarray) -> None:
        """Go to the full load from a neighbouring shape, or from the reference where that does not succeed.

        Raises EquilibriumError, and OutOfBudget.
        """
        self.path, self.load_factors = [start], (0.0,)
        try:
            self.path.append(converge(self.system, start, self.settings.newton, self.history))
            self.load_factors = (1.0, 1.0)
        except BudgetSpent as spent:
            raise self._out_of_budget(spent) from spent
        except StepFailed as failure:
            if not self.system.potential.loads:
                raise self._error(1.0, failure) from failure
            log.info("the start is dropped: %s", failure)
            self.from_rest(np.where(self.system.held, start, self.reference))

    def from_rest(self, x: np.ndarray) -> None:
        """Go to the full load from the shape x (n_node, 3) without load.

        Raises EquilibriumError, and OutOfBudget.
        """
        self.path, self.load_factors = [x], (0.0,)
        newton = replace(self.settings.newton, projection=not self.system.potential.loads)
        step, failed = 1 / self.settings.load_steps, False
        while (reached := self.load_factors[-1]) < 1.0:
            target = min(1.0, reached + step)
            try:
                x = converge(self.system.under(target), self.path[-1], newton, self.history)
            except BudgetSpent as spent:
                raise self._out_of_budget(spent) from spent
            except StepFailed as failure:
                log.info("load factor %.3f failed: %s", target, failure)
                step, failed = (target - reached) / 2, True
                if step < self._smallest or not self.system.potential.loads:
                    raise self._error(target, failure) from failure
            else:
                self.system.spending.succeed()
                self.path.append(x)
                self.load_factors += (target,)
                step, failed = step if failed else 2 * step, False

    @property
    def _smallest(self) -> float:
        """The smallest step of the load factor from where it is."""
        return self.settings.smallest_step * max(self.load_factors[-1], _LEAST)

    def _out_of_budget(self, spent: BudgetSpent) -> OutOfBudget:
        reached = self.load_factors[-1]
        return OutOfBudget(
            f"{spent}; the last equilibrium is that of load factor {reached:.3f}. To get further, "
            f"{advice(self.system, self.reference, reached)}; or raise Settings.budget",
            history=tuple(self.history),
            load_factor=reached,
            best=spent.x,
        )

    def _error(self, target: float, failure: StepFailed) -> EquilibriumError:
        """The diagnosis of a failure to go on to a load factor."""
        reached, mode = self.load_factors[-1], None
        helps = advice(self.system, self.reference, reached)
        if failure.indefinite:
            x, found = self._beyond(target, failure)
            mode = lowest_mode(self.system.under(target), x, self.path[-1])
            message = (
                f"stability is lost between load factors {reached:.3f} and {target:.3f}: "
                f"{mode.words(self.reference)}{found}. To keep it, {helps}"
            )
        else:
            message = (
                f"no equilibrium was found beyond load factor {reached:.3f}: {failure}. The shape may have "
                f"lost its stability: {helps}; or start from a neighbouring equilibrium"
            )
        return EquilibriumError(
            message,
            history=tuple(self.history),
            load_factor=reached,
            mode=None if mode is None else mode.shape,
        )

    def _beyond(self, target: float, failure: StepFailed) -> tuple[np.ndarray, str]:
        """An unstable shape beyond a loss of stability, near a saddle if there is one; what lies there."""
        system = self.system.under(target)
        newton = replace(self.settings.newton, max_iterations=_PATIENCE)
        try:
            x = converge(system, self.path[-1], newton, self.history)
        except (StepFailed, BudgetSpent) as lost:
            return lost.x, ""
        if not is_stable(system, x):
            return x, ", from an equilibrium that is no minimum any more"
        moved = float(np.linalg.norm(x - self.path[-1], axis=1).max())
        return failure.x, f"; another stable shape is {moved:.0f} mm away"
