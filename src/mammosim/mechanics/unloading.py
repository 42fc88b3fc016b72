"""The ways from a shape measured under gravity to the stress-free one, all with the interface of Method."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.mechanics.analysis import shared_analysis
from mammosim.mechanics.body import Body
from mammosim.mechanics.fixed_point import (
    Anderson,
    Correction,
    FixedPoint,
    Nodal,
    PulledBack,
    Steps,
    SurfaceDriven,
    damped,
    held_as_measured,
)
from mammosim.mechanics.inverse import InverseSettings
from mammosim.mechanics.inverse import inverse as newton_inverse
from mammosim.mechanics.unloaded import DEFAULT, Method, Unloaded, UnloadingSettings, UnloadingStep


def reverse_gravity(
    measured: TetMesh,
    body: Body,
    *,
    gravity: np.ndarray,
    start: np.ndarray | None = None,
    settings: UnloadingSettings = DEFAULT,
) -> Unloaded:
    """The measured shape, taken as stress-free, under the opposite gravity; see Method.

    Right for small strain only: kept to be compared with. Nothing is iterated, nor loaded again: the one row
    of the history has no distances.
    """
    # ASSUME: reverse gravity takes the measured shape as free of stress, which is wrong for large strain.
    state = body.load(measured, -np.asarray(gravity), start=start)
    step = UnloadingStep(0, math.nan, math.nan, 1.0, state.factorisations, state.seconds)
    return Unloaded(state.points, (step,))


@dataclass(frozen=True)
class Iterated:
    """A method that iterates: what it does about the distance, and how far it goes; see Method.

    Raises MechanicsError without a start where it needs one.
    """

    correction: Correction
    steps: Steps = damped
    needs_start: str = ""

    @shared_analysis()
    def __call__(
        self,
        measured: TetMesh,
        body: Body,
        *,
        gravity: np.ndarray,
        start: np.ndarray | None = None,
        settings: UnloadingSettings = DEFAULT,
    ) -> Unloaded:
        """The shape X that gravity brings to the measured one."""
        if start is None and self.needs_start:
            raise MechanicsError(self.needs_start)
        return FixedPoint(measured, body, gravity, self.correction, self.steps, settings).from_start(start)


# Carter 2009, Eiben 2014, Mira 2018, and Eiben's by Anderson's acceleration.
fixed_point = Iterated(Nodal())
pull_back = Iterated(PulledBack())
mean_start = Iterated(
    SurfaceDriven(),
    needs_start="mean_start begins at the mean of the prone and the supine shape of the same mesh: give it "
    "as start, or take a method that begins at the measured shape",
)
anderson = Iterated(PulledBack(), Anderson())


def inverse(
    measured: TetMesh,
    body: Body,
    *,
    gravity: np.ndarray,
    start: np.ndarray | None = None,
    settings: UnloadingSettings = DEFAULT,
) -> Unloaded:
    """The inverse formulation by Newton's method, see mechanics.inverse and Method.

    It ends by its forces, whose tolerance leaves far less than tolerance_mm; the distances of its history are
    those of each correction, reverse gravity's first.
    """
    first = None if start is None else held_as_measured(start, measured)
    newton = InverseSettings(max_iterations=settings.max_iterations)
    return newton_inverse(measured, body, gravity=gravity, start=first, settings=newton)


METHODS: Mapping[str, Method] = MappingProxyType(
    {
        "reverse_gravity": reverse_gravity,
        "fixed_point": fixed_point,
        "pull_back": pull_back,
        "mean_start": mean_start,
        "inverse": inverse,
        "anderson": anderson,
    }
)
