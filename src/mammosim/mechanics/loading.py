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

# A small step over an indefinite tangent may take so many iterations, and go so much farther than the last.
_PATIENCE = 20
_FARTHEST = 4.0


@dataclass(frozen=True)
class Settings:
    """How the loads are applied.

    load_steps: how many equal steps to begin with; smallest_step: of the load factor, then the solver gives
    up; it is also how closely a loss of stability is located.
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
        step, failed = 1 / self.settings.load_steps, False
        while (reached := self.load_factors[-1]) < 1.0:
            target = min(1.0, reached + step)
            try:
                x = self._small_step(target) if step < 2 * self.settings.smallest_step else self._step(target)
            except StepFailed as failure:
                log.info("load factor %.3f failed: %s", target, failure)
                step, failed = (target - reached) / 2, True
                if step < self.settings.smallest_step or not self.system.potential.loads:
                    raise self._error(target, failure) from failure
            else:
                self.path.append(x)
                self.load_factors += (target,)
                step, failed = step if failed else 2 * step, False

    def _step(self, target: float) -> np.ndarray:
        """x under a load factor, if all tangents on the way are definite."""
        newton = replace(self.settings.newton, projection=not self.system.potential.loads)
        return converge(self.system.under(target), self.path[-1], newton, self.history)

    def _small_step(self, target: float) -> np.ndarray:
        """x under a load factor a little higher, over indefinite tangents too if it is stable and near."""
        try:
            return self._step(target)
        except StepFailed as failure:
            if not failure.indefinite:
                raise
        last = self.path[-1]
        system = self.system.under(target)
        newton = replace(self.settings.newton, max_iterations=_PATIENCE)
        try:
            x = converge(system, last, newton, self.history)
        except StepFailed as failure:
            raise StepFailed(str(failure), failure.x, indefinite=True) from failure
        if not is_stable(system, x):
            raise StepFailed("the equilibrium found is a saddle", x, indefinite=True)
        moved = float(np.abs(x - last).max())
        if moved > _FARTHEST * self._rate() * (target - self.load_factors[-1]):
            raise StepFailed(f"the shape jumps by {moved:.1f} mm", last, indefinite=True)
        return x

    def _rate(self) -> float:
        """How far the fastest node moved per load factor in the last step, mm."""
        if len(self.path) == 1:
            return np.inf
        before, after = self.load_factors[-2:]
        return float(np.abs(self.path[-1] - self.path[-2]).max()) / (after - before)

    def _error(self, target: float, failure: StepFailed) -> EquilibriumError:
        """The diagnosis of a failure to go on to a load factor."""
        reached = self.load_factors[-1]
        helps = advice(self.system.potential, reached)
        if not failure.indefinite:
            return EquilibriumError(
                f"no equilibrium was found beyond load factor {reached:.3f}: {failure}. The shape may have "
                f"lost its stability: {helps}; or start from a neighbouring equilibrium",
                history=tuple(self.history),
                load_factor=reached,
            )
        mode = lowest_mode(self.system.under(target), failure.x, self.path[-1])
        return EquilibriumError(
            f"stability is lost between load factors {reached:.3f} and {target:.3f} ({failure}): "
            f"{mode.words(self.reference)}. To keep it, {helps}",
            history=tuple(self.history),
            load_factor=reached,
            mode=mode.shape,
        )
