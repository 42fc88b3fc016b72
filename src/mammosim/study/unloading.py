"""Every method of unloading on bodies whose stress-free shape is known: error, round trip, cost."""

import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from mammosim.chain.outcome import CONVERGED, unsolved
from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import Body
from mammosim.mechanics.unloaded import DEFAULT, Unloaded, UnloadingSettings
from mammosim.mechanics.unloading import METHODS


@dataclass(frozen=True)
class Case:
    """A stress-free body (truth.points, mm), what it is made of, and where gravity (3,) points prone."""

    truth: TetMesh
    body: Body
    gravity: np.ndarray

    def in_position(self, gravity: np.ndarray) -> np.ndarray:
        """x (n_node, 3) under gravity. Raises EquilibriumError where there is no stable state."""
        return self.body.load(self.truth, gravity).points


def soft(tissues: Mapping[Label, Tissue], youngs_modulus_kpa: float) -> dict[Label, Tissue]:
    """The tissues with one modulus for fat and gland."""
    same = {
        label: replace(tissues[label], youngs_modulus_kpa=youngs_modulus_kpa)
        for label in (Label.ADIPOSE, Label.GLANDULAR)
    }
    return {**tissues, **same}


def rows(
    case: Case, *, methods: Iterable[str] = tuple(METHODS), settings: UnloadingSettings = DEFAULT
) -> list[dict[str, str | float]]:
    """One row per method: unload the prone shape with the right moduli, and compare with the truth.

    error_*_mm: of the skin's nodes against their true places; round_*_mm: of all nodes, loaded again from
    rest, against the prone shape; iterations: shapes loaded, or corrections of the inverse; factorisations:
    without the inverse's last one, which checks stability; seconds of processor, and forward_solves, the same
    over one prone solve. A method that fails is an outcome, also where the body itself has no stable prone or
    supine state.
    """
    # ASSUME: methods are compared on the truth's own mesh and law: what is left is the error of the method.
    try:
        case.in_position(case.gravity)  # compiled code is loaded now, and not timed
        began = time.process_time()
        prone = case.in_position(case.gravity)
        forward = time.process_time() - began
    except MechanicsError as error:
        return [_row_without_numbers(name, unsolved(error, "no stable prone state")) for name in methods]
    measured, start = case.truth.moved_to(prone), _mean(case, prone)
    return [_row(case, measured, name, start, settings, forward) for name in methods]


def _mean(case: Case, prone: np.ndarray) -> np.ndarray | str:
    """The mean of prone and supine, on one mesh the mean of each node; or why there is none."""
    # ASSUME: on the truth's mesh prone and supine nodes correspond, so their mean needs no morphing.
    try:
        return (prone + case.in_position(-case.gravity)) / 2
    except MechanicsError as error:
        return unsolved(error, "no stable supine state for the mean")


def _row(
    case: Case,
    measured: TetMesh,
    method: str,
    mean: np.ndarray | str,
    settings: UnloadingSettings,
    forward: float,
) -> dict[str, str | float]:
    begins_there = method == "mean_start"
    if begins_there and isinstance(mean, str):
        return _row_without_numbers(method, mean)
    start = mean if begins_there and isinstance(mean, np.ndarray) else None
    began = time.process_time()
    try:
        found = METHODS[method](measured, case.body, gravity=case.gravity, start=start, settings=settings)
    except MechanicsError as error:
        seconds = time.process_time() - began
        return _row_without_numbers(method, unsolved(error)) | _cost(seconds, forward)
    seconds = time.process_time() - began
    return {**_measures(case, measured, method, found), **_cost(seconds, forward)}


def _measures(case: Case, measured: TetMesh, method: str, found: Unloaded) -> dict[str, str | float]:
    skin = case.truth.boundary_nodes("skin")
    error = np.linalg.norm(found.points - case.truth.points, axis=1)[skin]
    away, outcome = _round_trip(case, measured, found.points)
    return {
        "method": method,
        "outcome": outcome,
        "error_mean_mm": float(error.mean()),
        "error_p95_mm": float(np.percentile(error, 95)),
        "error_max_mm": float(error.max()),
        "round_mean_mm": float(away.mean()),
        "round_max_mm": float(away.max()),
        "iterations": float(len(found.history)),
        "factorisations": float(sum(step.factorisations for step in found.history)),
    }


def _round_trip(case: Case, measured: TetMesh, X: np.ndarray) -> tuple[np.ndarray, str]:
    """Distance (n_node,) mm of X, loaded from rest, from the measured shape; NaN where it has no state."""
    try:
        again = replace(case, truth=measured.moved_to(X)).in_position(case.gravity)
    except MechanicsError as error:
        return np.full(len(X), np.nan), unsolved(error, "the shape that was found cannot be loaded again")
    return np.linalg.norm(again - measured.points, axis=1), CONVERGED


def _cost(seconds: float, forward: float) -> dict[str, float]:
    return {"seconds": seconds, "forward_solves": seconds / forward}


def _row_without_numbers(method: str, outcome: str) -> dict[str, str | float]:
    """A row without numbers."""
    numbers = ("error_mean", "error_p95", "error_max", "round_mean", "round_max")
    counts = ("iterations", "factorisations", "seconds", "forward_solves")
    return {
        "method": method,
        "outcome": outcome,
        **dict.fromkeys((f"{name}_mm" for name in numbers), np.nan),
        **dict.fromkeys(counts, np.nan),
    }
