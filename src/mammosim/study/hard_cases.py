"""Hard cases: what is hard, what is expected, what happened, and whether that is what was expected.

A case converges within a stated error of its reference, or is refused for a stated reason. A wrong answer, a
refusal for another reason, and a crash are all not ok: nothing passes silently wrong.
"""

import logging
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from mammosim.core.errors import ConfigurationError, EquilibriumError, MammosimError
from mammosim.mechanics.equilibrium import Equilibrium
from mammosim.study.hard_cases_references import QUANTITIES, reference
from mammosim.study.hard_cases_scenes import Scene, scene
from mammosim.study.hard_cases_twins import shape_of, twin

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Converges:
    """Expected: a verified equilibrium, whose quantity is that of a reference, or which is that of a twin.

    quantity: a name of QUANTITIES; reference: of REFERENCES, or {refined: edge in mm}; same_as: of TWINS.
    within: the largest relative error; because: how that follows. or_diagnosed: a loss of stability that is
    diagnosed is as good an answer.
    Raises ConfigurationError unless there is exactly one of reference and same_as.
    """

    within: float
    because: str
    quantity: str = ""
    reference: Mapping[str, Any] | None = None
    same_as: Mapping[str, Any] | None = None
    or_diagnosed: bool = False

    def __post_init__(self) -> None:
        if (self.reference is None) == (self.same_as is None) or (self.reference is None) == bool(
            self.quantity
        ):
            raise ConfigurationError("expected: either a quantity with its reference, or same_as")

    def __str__(self) -> str:
        against = f"{self.quantity} of {_words(self.reference)}" if self.reference else _words(self.same_as)
        return f"within {self.within:.2g} of {against}" + (", or diagnosed" if self.or_diagnosed else "")


@dataclass(frozen=True)
class Refused:
    """Expected: an error of the class `by`, or of one derived from it, whose message says all of `saying`.

    diagnosed: it is a loss of stability with its load factor, its mode and advice.
    load_factor: {name of REFERENCES: values}, met within `within`; because: how that follows.
    """

    by: str
    saying: tuple[str, ...]
    diagnosed: bool = False
    load_factor: Mapping[str, Any] | None = None
    within: float = np.nan
    because: str = ""

    def __str__(self) -> str:
        diagnosed = ", with load factor, mode and advice" if self.diagnosed else ""
        return f"refused, saying {' and '.join(map(repr, self.saying))}{diagnosed}"


@dataclass(frozen=True)
class Outcome:
    """What happened. words: in short; refusal: the error of mammosim that refused it; crashed: another one.

    error: relative to the reference, NaN where nothing was compared. The rest is of the state, NaN without.
    """

    words: str
    error: float = np.nan
    refusal: MammosimError | None = None
    crashed: bool = False
    unknowns: float = np.nan
    iterations: float = np.nan
    smallest_J: float = np.nan
    verified: bool = False


@dataclass(frozen=True)
class HardCase:
    """One entry of the catalogue; scene: nested plain values, see hard_cases_scenes.scene."""

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


def judged(expected: Converges | Refused, happened: Outcome) -> tuple[bool, str]:
    """Whether what happened is what was expected, and if not, why."""
    against = _against(expected, happened)
    return not against, against


def _against(expected: Converges | Refused, happened: Outcome) -> str:
    """What speaks against an outcome, nothing if it is as expected."""
    if happened.crashed:
        return "a crash is neither an answer nor a refusal"
    if isinstance(expected, Refused):
        return _against_refusal(expected, happened)
    if happened.refusal is not None:
        return _not_diagnosed(happened.refusal) if expected.or_diagnosed else "refused instead of solved"
    if not happened.verified:
        return "the state was not verified"
    if not happened.error <= expected.within:
        return f"error {happened.error:.2g} exceeds {expected.within:.2g}"
    return ""


def _against_refusal(expected: Refused, happened: Outcome) -> str:
    refusal = happened.refusal
    if refusal is None:
        return "solved instead of refused"
    if expected.by not in [kind.__name__ for kind in type(refusal).__mro__]:
        return f"refused by {type(refusal).__name__} instead of {expected.by}"
    if absent := [words for words in expected.saying if words not in str(refusal)]:
        return f"the refusal does not say {' nor '.join(map(repr, absent))}"
    if expected.diagnosed and (lacks := _not_diagnosed(refusal)):
        return lacks
    if expected.load_factor is not None and not happened.error <= expected.within:
        return f"the load factor is off by {happened.error:.2g}, more than {expected.within:.2g}"
    return ""


def _not_diagnosed(refusal: MammosimError) -> str:
    """What a diagnosis of lost stability lacks, nothing if it is complete."""
    if not isinstance(refusal, EquilibriumError) or "stability" not in str(refusal):
        return "refused, but not for a loss of stability"
    lacks = [what for what in ("mode", "advice") if getattr(refusal, what, None) is None]
    lacks += [] if 0 < refusal.load_factor < 1 else ["a load factor between 0 and 1"]
    return f"the diagnosis lacks {', '.join(lacks)}" if lacks else ""


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


def _words(values: Mapping[str, Any] | Iterable | None) -> str:
    """Nested plain values in one line."""
    if isinstance(values, Mapping):
        return ", ".join(
            f"{name.replace('_', ' ')} {_words(value)}".strip() for name, value in values.items()
        )
    if isinstance(values, (list, tuple)):
        return " ".join(map(_words, values))
    return f"{values:g}" if isinstance(values, (int, float)) else str(values)
