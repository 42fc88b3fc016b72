"""The stress-free shape of a body that was measured under gravity."""

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mammosim.core.errors import EquilibriumError, MechanicsError
from mammosim.core.mesh import TetMesh
from mammosim.mechanics.analysis import shared_analysis
from mammosim.mechanics.elastic import carried
from mammosim.mechanics.equilibrium import Equilibrium
from mammosim.mechanics.reference import smallest_jacobians

log = logging.getLogger(__name__)

# load(stress-free mesh, gravity (3,), start (n_node, 3) or None): its equilibrium under gravity.
Load = Callable[[TetMesh, np.ndarray, np.ndarray | None], Equilibrium]


class UnloadingStep(NamedTuple):
    """One iteration: distance of the reloaded to the measured skin nodes, and what it took."""

    iteration: int
    mean_mm: float
    max_mm: float
    damping: float
    factorisations: int
    seconds: float


@dataclass(frozen=True)
class Unloaded:
    """points (n_node, 3) mm of the stress-free shape; history: one row per iteration."""

    points: np.ndarray
    history: tuple[UnloadingStep, ...] = ()


@dataclass(frozen=True)
class FixedPointSettings:
    """tolerance_mm: of the skin's mean distance; smallest_damping: of a correction before it is refused."""

    tolerance_mm: float = 0.05
    max_iterations: int = 20
    smallest_damping: float = 1 / 16


@dataclass(frozen=True)
class _Guess:
    """A stress-free shape X, its loaded shape x, and the skin's distance vectors from the measured shape."""

    mesh: TetMesh
    x: np.ndarray
    difference: np.ndarray
    factorisations: int

    @property
    def mean_mm(self) -> float:
        return float(np.linalg.norm(self.difference, axis=1).mean())

    @property
    def max_mm(self) -> float:
        return float(np.linalg.norm(self.difference, axis=1).max())


def reverse_gravity(measured: TetMesh, load: Load, *, gravity: np.ndarray) -> Unloaded:
    """The measured shape, taken as stress-free, under the opposite gravity (3,).

    Right for small strain only: kept to be compared with. Raises EquilibriumError where it has no stable
    state.
    """
    # ASSUME: reverse gravity takes the measured shape as free of stress, which is wrong for large strain.
    return Unloaded(load(measured, -np.asarray(gravity), None).points)


@shared_analysis()
def fixed_point(
    measured: TetMesh,
    load: Load,
    *,
    gravity: np.ndarray,
    start: np.ndarray | None = None,
    settings: FixedPointSettings | None = None,
) -> Unloaded:
    """The shape X that gravity (3,) brings to the measured skin: surface-driven fixed point (Carter 2009).

    X <- X + u, where u is minus the difference between reloaded and measured at the skin nodes, zero at the
    posterior ones, and carried to the others elastically. start (n_node, 3): first guess, default the
    measured shape. Raises MechanicsError when the residual does not fall any more, or not below the tolerance
    in time.
    """
    settings = settings or FixedPointSettings()
    began = time.perf_counter()
    guess = _loaded(measured, measured.points if start is None else start, load, gravity, None)
    history = [_step(0, guess, 1.0, began)]
    damping = 1.0
    while guess.mean_mm > settings.tolerance_mm:
        if len(history) > settings.max_iterations:
            raise MechanicsError(
                f"{settings.max_iterations} fixed-point iterations left a mean of {guess.mean_mm:.3f} mm "
                f"(asked {settings.tolerance_mm:g} mm); allow more iterations or a larger tolerance_mm"
            )
        began = time.perf_counter()
        guess, damping = _corrected(measured, guess, load, gravity, settings, damping)
        history.append(_step(len(history), guess, damping, began))
        damping = min(1.0, 2 * damping)
    return Unloaded(guess.mesh.points, tuple(history))


def _step(iteration: int, guess: _Guess, damping: float, began: float) -> UnloadingStep:
    step = UnloadingStep(
        iteration, guess.mean_mm, guess.max_mm, damping, guess.factorisations, time.perf_counter() - began
    )
    log.info("fixed point %d: mean %.3f mm, max %.3f mm", iteration, guess.mean_mm, guess.max_mm)
    return step


def _loaded(
    measured: TetMesh, X: np.ndarray, load: Load, gravity: np.ndarray, start: np.ndarray | None
) -> _Guess:
    mesh = measured.moved_to(X)
    state = load(mesh, np.asarray(gravity), start)
    skin = measured.boundary_nodes("skin")
    return _Guess(mesh, state.points, (state.points - measured.points)[skin], state.factorisations)


def _corrected(
    measured: TetMesh,
    guess: _Guess,
    load: Load,
    gravity: np.ndarray,
    settings: FixedPointSettings,
    damping: float,
) -> tuple[_Guess, float]:
    """The next guess and its damping, halved until the mean residual falls."""
    u = _correction(measured, guess)
    reason = ""
    while damping >= settings.smallest_damping:
        X = guess.mesh.points + damping * u
        if smallest_jacobians(X, measured.cells).min() <= 0:
            reason = "the correction inverts cells"
        else:
            try:
                trial = _loaded(measured, X, load, gravity, guess.x + damping * u)
            except EquilibriumError as error:
                reason = f"the corrected shape has no equilibrium ({error})"
            else:
                if trial.mean_mm < guess.mean_mm:
                    return trial, damping
                reason = f"the residual rose to {trial.mean_mm:.3f} mm"
        damping /= 2
    raise MechanicsError(
        f"the fixed point diverges at a mean of {guess.mean_mm:.3f} mm: {reason}, even when "
        f"damped to {2 * damping:.3f}; the tissue may be too soft for the measured shape: "
        "raise its modulus, or add skin"
    )


def _correction(measured: TetMesh, guess: _Guess) -> np.ndarray:
    """u (n_node, 3): minus the difference at the skin, zero where held, carried elastically in between."""
    skin, held = measured.boundary_nodes("skin"), measured.boundary_nodes("posterior")
    u = np.zeros_like(measured.points)
    u[skin] = -guess.difference
    u[held] = 0.0
    prescribed = np.zeros(len(u), dtype=bool)
    prescribed[skin] = prescribed[held] = True
    return carried(guess.mesh, u, prescribed)
