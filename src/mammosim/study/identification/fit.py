"""Gauss-Newton for identification.problem, with errors estimated from the residuals; and a grid of moduli."""

import logging
import time
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd

from mammosim.chain.outcome import CONVERGED, unsolved
from mammosim.core.errors import EquilibriumError, MechanicsError
from mammosim.core.progress import progress
from mammosim.mechanics.analysis import shared_analysis
from mammosim.study.identification.moduli import KEYS
from mammosim.study.identification.problem import MECHANICAL, Problem, Sensitivities, State
from mammosim.study.identification.settings import Errors, FitSettings, Grid

log = logging.getLogger(__name__)


class FitStep(NamedTuple):
    """One iteration: Phi, root mean squares of what is left of skin and markers, and what it took."""

    iteration: int
    objective: float
    skin_rms_mm: float
    marker_rms_mm: float
    step: float
    seconds: float


@dataclass(frozen=True)
class Fit:
    """The state of least Phi, the covariance (15, 15) of theta, the standard errors that the data have.

    The covariance is that of the posterior, and the last step's square, by which the state may be off.
    """

    state: State
    covariance: np.ndarray
    errors: Errors
    history: tuple[FitStep, ...]
    seconds: float


@shared_analysis()
def fitted(problem: Problem, *, start: np.ndarray | None = None, settings: FitSettings | None = None) -> Fit:
    """The moduli that explain a pair best; start (15,): theta to begin with, default the prior's mean.

    Raises EquilibriumError when the body has no verified equilibrium at the start, MechanicsError when the
    steps do not come to an end, or lower Phi no more while they are long.
    """
    began, settings = time.perf_counter(), settings or FitSettings()
    state = problem.predicted(problem.prior.mean if start is None else start)
    history: list[FitStep] = []
    for iteration in range(settings.max_iterations):
        clock = time.perf_counter()
        if iteration <= settings.settled:
            errors = data_errors(problem, state, settings.errors)
        slopes = problem.sensitivities(state)
        step, covariance = _gauss_newton(problem, state, slopes, errors)
        relative = float(np.max(np.abs(step) / np.sqrt(np.diag(covariance))))
        objective = _objective(problem, state, errors)
        row = FitStep(iteration, objective, *left_over(problem, state), relative, time.perf_counter() - clock)
        history.append(row)
        log.info("fit %d: skin %.3f mm, markers %.2f mm, step %.2f sd", *row[:1], *row[2:5])
        better = None
        if relative > settings.tolerance:
            better = _improved(problem, state, slopes, step, errors, settings)
        if better is None:
            _require_short(relative, objective, settings)
            verified, seconds = problem.from_rest(state), time.perf_counter() - began
            return Fit(verified, covariance + np.outer(step, step), errors, tuple(history), seconds)
        state = better
    raise MechanicsError(
        f"{settings.max_iterations} iterations left a step of {relative:.2g} standard deviations; "
        "allow more, or begin from the best point of the grid"
    )


def _require_short(relative: float, objective: float, settings: FitSettings) -> None:
    """Raise MechanicsError when a step that lowers Phi no more is long, in standard deviations."""
    if relative > max(settings.stalled, settings.tolerance):
        raise MechanicsError(
            f"no step lowers what is left of the data below Phi = {objective:.4g}, and the last one tried is "
            f"{relative:.2g} standard deviations long; see the diagnosis of the pair, or begin from the best "
            "point of the grid"
        )


def data_errors(problem: Problem, state: State, least: Errors) -> Errors:
    """The standard errors that explain what is left, but not less than `least`."""
    skin, marker = left_over(problem, state)
    return Errors(max(skin, least.skin_mm), max(least.marker_mm, marker))


def left_over(problem: Problem, state: State) -> tuple[float, float]:
    """What is left of the data, root mean squares in mm: of the skin by news, of markers' coordinates.

    NaN where there are no markers.
    """
    r, m = problem.residual(state, Errors(1.0, 1.0)), 3 * len(problem.pair.shared)
    skin, markers = np.split(r, [len(r) - m])
    news = problem.news(state).sum()
    return float(np.sqrt(np.sum(skin**2) / news)), float(np.sqrt(np.mean(markers**2))) if m else float("nan")


def _objective(problem: Problem, state: State, errors: Errors) -> float:
    """Phi."""
    prior = (state.theta - problem.prior.mean) / problem.prior.deviation
    return float(np.sum(problem.residual(state, errors) ** 2) + np.sum(prior**2)) / 2


def _gauss_newton(
    problem: Problem, state: State, slopes: Sensitivities, errors: Errors
) -> tuple[np.ndarray, np.ndarray]:
    """The step (15,) to the minimum of the linearised Phi, and the covariance (A^T A + D)^-1, D = 1 / s^2."""
    A, r = problem.slopes(state, slopes, errors), problem.residual(state, errors)
    D = problem.prior.deviation**-2
    covariance = np.linalg.inv(A.T @ A + np.diag(D))
    return -covariance @ (A.T @ r + D * (state.theta - problem.prior.mean)), covariance


def _improved(
    problem: Problem,
    state: State,
    slopes: Sensitivities,
    step: np.ndarray,
    errors: Errors,
    settings: FitSettings,
) -> State | None:
    """The state after the step, cut to the largest and halved until Phi falls; None where it does not."""
    step = step * min(1.0, settings.largest_step / np.abs(step[: MECHANICAL - 1]).max())
    before = _objective(problem, state, errors)
    for _ in range(settings.halvings + 1):
        try:
            trial = problem.predicted(state.theta + step, near=slopes.beside(state, step))
        except EquilibriumError as error:
            log.info("fit: the step is halved: %s", error)
        else:
            after = _objective(problem, trial, errors)
            if after < before:
                return trial
            log.info("fit: the step is halved, Phi would rise from %.1f to %.1f", before, after)
        step = step / 2
    return None


@shared_analysis()
def grid_table(problem: Problem, grid: Grid) -> pd.DataFrame:
    """A row per pair: breast_kpa (fat and gland, both sides), skin_kpa, skin_rms_mm, marker_rms_mm, outcome.

    Everything else as the prior's mean. A pair without equilibrium has no numbers but a reason.
    """
    pairs = [(breast, skin) for breast in grid.breast_kpa for skin in grid.skin_kpa]
    return pd.DataFrame(_grid_row(problem, *pair) for pair in progress(pairs, label="grid", total=len(pairs)))


def _grid_row(problem: Problem, breast: float, skin: float) -> dict[str, float | str]:
    theta = problem.prior.mean.copy()
    for j, (_, tissue) in enumerate(KEYS):
        if tissue != "muscle":
            theta[j] = np.log(skin if tissue == "skin" else breast)
    moduli: dict[str, float | str] = {"breast_kpa": breast, "skin_kpa": skin}
    try:
        state = problem.predicted(theta)
    except EquilibriumError as error:
        return moduli | {"skin_rms_mm": np.nan, "marker_rms_mm": np.nan, "outcome": unsolved(error)}
    skin_rms, marker_rms = left_over(problem, state)
    return moduli | {"skin_rms_mm": skin_rms, "marker_rms_mm": marker_rms, "outcome": CONVERGED}
