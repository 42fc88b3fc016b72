"""One value of one knob tried on one breast: what is answered, and the processor time that it costs."""

import resource
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd

from mammosim.chain.graph import Chain, Made, Stage, upstream
from mammosim.chain.quantities import quantities
from mammosim.chain.stages import LABELLED, MECHANICS, STAGES
from mammosim.core.errors import MammosimError
from mammosim.study.accuracy.knobs import Knob, Value

OK = "ok"
ANSWERS = ("answer_1", "answer_2", "answer_3")  # a place has three coordinates, the rest one number
IMAGES = frozenset(LABELLED)
# Made once for all repeats where they take long.
PRESSES = IMAGES | frozenset(MECHANICS)
# What takes long is repeated as often as presses: mechanics are kept for what follows, slices are an end.
COSTLY, COSTLY_END = frozenset({"labels", "mesh", "pressed"}), frozenset({"slices"})


def touched(stages: Mapping[str, Stage], settings: Collection[str]) -> frozenset[str]:
    """The products that some of these settings change, by themselves or by what they need."""
    return frozenset(
        name
        for name in stages
        for each in (name, *upstream(stages, name))
        if any(_overlap(read, key) for read in stages[each].reads for key in settings)
    )


def _overlap(one: str, other: str) -> bool:
    """Whether two dotted names are the same or one lies in the other."""
    return f"{one}.".startswith(f"{other}.") or f"{other}.".startswith(f"{one}.")


def needed(names: Sequence[str]) -> frozenset[str]:
    """The products that quantities are made of."""
    ends = [end for quantity in quantities(list(names)).values() for end in quantity.products]
    return frozenset(each for end in ends for each in (*upstream(STAGES, end), end))


@dataclass
class Trial:
    """The last value of a knob, tried as often as `repeats` says of presses and of others.

    today: a chain at today's settings, with what was made of it; kept: the mechanics that are not made again.
    """

    today: Chain
    knob: Knob
    repeats: Mapping[str, int]
    kept: dict[tuple, Made] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.touched = touched(STAGES, self.value.settings)
        self.costly = bool(COSTLY & self.touched & needed(self.knob.quantities)) and not self.knob.random

    @property
    def value(self) -> Value:
        """What is tried."""
        return self.knob.values[-1]

    def rows(self) -> pd.DataFrame:
        """A row per quantity and repeat: answer_1 to answer_3, seconds, memory_mb, outcome, and the knob's.

        A refusal ends the repeats.
        """
        rows: list[dict[str, Any]] = []
        ends = bool(COSTLY_END & self.touched & needed(self.knob.quantities))
        if not (ends or self.costly or IMAGES & self.touched):
            self._warm_up()
        for repeat in range(self.repeats["presses" if ends else "others"]):
            rows += self._repeat(repeat)
            if any(row["outcome"] != OK for row in rows):
                break
        value = self.value
        about = {
            "stage": self.knob.stage, "knob": self.knob.name, "value": value.name, "size": value.size,
            "random": self.knob.random, "today": value.today, "reference": value.reference,
            "settings": value.text,
        }  # fmt: skip
        table = pd.DataFrame(rows).assign(memory_mb=peak_memory_mb())
        return pd.DataFrame(about, index=table.index).join(table)

    def _warm_up(self) -> None:
        """Load the compiled kernels, by the draft."""
        chain = self._chain(self.knob.values[0], 0)
        for name in self.knob.quantities:
            answered(name, chain)

    def _chain(self, value: Value, repeat: int) -> Chain:
        """With random streams of its own for each repeat; what the value touches is not known yet."""
        fresh = replace(self.today, subject=self.today.subject.repeated(repeat))
        known = {key: made for key, made in self.today.made.items() if key[0] not in self.touched}
        read = {key: paths for key, paths in self.today.files.items() if key[0] not in self.touched}
        return replace(fresh, made=known | self.kept, files=read).with_settings(value.settings)

    def _repeat(self, repeat: int) -> list[dict[str, Any]]:
        """The rows of one repeat."""
        chain = self._chain(self.value, repeat)
        rows = []
        for name in self.knob.quantities:
            answer = answered(name, chain)
            rows.append(_row(name, repeat, answer, self._seconds(name, chain)))
        if self.costly and not self.kept and repeat + 1 >= self.repeats["presses"]:
            self.kept = {key: made for key, made in chain.made.items() if key[0] in PRESSES & self.touched}
        return rows

    def _seconds(self, name: str, chain: Chain) -> float:
        """What the products of a quantity took that the knob touches."""
        taken: dict[str, float] = {}
        for product in quantities([name])[name].products:
            taken |= chain.seconds(product)
        return sum(t for n, t in taken.items() if n in needed([name]) & self.touched)


def answered(name: str, chain: Chain) -> tuple[np.ndarray, str]:
    """The answer (1,) or (3,) of a chain to a quantity, and OK; NaN and the reason where it is refused."""
    try:
        answer = np.atleast_1d(np.asarray(quantities([name])[name].of(chain), float))
    except MammosimError as refusal:
        return refused(refusal)
    return (answer, OK) if np.all(np.isfinite(answer)) else (answer, "refused: the answer is not a number")


def refused(why: MammosimError) -> tuple[np.ndarray, str]:
    """What a refusal answers."""
    return np.full(1, np.nan), f"refused: {why}"


def _row(name: str, repeat: int, answer: tuple[np.ndarray, str], seconds: float) -> dict[str, Any]:
    return (
        {"quantity": name, "repeat": repeat}
        | numbered(answer[0])
        | {"seconds": seconds, "outcome": answer[1]}
    )


def numbered(answer: np.ndarray) -> dict[str, float]:
    """An answer (1,) or (3,) as ANSWERS."""
    return dict(zip(ANSWERS, np.pad(answer, (0, len(ANSWERS) - len(answer)), constant_values=np.nan)))


def peak_memory_mb() -> float:
    """The largest resident memory of this process so far: interpreter, libraries, and all that it made."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
