"""Which effects a question calls for: what leaving each out does to the answer, on a coarse model.

Each effect is left out of the full model alone; then those that may go in pairs, for two may matter only
together; then all that may go at once; at last each of them is added again to what is kept. An answer moves
by its change over its tolerance; the largest of a scene's answers counts.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import combinations
from typing import Annotated

import numpy as np
import pandas as pd

from mammosim.core.errors import MechanicsError
from mammosim.core.settings import Limits, Positive, Settings

COLUMNS = ["scene", "effect", "quantity", "change", "noise", "tolerance", "seconds", "included", "reason",
           "change_added"]  # fmt: skip
SIGNIFICANCE = 2.0  # standard errors that a significant change exceeds
# How several effects were tried: two left out, all left out, one added to what is kept.
PAIR, TOGETHER, ADDED = "pair", "together", "added"
JOINT = ["scene", "tried", "effects", "quantity", "change", "tolerance", "failure"]


@dataclass(frozen=True)
class Answer:
    """changes: of each asked quantity against another model, in its unit; noise: their standard errors.

    seconds: what it took; failure: why there is none.
    """

    changes: Mapping[str, float]
    seconds: float
    noise: Mapping[str, float] = field(default_factory=dict)
    failure: str = ""

    def moved(self, tolerance: Mapping[str, float]) -> float:
        """The largest change over its tolerance; infinite where there is no answer."""
        return np.inf if self.failure else max(self.changes[q] / t for q, t in tolerance.items())

    def worst(self, tolerance: Mapping[str, float]) -> str:
        """The quantity that moved most."""
        return max(tolerance, key=lambda q: self.changes[q] / tolerance[q])


@dataclass(frozen=True)
class Rule(Settings):
    """part: of a tolerance that an effect may move an answer and still be left out; joint_part: all together.

    pairs: how many of the most important effects left out are tried in pairs.
    """

    part: Positive = 0.25
    joint_part: Positive = 0.5
    pairs: Annotated[int, Limits(at_least=0)] = 3


Answers = Callable[[frozenset[str], frozenset[str]], Answer]


@dataclass
class Screening:
    """The screening of one scene; answers: of a set of effects, against those of another set."""

    scene: str
    full: frozenset[str]
    needed: frozenset[str]
    tolerance: Mapping[str, float]
    answers: Answers
    rule: Rule
    reasons: dict[str, str] = field(default_factory=dict)
    included: set[str] = field(default_factory=set)
    joint: list[tuple] = field(default_factory=list)

    def tables(self) -> tuple[pd.DataFrame, pd.DataFrame]:
        """COLUMNS, a row per effect and quantity, and JOINT, a row per trial of several and quantity.

        seconds: saved by leaving the effect out alone; change_added: by adding it to what is kept.
        Raises MechanicsError where the full model itself has no answer.
        """
        whole = self.answers(self.full, self.full)
        if whole.failure:
            raise MechanicsError(
                f"scene {self.scene}: the full model has no answer on the coarse mesh: {whole.failure}; "
                "screen on a finer preset (scenes.coarse), or list the effects"
            )
        alone = {e: self.answers(self.full - {e}, self.full) for e in sorted(self.full - self.needed)}
        self._keep(self.needed, "what is asked means nothing without it, or the machine has it")
        self._judge_alone(alone)
        self._judge_pairs(alone)
        self._judge_together(alone)
        added = self._judge_added(alone)
        rows = [
            row
            for effect in sorted(self.full)
            for row in self._rows(effect, alone.get(effect), whole.seconds, added.get(effect))
        ]
        return pd.DataFrame(rows, columns=COLUMNS), pd.DataFrame(self.joint, columns=JOINT)

    def _keep(self, effects: frozenset[str] | set[str], reason: str) -> None:
        self.included |= effects
        self.reasons |= dict.fromkeys(effects, reason)

    def _judge_alone(self, alone: Mapping[str, Answer]) -> None:
        for effect, answer in alone.items():
            moved = answer.moved(self.tolerance)
            if answer.failure:
                self._keep({effect}, f"without it there is no answer: {answer.failure}")
            elif moved > self.rule.part:
                self._keep({effect}, f"without it {self._words(answer)}")
            elif self._lost_in_noise(answer):
                self._keep({effect}, f"too noisy to tell: without it {self._words(answer)}")
            else:
                self.reasons[effect] = f"without it {self._words(answer)}, below {self.rule.part:g}"

    def _judge_pairs(self, alone: Mapping[str, Answer]) -> None:
        """Of two that matter only together, the one that matters more alone is kept."""
        left = self._left(alone)[::-1]
        for one, other in combinations(left[: self.rule.pairs], 2):
            if {one, other} & self.included:
                continue
            answer = self._tried(PAIR, {one, other}, self.full - {one, other}, self.full)
            if answer.moved(self.tolerance) > self.rule.part:
                self._keep({one}, f"alone it may go, but without it and {other} {self._why(answer)}")

    def _judge_together(self, alone: Mapping[str, Answer]) -> None:
        """What was left out comes back, the most important first, until all the rest may go at once."""
        left = self._left(alone)
        while len(left) > 1:
            answer = self._tried(TOGETHER, set(left), self.full - set(left), self.full)
            if answer.moved(self.tolerance) <= self.rule.joint_part:
                return
            self._keep({left.pop()}, f"alone it may go, but without all that may {self._why(answer)}")

    def _judge_added(self, alone: Mapping[str, Answer]) -> dict[str, Answer]:
        """What was left out and yet matters to the model that is left comes back; every answer to that."""
        left = self._left(alone)
        model = self.full - set(left)
        added = {effect: self._tried(ADDED, {effect}, model | {effect}, model) for effect in left}
        for effect, answer in added.items():
            if answer.moved(self.tolerance) > self.rule.part:
                self._keep({effect}, f"it may go, but with it what is left {self._why(answer)}")
        return added

    def _left(self, alone: Mapping[str, Answer]) -> list[str]:
        """What is not kept so far, the most important last."""
        return sorted(set(alone) - self.included, key=lambda effect: alone[effect].moved(self.tolerance))

    def _tried(self, how: str, which: set[str], model: frozenset[str], reference: frozenset[str]) -> Answer:
        """An answer, which is recorded among those of several effects."""
        answer = self.answers(model, reference)
        for q, tolerance in self.tolerance.items():
            change = answer.changes.get(q, np.nan)
            self.joint.append(
                (self.scene, how, ", ".join(sorted(which)), q, change, tolerance, answer.failure)
            )
        return answer

    def _why(self, answer: Answer) -> str:
        return answer.failure or self._words(answer)

    def _lost_in_noise(self, answer: Answer) -> bool:
        """Whether the noise of an answer that moved could hide what an effect is kept for."""
        return any(
            answer.changes[q] > 0 and SIGNIFICANCE * answer.noise.get(q, 0.0) > self.rule.part * tolerance
            for q, tolerance in self.tolerance.items()
        )

    def _words(self, answer: Answer) -> str:
        q = answer.worst(self.tolerance)
        change, noise = answer.changes[q], answer.noise.get(q, 0.0)
        noisy = f" (standard error {noise:.2g}: not significant)" if 0 < change < SIGNIFICANCE * noise else ""
        return f"{q} moves by {change:.2g}{noisy}, {change / self.tolerance[q]:.2g} of its tolerance"

    def _rows(
        self, effect: str, answer: Answer | None, whole_s: float, added: Answer | None
    ) -> Iterator[tuple]:
        for q, tolerance in self.tolerance.items():
            change, noise, saved = np.nan, np.nan, np.nan
            if answer is not None and not answer.failure:
                change, noise = answer.changes[q], answer.noise.get(q, 0.0)
                saved = whole_s - answer.seconds
            included, reason = effect in self.included, self.reasons[effect]
            with_it = np.nan if added is None else added.changes.get(q, np.nan)
            yield self.scene, effect, q, change, noise, tolerance, saved, included, reason, with_it
