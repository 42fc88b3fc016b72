"""Load control: from the reference to the full load, along equilibria that are stable.

The whole load is tried in one step. A step counts only if every tangent that Newton met was positive
definite: a step that passes an indefinite one may end on the other side of a wall, in a state that no body
loaded from rest reaches. It is given up there and then, and halved. Where a small step from a stable state
still meets an indefinite tangent, stability is lost; that is diagnosed, not passed over.
"""

import logging
from dataclasses import dataclass, field, replace

import numpy as np

from mammosim.core.errors import EquilibriumError
from mammosim.mechanics.newton import Iteration, NewtonSettings, StepFailed, System, converge, is_stable
from mammosim.mechanics.stability import advice, lowest_mode

log = logging.getLogger(__name__)

# Iterations that a small step over an indefinite tangent may take, to see what lies there.
_PATIENCE = 20
# Below this load factor steps do not become smaller any more.
_LEAST = 1 / 16


@dataclass(frozen=True)
class Settings:
    """How the loads are applied.

    load_steps: how many equal steps to begin with; smallest_step: relative to the load factor reached, then
    the solver gives up; it is also how closely a loss of stability is located.
    """

    newton: NewtonSettings = field(default_factory=NewtonSettings)
    load_steps: int = 1
    smallest_step: float = 1 / 64


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

        Raises EquilibriumError.
        """
        self.path, self.load_factors = [start], (0.0,)
        try:
            self.path.append(converge(self.system, start, self.settings.newton, self.history))
            self.load_factors = (1.0, 1.0)
        except StepFailed as failure:
            if not self.system.potential.loads:
                raise self._error(1.0, failure) from failure
            log.info("the start is dropped: %s", failure)
            self.from_rest(np.where(self.system.held, start, self.reference))

    def from_rest(self, x: np.ndarray) -> None:
        """Go to the full load from the shape x (n_node, 3) without load. Raises EquilibriumError."""
        self.path, self.load_factors = [x], (0.0,)
        newton = replace(self.settings.newton, projection=not self.system.potential.loads)
        step, failed = 1 / self.settings.load_steps, False
        while (reached := self.load_factors[-1]) < 1.0:
            target = min(1.0, reached + step)
            try:
                x = converge(self.system.under(target), self.path[-1], newton, self.history)
            except StepFailed as failure:
                log.info("load factor %.3f failed: %s", target, failure)
                step, failed = (target - reached) / 2, True
                if step < self._smallest or not self.system.potential.loads:
                    raise self._error(target, failure) from failure
            else:
                self.path.append(x)
                self.load_factors += (target,)
                step, failed = step if failed else 2 * step, False

    @property
    def _smallest(self) -> float:
        """The smallest step of the load factor from where it is."""
        return self.settings.smallest_step * max(self.load_factors[-1], _LEAST)

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
        except StepFailed as lost:
            return lost.x, ""
        if not is_stable(system, x):
            return x, ", from an equilibrium that is no minimum any more"
        moved = float(np.linalg.norm(x - self.path[-1], axis=1).max())
        return failure.x, f"; another stable shape is {moved:.0f} mm away"
