"""What is expected of a hard case, what happened, and the verdict: whether the one is the other.

A wrong answer, an error for another reason than the one stated, and a crash are never the expected outcome.
"""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import numpy as np

from mammosim.core.errors import ConfigurationError, EquilibriumError, MammosimError
from mammosim.core.settings import Limits, OneOf, Settings, named_words
from mammosim.study.hard_cases.invariance import INVARIANCE_TESTS, InvarianceTest
from mammosim.study.hard_cases.quantities import QuantityNames
from mammosim.study.hard_cases.references import REFERENCES, Known, Refined

# What keeps a body stable; a diagnosis names at least one.
HELPS = ("skin", "stiff", "chest wall")
Within = Annotated[float, Limits(above=0, at_most=0.5, advice="0.01 is 1 %: was it given in percent?")]
Words = tuple[str, ...]
Kind = Literal["converged", "unstable", "failed", "rejected", "crashed"]


class Expectation(Settings):
    """What should happen: an outcome of this kind, of which nothing is wrong."""

    kind: ClassVar[str]

    def against(self, happened: "Outcome") -> str:
        """What speaks against an outcome, nothing if it is the expected one."""
        return (
            self.wrong(happened) if happened.kind == self.kind else f"{happened.kind} instead of {self.kind}"
        )

    def wrong(self, happened: "Outcome") -> str:
        """What is wrong with an outcome of this kind."""
        raise NotImplementedError


@dataclass(frozen=True)
class Converges(Expectation):
    """Expected: a verified equilibrium, whose quantity is that of a reference, or which is that of same_as.

    quantity: a name of QUANTITIES. within: the largest relative error; because: how that follows.
    or_unstable: a loss of stability that is diagnosed is as good an answer.
    Raises ConfigurationError unless there is exactly one of reference and same_as.
    """

    kind: ClassVar[str] = "converged"
    within: Within
    because: str
    quantity: Literal[""] | QuantityNames = ""
    reference: Annotated[Known | Refined, OneOf({**REFERENCES.kinds, "refined": Refined})] | None = None
    same_as: Annotated[tuple[InvarianceTest, ...], INVARIANCE_TESTS] = ()
    or_unstable: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.reference is None) != bool(self.same_as) or (self.reference is None) == bool(self.quantity):
            raise ConfigurationError("give either a quantity with its reference, or same_as")

    def __str__(self) -> str:
        against = ", ".join(map(named_words, self.same_as))
        if self.reference is not None:
            against = f"{self.quantity} of {named_words(self.reference)}"
        return f"within {self.within:.2g} of {against}" + (", or unstable" if self.or_unstable else "")

    def against(self, happened: "Outcome") -> str:
        if happened.kind == "unstable" and self.or_unstable:
            return _not_diagnosed(happened.error)
        return super().against(happened)

    def wrong(self, happened: "Outcome") -> str:
        if not happened.verified:
            return "the state was not verified"
        if happened.overlapping:
            return f"the body passes through itself: {happened.overlapping} faces of its skin lie inside it"
        return _off("error", happened.relative_error, self.within)


@dataclass(frozen=True)
class Rejected(Expectation):
    """Expected: bad input is rejected by an error of the class `by`, whose message says all of `saying`."""

    kind: ClassVar[str] = "rejected"
    by: Literal["MechanicsError", "MeshError"]
    saying: Words

    def __str__(self) -> str:
        return f"rejected, saying {_and(self.saying)}"

    def wrong(self, happened: "Outcome") -> str:
        if self.by not in [kind.__name__ for kind in type(happened.error).__mro__]:
            return f"rejected by {type(happened.error).__name__} instead of {self.by}"
        return _silent(self.saying, happened.error)


@dataclass(frozen=True)
class Failed(Expectation):
    """Expected: no equilibrium is found, for a reason that says all of `saying`."""

    kind: ClassVar[str] = "failed"
    saying: Words

    def __str__(self) -> str:
        return f"failed, saying {_and(self.saying)}"

    def wrong(self, happened: "Outcome") -> str:
        return _silent(self.saying, happened.error)


@dataclass(frozen=True)
class Unstable(Expectation):
    """Expected: a proved loss of stability with its load factor, its mode, and what would help.

    load_factor: a reference, met within `within`; because: how that follows.
    """

    kind: ClassVar[str] = "unstable"
    load_factor: Annotated[Known, REFERENCES] | None = None
    within: Within | None = None
    because: str = ""

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.load_factor is None) != (self.within is None):
            raise ConfigurationError("a load_factor needs `within`, how near it must be, and the reverse")

    def __str__(self) -> str:
        return "unstable, with load factor, mode and advice"

    def wrong(self, happened: "Outcome") -> str:
        if lacks := _not_diagnosed(happened.error):
            return lacks
        return _off("load factor error", happened.relative_error, self.within) if self.within else ""


Expected = Converges | Rejected | Failed | Unstable
EXPECTED = OneOf({"converges": Converges, "rejected": Rejected, "failed": Failed, "unstable": Unstable})


@dataclass(frozen=True)
class Outcome:
    """What happened; why: the message of an error, of mammosim unless it crashed.

    relative_error: against the reference, NaN where nothing was compared. The rest is of the state;
    overlapping: how many faces of its skin lie inside it.
    """

    kind: Kind
    relative_error: float = np.nan
    why: str = ""
    error: MammosimError | None = None
    unknowns: float = np.nan
    iterations: float = np.nan
    smallest_J: float = np.nan
    verified: bool = False
    overlapping: int = 0

    @classmethod
    def of(cls, error: MammosimError, relative_error: float = np.nan) -> "Outcome":
        """Of an error: unstable where it has the mode that proves it."""
        kind: Kind = "rejected"
        if isinstance(error, EquilibriumError):
            kind = "failed" if error.mode is None else "unstable"
        return cls(kind, relative_error, str(error), error)

    def __str__(self) -> str:
        return f"{self.kind}: {self.why}" if self.why else self.kind


def verdict(expected: Expected, happened: Outcome) -> tuple[bool, str]:
    """Whether what happened is what was expected, and if not, why."""
    against = "a crash is never expected" if happened.kind == "crashed" else expected.against(happened)
    return not against, against


def _off(what: str, relative_error: float, within: float) -> str:
    near = relative_error <= within
    return "" if near else f"{what} {relative_error:.2g} exceeds {within:.2g}"


def _silent(saying: Words, error: MammosimError | None) -> str:
    """What a message does not say."""
    absent = [words for words in saying if words not in str(error)]
    return f"the error does not say {' nor '.join(map(repr, absent))}" if absent else ""


def _and(saying: Words) -> str:
    return " and ".join(map(repr, saying))


def _not_diagnosed(error: MammosimError | None) -> str:
    """What a diagnosis of lost stability lacks, nothing if it is complete."""
    lacks = {
        "a load factor below 1": not isinstance(error, EquilibriumError) or not 0 <= error.load_factor < 1,
        "advice": not any(word in str(error) for word in HELPS),
    }
    missing = [what for what, is_missing in lacks.items() if is_missing]
    return f"the diagnosis lacks {', '.join(missing)}" if missing else ""
