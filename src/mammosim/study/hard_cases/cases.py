"""Hard cases: what is hard, what is expected, what happens, a row of the table for each.

A case converges within a stated error of its reference, or is refused for a stated reason; a crash is an
outcome, too. Nothing passes silently wrong.
"""

import logging
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from mammosim.core.errors import EquilibriumError, MammosimError
from mammosim.mechanics.equilibrium import Equilibrium
from mammosim.study.hard_cases.judgement import Converges, Outcome, Refused, judged
from mammosim.study.hard_cases.references import QUANTITIES, reference
from mammosim.study.hard_cases.scenes import Scene, scene
from mammosim.study.hard_cases.twins import shape_of, twin

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class HardCase:
    """One entry of the catalogue; scene: nested plain values, see hard_cases.scenes."""

    name: str
    family: str
    hard: str
    scene: Mapping[str, Any]
    expected: Converges | Refused

    @classmethod
    def of(cls, name: str, values: Mapping[str, Any]) -> "HardCase":
        """The case of nested plain values. Raises ConfigurationError for an expectation that says nothing."""
        expected = values["expected"]
        if "converges" in expected:
            what: Converges | Refused = Converges(**expected["converges"])
        else:
            refused = dict(expected["refused"])
            what = Refused(**{**refused, "saying": tuple(refused["saying"])})
        return cls(name, values["family"], values["hard"], values["scene"], what)


def row(case: HardCase) -> dict[str, Any]:
    """A row of results/study/hard_cases.csv: what was expected, what happened, whether it is that.

    seconds: processor time of everything, references included.
    """
    began = time.process_time()
    happened = attempt(case)
    ok, against = judged(case.expected, happened)
    refusal = happened.refusal
    if not ok:
        log.error("%s is NOT as expected (%s): %s; %s", case.name, case.expected, happened.words, against)
    return {
        "case": case.name,
        "family": case.family,
        "hard": case.hard,
        "expected": str(case.expected),
        "outcome": happened.words,
        "ok": ok,
        "error": happened.error,
        "seconds": time.process_time() - began,
        "within": case.expected.within,
        "because": case.expected.because,
        "not_ok_because": against,
        "load_factor": refusal.load_factor if isinstance(refusal, EquilibriumError) else np.nan,
        "unknowns": happened.unknowns,
        "iterations": happened.iterations,
        "smallest_J": happened.smallest_J,
    }


def attempt(case: HardCase) -> Outcome:
    """What happens. Anything that is not an error of mammosim is a crash, which is an outcome, too."""
    try:
        there = scene(case.scene)
        state = there.equilibrium()
        error = _error(case, there, state)
    except EquilibriumError as refusal:
        factor = f" beyond load factor {refusal.load_factor:.3f}"
        return Outcome(f"refused{factor}: {refusal}", _load_factor_error(case.expected, refusal), refusal)
    except MammosimError as refusal:
        return Outcome(f"refused: {refusal}", refusal=refusal)
    except Exception as crash:
        log.exception("%s crashed", case.name)
        return Outcome(f"crashed: {type(crash).__name__}: {crash}", crashed=True)
    return Outcome(
        "converged",
        error,
        unknowns=float((~there.held).sum()) if there.held is not None else np.nan,
        iterations=float(len(state.history)),
        smallest_J=state.smallest_J,
        verified=state.positive_definite and state.smallest_J > 0,
    )


def _error(case: HardCase, there: Scene, state: Equilibrium) -> float:
    """The relative error of a state that was found; NaN where a refusal was expected."""
    expected = case.expected
    if isinstance(expected, Refused):
        return np.nan
    if expected.same_as is not None:
        other = shape_of(twin(there, expected.same_as))
        moved = np.linalg.norm(state.points - there.mesh.points, axis=1).max()
        return float(np.linalg.norm(other - state.points, axis=1).max() / moved)
    quantity = QUANTITIES[expected.quantity]
    right = _reference(case, expected)
    return abs(quantity(there, state.points) - right) / abs(right)


def _reference(case: HardCase, expected: Converges) -> float:
    values = dict(expected.reference or {})
    if "refined" not in values:
        return reference(values)
    fine = scene({**case.scene, "body": {**case.scene["body"], **values["refined"]}})
    return QUANTITIES[expected.quantity](fine, fine.equilibrium().points)


def _load_factor_error(expected: Converges | Refused, refusal: EquilibriumError) -> float:
    if not isinstance(expected, Refused) or expected.load_factor is None:
        return np.nan
    right = reference(expected.load_factor)
    return abs(refusal.load_factor - right) / abs(right)


def numbers(table: pd.DataFrame) -> dict[str, Any]:
    """What the page says of all cases: hard_cases.total, .families, .not_ok and .not_ok_names, .seconds."""
    wrong = table[~table.ok]
    return {
        "hard_cases.total": len(table),
        "hard_cases.families": int(table.family.nunique()),
        "hard_cases.solved": int((table.outcome == "converged").sum()),
        "hard_cases.refused": int(table.outcome.str.startswith("refused").sum()),
        "hard_cases.not_ok": len(wrong),
        "hard_cases.not_ok_names": ", ".join(wrong.case) or "none",
        "hard_cases.seconds": float(table.seconds.sum()),
    }


def not_as_expected(table: pd.DataFrame) -> list[str]:
    """One line per case that is not as expected."""
    return [
        f"NOT AS EXPECTED: {case.case} ({case.family}): {case.not_ok_because}. Expected: {case.expected}. "
        f"Happened: {case.outcome}"
        for case in table[~table.ok].itertuples()
    ]
