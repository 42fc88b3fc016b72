"""One value of one numerical parameter tried on one breast: what is answered, and its processor time.

What every trial shares, the chain at today's settings, is made once and kept in files.
"""

import os
import resource
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mammosim.chain.graph import Chain, Made, Stage, upstream
from mammosim.chain.quantities import quantities
from mammosim.chain.stages import LABELLED, MECHANICS, STAGES
from mammosim.core.errors import EquilibriumError, MammosimError, MissingResult
from mammosim.study.accuracy.parameters import NumericalParameter, Repeats, Value

CONVERGED = "converged"
CHAIN, TODAY = "chain", "today"  # in the place of a parameter and of its value: the whole chain as it is
ANSWERS = ("answer_1", "answer_2", "answer_3")  # a place has three coordinates, the rest one number
IMAGES = frozenset(LABELLED)
# Made once for all repeats where they take long.
PRESSES = IMAGES | frozenset(MECHANICS)
# What takes long is repeated as often as presses: mechanics are kept for what follows, slices are an end.
# Products that trials share in files.
KEPT = ("transform", "labels", "mesh", "stress_free", "loaded", "standard_path", "pressed", "phantom",
        "field", "spectrum", "scatter")  # fmt: skip
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
    """The last value of a parameter, tried as often as `repeats` says of presses and of others.

    today: a chain at today's settings, with what was made of it; kept: the mechanics that are not made again.
    """

    today: Chain
    parameter: NumericalParameter
    repeats: Repeats
    kept: dict[tuple, Made] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.touched = touched(STAGES, self.value.settings.by_name)
        made = self.touched & needed(self.parameter.quantities)
        self.ends = bool(COSTLY_END & made)
        self.costly = bool(COSTLY & made) and not self.parameter.stochastic

    @property
    def value(self) -> Value:
        """What is tried."""
        return self.parameter.values[-1]

    def rows(self) -> pd.DataFrame:
        """A row per quantity and repeat: ANSWERS, seconds, memory_mb, outcome, and what the parameter is.

        An error ends the repeats.
        """
        rows: list[dict[str, Any]] = []
        if not (self.ends or self.costly or IMAGES & self.touched):
            self._warm_up()
        for repeat in range(self.repeats.presses if self.ends else self.repeats.others):
            rows += self._repeat(repeat)
            if any(row["outcome"] != CONVERGED for row in rows):
                break
        value = self.value
        about = {
            "stage": self.parameter.stage, "parameter": self.parameter.name, "value": value.name,
            "size": np.nan if value.size is None else value.size, "stochastic": self.parameter.stochastic,
            "today": value.today, "reference": value.reference, "settings": value.settings.text,
        }  # fmt: skip
        return _table(about, rows)

    def _warm_up(self) -> None:
        """Load the compiled kernels, by the draft."""
        chain = self._chain(self.parameter.values[0], 0)
        for name in self.parameter.quantities:
            answered(name, chain)

    def _chain(self, value: Value, repeat: int) -> Chain:
        """With random streams of its own for each repeat; what the value touches is not known yet."""
        fresh = replace(self.today, subject=self.today.subject.repeated(repeat))
        known = {key: made for key, made in self.today.made.items() if key[0] not in self.touched}
        read = {key: paths for key, paths in self.today.files.items() if key[0] not in self.touched}
        return replace(fresh, made=known | self.kept, files=read).with_settings(value.settings.by_name)

    def _repeat(self, repeat: int) -> list[dict[str, Any]]:
        """The rows of one repeat."""
        chain = self._chain(self.value, repeat)
        rows = []
        for name in self.parameter.quantities:
            rows.append(_row(name, repeat, *answered(name, chain), self._seconds(name, chain)))
        if self.costly and not self.kept and repeat + 1 >= self.repeats.presses:
            self.kept = {key: made for key, made in chain.made.items() if key[0] in PRESSES & self.touched}
        return rows

    def _seconds(self, name: str, chain: Chain) -> float:
        """What the products of a quantity took that the parameter touches."""
        taken: dict[str, float] = {}
        for product in quantities([name])[name].products:
            taken |= chain.seconds(product)
        return sum(t for n, t in taken.items() if n in needed([name]) & self.touched)


def answered(name: str, chain: Chain) -> tuple[np.ndarray, str]:
    """The answer (1,) or (3,) of a chain to a quantity, and its outcome; NaN where there is none."""
    try:
        answer = np.atleast_1d(np.asarray(quantities([name])[name].of(chain), float))
    except MammosimError as error:
        return np.full(1, np.nan), outcome_of(error)
    return answer, CONVERGED if np.all(np.isfinite(answer)) else "failed: the answer is not a number"


def outcome_of(error: MammosimError) -> str:
    """Why there is no answer: unstable where a mode proves it, failed without a solution, else rejected."""
    if isinstance(error, EquilibriumError) and error.mode is not None:
        return f"unstable: {error}"
    return f"{'failed' if isinstance(error, EquilibriumError | MissingResult) else 'rejected'}: {error}"


def _row(name: str, repeat: int, answer: np.ndarray, outcome: str, seconds: float) -> dict[str, Any]:
    """Of one answer (1,) or (3,) to a quantity, as ANSWERS."""
    numbers = np.pad(answer, (0, len(ANSWERS) - len(answer)), constant_values=np.nan)
    return {
        "quantity": name,
        "repeat": repeat,
        **dict(zip(ANSWERS, numbers)),
        "seconds": seconds,
        "outcome": outcome,
    }


def peak_memory_mb() -> float:
    """The largest resident memory of this process so far: interpreter, libraries, and all that it made."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _table(about: Mapping[str, Any], rows: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """What is the same in all rows, the rows, and the memory of the job."""
    table = pd.DataFrame(rows).assign(memory_mb=peak_memory_mb())
    return pd.DataFrame(about, index=table.index).join(table)


def made_today(measured: Chain, names: Sequence[str]) -> tuple[Chain, pd.DataFrame]:
    """The chain of what was measured at today's settings, and a row per quantity with the seconds of all.

    names: of quantities. All is made twice, so that no compilation is in its seconds.
    Raises the error of one that has no answer: without it there is nothing to compare.
    """
    asked = quantities(list(names))
    for _ in range(2):
        chain = replace(measured, made={})
        answers = {name: quantity.of(chain) for name, quantity in asked.items()}
    rows = []
    for name, quantity in asked.items():
        taken = {n: t for end in quantity.products for n, t in chain.seconds(end).items()}
        answer = np.atleast_1d(np.asarray(answers[name], float))
        rows.append(_row(name, 0, answer, CONVERGED, sum(taken.values())))
    about = {"stage": CHAIN, "parameter": CHAIN, "value": TODAY, "size": np.nan, "stochastic": False}
    about |= {"today": True, "reference": False, "settings": "{}"}
    return chain, _table(about, rows)


def write_start(chain: Chain, folder: str | Path) -> None:
    """The products KEPT of a chain, as far as they were made for an answer."""
    Path(folder).mkdir(parents=True, exist_ok=True)
    for name in KEPT:
        made = chain.made.get(chain.key(name)) if name in chain.stages else None
        if made is not None and made.failure is None:
            chain.stages[name].save(made.value, _paths(folder, name, beside=True), {})


def start_files(folder: str | Path) -> dict[str, dict[str, str]]:
    """What write_start kept: product -> file -> path."""
    kept = {name: _paths(folder, name) for name in KEPT}
    return {name: files for name, files in kept.items() if all(map(os.path.exists, files.values()))}


def _paths(folder: str | Path, name: str, *, beside: bool = False) -> dict[str, str]:
    files = STAGES[name].files
    if files is None:
        return {}
    endings = {**files.endings, **(files.beside if beside else {})}
    return {file: str(Path(folder) / f"{name}_{file}{ending}") for file, ending in endings.items()}
