"""The stress-free shape of a body that is heavy for its moduli: other methods, and stiffer moduli, in order.

    E / (rho g L)    alone decides how a body hangs, so with all moduli times f as with the weight over f

The given methods are tried with the moduli as they are, then with all of them times each factor, the smallest
first. Where a method brought on only a part w of the weight (UnloadingError), factors below 1 / w are not
tried, in which it would be lost again, at the same cost. A shape counts when it was loaded again, from
rest, and came to the measured one.
"""

import logging
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from mammosim.core.errors import ConfigurationError, MammosimError, MechanicsError, UnloadingError
from mammosim.core.mesh import TetMesh
from mammosim.mechanics.body import Body
from mammosim.mechanics.unloaded import DEFAULT, UnloadingSettings
from mammosim.mechanics.unloading import METHODS

log = logging.getLogger(__name__)


class Attempt(NamedTuple):
    """One method with all moduli times a factor.

    largest_mm: distance of any node from the measured shape after loading again from rest, NaN where it was
    not; failure: why there is no shape, None where there is one.
    """

    method: str
    moduli_factor: float
    largest_mm: float = np.nan
    failure: MammosimError | None = None


@dataclass(frozen=True)
class Found:
    """points (n_node, 3) mm of the stress-free shape; attempts in their order, the last one its own."""

    points: np.ndarray
    attempts: tuple[Attempt, ...]


@dataclass
class Order:
    """What is tried: methods of METHODS with the moduli as given, then with all times each of the factors.

    attempts: what was tried before and not found, which is not tried again.
    """

    methods: Sequence[str]
    factors: Sequence[float] = ()
    settings: UnloadingSettings = DEFAULT
    attempts: list[Attempt] = field(default_factory=list)

    def unload(self, measured: TetMesh, body: Body, *, gravity: np.ndarray) -> Found:
        """The first shape that gravity, a unit vector (3,), brings to the measured one.

        Raises ConfigurationError for what no method can be asked, MechanicsError where no attempt found one.
        """
        for method, factor in self._steps():
            points, attempt = self._tried(method, factor, measured, body, gravity)
            self.attempts.append(attempt)
            if points is not None:
                return Found(points, tuple(self.attempts))
        raise self._nothing()

    def _steps(self) -> Iterator[tuple[str, float]]:
        """Methods and factors that are not known to fail, as long as they are asked for."""
        known = {(attempt.method, attempt.moduli_factor) for attempt in self.attempts}
        for factor in (1.0, *sorted(self.factors)):
            for method in self.methods:
                if (method, factor) not in known and factor >= least_factor(self.attempts):
                    yield method, factor

    def _tried(
        self, method: str, factor: float, measured: TetMesh, body: Body, gravity: np.ndarray
    ) -> tuple[np.ndarray | None, Attempt]:
        """The shape, None where there is none, and how it was come by."""
        log.info("%s with all moduli times %g", method, factor)
        # ASSUME: where its moduli cannot carry a body, all are too small by one factor, skin and muscle, too.
        stiff = body.stiffened(factor)
        try:
            points = METHODS[method](measured, stiff, gravity=gravity, settings=self.settings).points
            largest = reloaded_mm(points, measured, stiff, gravity)
        except ConfigurationError:
            raise
        except MammosimError as failure:
            log.info("%s failed: %s", method, failure)
            return None, Attempt(method, factor, failure=failure)
        if largest > self.settings.tolerance_mm:
            away = MechanicsError(
                f"loaded again it lies up to {largest:.3g} mm from the measured shape, more than "
                f"tolerance_mm = {self.settings.tolerance_mm:g}"
            )
            return None, Attempt(method, factor, largest, away)
        return points, Attempt(method, factor, largest)

    def _nothing(self) -> MechanicsError:
        last = self.attempts[-1]
        tried = ", ".join(
            f"{factor:g}" for factor in dict.fromkeys(each.moduli_factor for each in self.attempts)
        )
        return MechanicsError(
            f"no stress-free shape carries the weight, by {' or '.join(self.methods)} with all moduli times "
            f"{tried}{_beyond(self.attempts)}; check labels and mesh, add larger "
            f"moduli_factors, or give stiffer tissues. The last attempt, {last.method}: {last.failure}"
        )


def least_factor(attempts: Iterable[Attempt]) -> float:
    """The least factor that is known to carry the weight, by the part of it that a method brought on.

    It is 0 where none did, infinite where nothing of the weight was carried.
    """
    failures = [(each.moduli_factor, each.failure) for each in attempts]
    # A reference with moduli times f under w of the weight is one with f / w under the whole.
    known = [(f, why.load_factor) for f, why in failures if isinstance(why, UnloadingError)]
    return max((f / w if w else np.inf for f, w in known), default=0.0)


def _beyond(attempts: Sequence[Attempt]) -> str:
    """That more would be needed than any factor, where that is known."""
    least = least_factor(attempts)
    return f"; {least:.3g} would be needed" if attempts[-1].moduli_factor < least < np.inf else ""


def reloaded_mm(points: np.ndarray, measured: TetMesh, body: Body, gravity: np.ndarray) -> float:
    """The largest distance of a node from the measured shape after loading from rest; points (n_node, 3) mm.

    Raises EquilibriumError where it has no equilibrium.
    """
    state = body.load(measured.moved_to(points), np.asarray(gravity))
    return float(np.linalg.norm(state.points - measured.points, axis=1).max())
