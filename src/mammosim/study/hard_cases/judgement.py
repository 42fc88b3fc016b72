"""What is expected of a hard case, what happened, and whether the one is the other.

A wrong answer, a refusal for another reason than the one stated, and a crash are all not as expected.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mammosim.core.errors import ConfigurationError, EquilibriumError, MammosimError

# What keeps a body stable; a diagnosis names at least one.
HELPS = ("skin", "stiff", "chest wall")


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

    diagnosed: it is a loss of stability with its load factor, its mode, and what would help.
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
    lacks = {
        "the mode": getattr(refusal, "mode", None) is None,
        "a load factor below 1": not 0 <= refusal.load_factor < 1,
        "advice": not any(word in str(refusal) for word in HELPS),
    }
    missing = [what for what, is_missing in lacks.items() if is_missing]
    return f"the diagnosis lacks {', '.join(missing)}" if missing else ""


def _words(values: Mapping[str, Any] | Iterable | None) -> str:
    """Nested plain values in one line."""
    if isinstance(values, Mapping):
        return ", ".join(
            f"{name.replace('_', ' ')} {_words(value)}".strip() for name, value in values.items()
        )
    if isinstance(values, (list, tuple)):
        return " ".join(map(_words, values))
    return f"{values:g}" if isinstance(values, (int, float)) else str(values)
