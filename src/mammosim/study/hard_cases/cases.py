"""Hard cases: what is hard, what is expected, what happens, a row of the table for each.

A case converges within a stated error of its reference, or ends with an error for a stated reason; a crash is
an outcome, too. Nothing passes silently wrong.
"""

import logging
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, get_args

import numpy as np
import pandas as pd

from mammosim.core.errors import EquilibriumError, MammosimError
from mammosim.core.settings import Settings, read
from mammosim.study.hard_cases.invariance import changed
from mammosim.study.hard_cases.overlap import faces_inside
from mammosim.study.hard_cases.problems import ProblemSettings, Solution
from mammosim.study.hard_cases.quantities import QUANTITIES
from mammosim.study.hard_cases.references import Refined
from mammosim.study.hard_cases.verdict import EXPECTED, Converges, Expected, Kind, Outcome, Unstable, verdict

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class HardCase(Settings):
    """One entry of the catalogue: what kind of difficulty, what is hard, the problem, what should happen."""

    family: str
    hard: str
    problem: ProblemSettings
    expected: Annotated[Expected, EXPECTED]
    name: str = ""

    @classmethod
    def of(cls, name: str, values: Mapping[str, Any]) -> "HardCase":
        """The case as configured. Raises ConfigurationError for a key or value that cannot be."""
        case: HardCase = read(cls, {**values, "name": name}, f"cases.{name}")
        return case


def row(case: HardCase) -> dict[str, Any]:
    """A row of results/study/hard_cases.csv: what was expected, what happened, whether it is that.

    seconds: processor time of everything, references included.
    """
    began = time.process_time()
    expected, happened = case.expected, attempt(case)
    ok, against = verdict(expected, happened)
    if not ok:
        log.error("%s has an UNEXPECTED outcome (not %s): %s; %s", case.name, expected, happened, against)
    return {
        "case": case.name,
        "family": case.family,
        "hard": case.hard,
        "expected": str(expected),
        "outcome": str(happened),
        "ok": ok,
        "error": happened.relative_error,
        "seconds": time.process_time() - began,
        "within": getattr(expected, "within", None) or np.nan,
        "because": getattr(expected, "because", ""),
        "not_ok_because": against,
        "load_factor": happened.error.load_factor if isinstance(happened.error, EquilibriumError) else np.nan,
        "unknowns": happened.unknowns,
        "iterations": happened.iterations,
        "smallest_J": happened.smallest_J,
    }


def attempt(case: HardCase) -> Outcome:
    """What happens. Anything that is not an error of mammosim is a crash, which is an outcome, too."""
    try:
        problem = case.problem.problem()
        solution = problem.solution()
        error = _error(case, solution)
    except MammosimError as error_of_ours:
        return Outcome.of(error_of_ours, _load_factor_error(case.expected, error_of_ours))
    except Exception as crash:
        log.exception("%s crashed", case.name)
        return Outcome("crashed", why=f"{type(crash).__name__}: {crash}")
    state = solution.equilibrium
    return Outcome(
        "converged",
        error,
        unknowns=float((~problem.held).sum()) if problem.held is not None else np.nan,
        iterations=float(len(state.history)),
        smallest_J=state.smallest_J,
        verified=state.positive_definite and state.smallest_J > 0,
        overlapping=len(faces_inside(problem.mesh, solution.x)),
    )


def _error(case: HardCase, solution: Solution) -> float:
    """The relative error of a state that was found; NaN where none was expected."""
    expected = case.expected
    if not isinstance(expected, Converges):
        return np.nan
    if expected.reference is None:
        other = changed(solution.problem, expected.same_as).shape()
        moved = np.linalg.norm(solution.displacements, axis=1).max()
        return float(np.linalg.norm(other - solution.x, axis=1).max() / moved)
    quantity = QUANTITIES[expected.quantity]
    if isinstance(expected.reference, Refined):
        right = quantity(case.problem.refined(expected.reference.edge_mm).problem().solution())
    else:
        right = expected.reference.value()
    return relative_error(quantity(solution), right)


def relative_error(found: float, right: float) -> float:
    """Infinite where anything is found in place of nothing, as a force on plates that have lost the body."""
    return abs(found - right) / abs(right) if right else np.inf


def _load_factor_error(expected: Expected, error: MammosimError) -> float:
    reference = expected.load_factor if isinstance(expected, Unstable) else None
    if reference is None or not isinstance(error, EquilibriumError):
        return np.nan
    right = reference.value()
    return relative_error(error.load_factor, right)


def numbers(table: pd.DataFrame) -> dict[str, Any]:
    """What the page says: how many cases there are, of each kind of outcome, and which are unexpected."""
    wrong, kinds = table[~table.ok], table.outcome.str.split(":").str[0]
    return {
        "hard_cases.total": len(table),
        "hard_cases.families": int(table.family.nunique()),
        **{f"hard_cases.{kind}": int((kinds == kind).sum()) for kind in get_args(Kind)},
        "hard_cases.unexpected": len(wrong),
        "hard_cases.unexpected_names": ", ".join(wrong.case) or "none",
        "hard_cases.seconds": float(table.seconds.sum()),
    }


def unexpected(table: pd.DataFrame) -> list[str]:
    """One line per case whose outcome is not the expected one."""
    return [
        f"UNEXPECTED OUTCOME: {case.case} ({case.family}): {case.not_ok_because}. Expected: {case.expected}. "
        f"Happened: {case.outcome}"
        for case in table[~table.ok].itertuples()
    ]
