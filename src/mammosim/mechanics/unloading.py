"""The ways from a shape measured under gravity to the stress-free one, all with the interface of Method."""

import math
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from mammosim.core.errors import MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.mechanics.acceleration import Anderson
from mammosim.mechanics.analysis import shared_analysis
from mammosim.mechanics.body import Body
from mammosim.mechanics.corrections import Nodal, PulledBack, SurfaceDriven
from mammosim.mechanics.fixed_point import FixedPoint, held_as_measured
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


@shared_analysis()
def fixed_point(
    measured: TetMesh,
    body: Body,
    *,
    gravity: np.ndarray,
    start: np.ndarray | None = None,
    settings: UnloadingSettings = DEFAULT,
) -> Unloaded:
    """X <- X - (x(X) - measured) at all nodes (Carter 2009); see Method."""
    return FixedPoint(measured, body, gravity, Nodal(), settings=settings).from_start(start)


@shared_analysis()
def pull_back(
    measured: TetMesh,
    body: Body,
    *,
    gravity: np.ndarray,
    start: np.ndarray | None = None,
    settings: UnloadingSettings = DEFAULT,
) -> Unloaded:
    """X <- X - F^-1 (x(X) - measured) at all nodes (Eiben 2014); see Method."""
    return FixedPoint(measured, body, gravity, PulledBack(), settings=settings).from_start(start)


@shared_analysis()
def mean_start(
    measured: TetMesh,
    body: Body,
    *,
    gravity: np.ndarray,
    start: np.ndarray | None = None,
    settings: UnloadingSettings = DEFAULT,
) -> Unloaded:
    """From the mean of prone and supine, corrected by the skin alone (the report's own); see Method.

    start is that mean. Raises MechanicsError without one.
    """
    if start is None:
        raise MechanicsError(
            "mean_start begins at the mean of the prone and the supine shape of the same mesh: give it as "
            "start, or take a method that begins at the measured shape"
        )
    return FixedPoint(measured, body, gravity, SurfaceDriven(), settings=settings).from_start(start)


@shared_analysis()
def anderson(
    measured: TetMesh,
    body: Body,
    *,
    gravity: np.ndarray,
    start: np.ndarray | None = None,
    settings: UnloadingSettings = DEFAULT,
) -> Unloaded:
    """The fixed point with the difference pulled back, by Anderson's acceleration; see Method."""
    return FixedPoint(measured, body, gravity, PulledBack(), Anderson(), settings).from_start(start)


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
