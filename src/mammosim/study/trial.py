"""One value of one knob tried on one breast: what is answered, and the processor time that the value costs."""

import logging
import resource
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd

from mammosim.core.errors import MammosimError
from mammosim.study import products_images, products_mechanics, products_xray
from mammosim.study.breast import Breast
from mammosim.study.chain import Chain, Product
from mammosim.study.knobs import Knob, Value
from mammosim.study.products_images import Imaged
from mammosim.study.quantities import quantities

log = logging.getLogger(__name__)
IMAGES: Mapping[str, Product] = products_images.PRODUCTS
PRODUCTS: Mapping[str, Product] = {**products_mechanics.PRODUCTS, **products_xray.PRODUCTS}
OK = "ok"
ANSWERS = ("answer_1", "answer_2", "answer_3")  # a place has three coordinates, the rest one number


@dataclass(frozen=True)
class Start:
    """Where trials begin: a breast, as its images and as they were labelled; today's settings and effects.

    given: products of the chain that were made at today's settings, with the seconds that each took, those
    of the images, too.
    """

    imaged: Imaged
    breast: Breast
    settings: Mapping[str, Any]
    effects: frozenset[str]
    given: Mapping[str, Any] = field(default_factory=dict)
    seconds: Mapping[str, float] = field(default_factory=dict)

    def images(self, value: Value, repeat: int) -> Chain:
        """The chain from the images to a breast."""
        subject = replace(
            self.imaged,
            names=_stream(self.imaged.names, repeat),
            breast_names=_stream(self.imaged.breast_names, repeat),
        )
        return Chain(subject, self.settings, frozenset(), IMAGES).with_settings(value.settings)

    def chain(self, value: Value, repeat: int, breast: Breast | None = None) -> Chain:
        """The chain from a breast to every answer, with random streams of its own for each repeat."""
        subject = replace(breast or self.breast, names=_stream(self.breast.names, repeat))
        return Chain(subject, self.settings, self.effects, PRODUCTS).with_settings(value.settings)


def _stream(names: tuple[str | int, ...], repeat: int) -> tuple[str | int, ...]:
    """Names of the streams of a repeat; the first has those of the study."""
    return names if repeat == 0 else (*names, "repeat", repeat)


def touched(products: Mapping[str, Product], settings: Collection[str]) -> frozenset[str]:
    """The products that some of these settings change, by themselves or by what they need."""
    found: set[str] = set()
    chain = Chain(None, {}, frozenset(), products)
    for name in products:
        for each in (name, *chain.upstream(name)):
            if any(_overlap(read, key) for read in products[each].reads for key in settings):
                found.add(name)
    return frozenset(found)


def _overlap(one: str, other: str) -> bool:
    """Whether two dotted names are the same or one lies in the other."""
    return f"{one}.".startswith(f"{other}.") or f"{other}.".startswith(f"{one}.")


def needed(names: Sequence[str]) -> frozenset[str]:
    """The products that quantities are made of."""
    chain = Chain(None, {}, frozenset(), PRODUCTS)
    ends = [end for quantity in quantities(list(names)).values() for end in quantity.products]
    return frozenset(each for end in ends for each in (*chain.upstream(end), end))


@dataclass
class Trial:
    """The last value of a knob; kept: what presses made, which cost too much to be repeated as often."""

    start: Start
    knob: Knob
    repeats: Mapping[str, int]
    kept: dict[str, Any] = field(default_factory=dict)
    kept_seconds: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.value = self.knob.values[-1]
        self.of_images = touched(IMAGES, self.value.settings)
        self.touched = frozenset(PRODUCTS) if self.of_images else touched(PRODUCTS, self.value.settings)
        self.presses = "pressed" in self.touched & needed(self.knob.quantities)
        self.untouched = {n: v for n, v in self.start.given.items() if n not in self.touched and n in PRODUCTS}
        if self.presses and self.value.today and not self.knob.random:
            self._keep(self.start.given, self.start.seconds)

    def rows(self) -> pd.DataFrame:
        """A row per quantity and repeat: answer_1 to answer_3, seconds, memory_mb, outcome, and the knob's."""
        self._warm_up()
        rows: list[dict[str, Any]] = []
        for repeat in range(self.repeats["others"]):
            rows += self._answers(repeat)
            if any(row["outcome"] != OK for row in rows):
                break
        table = pd.DataFrame(rows).assign(memory_mb=peak_memory_mb())
        about = {"stage": self.knob.stage, "knob": self.knob.name, "value": self.value.name}
        return pd.DataFrame(about | self._facts(), index=table.index).join(table)

    def _facts(self) -> dict[str, Any]:
        return {
            "size": self.value.size,
            "random": self.knob.random,
            "today": self.value.today,
            "reference": self.value.reference,
            "settings": self.value.text,
        }

    def _warm_up(self) -> None:
        """Load compiled kernels, by the draft, where no plate is pressed; a press takes much longer than they."""
        if not self.presses and not self.of_images:
            chain = self.start.chain(self.knob.values[0], 0).given(self.untouched)
            for quantity in quantities(list(self.knob.quantities)).values():
                try:
                    quantity.of(chain)
                except MammosimError as refusal:
                    log.info("the draft is refused: %s", refusal)

    def _answers(self, repeat: int) -> list[dict[str, Any]]:
        """Of one repeat."""
        breast, before = self.kept.get("breast"), {}
        if self.of_images and breast is None:
            images = self.start.images(self.value, repeat)
            found = images.make("breast")
            before = {name: t for name, t in images.seconds("breast").items() if name in self.of_images}
            if found.refusal is not None:
                return [self._refused(name, repeat, before, found.refusal) for name in self.knob.quantities]
            breast = found.value
        given = {name: value for name, value in (self.untouched | self.kept).items() if name in PRODUCTS}
        chain = self.start.chain(self.value, repeat, breast).given(given)
        rows = [self._answer(name, chain, repeat, before) for name in self.knob.quantities]
        if self.presses and not self.kept and repeat + 1 >= self.repeats["presses"] and not self.knob.random:
            made = {n: chain.make(n).value for n in products_mechanics.PRODUCTS if chain.key(n) in chain.made}
            self._keep(made | {"breast": breast}, before | chain.seconds("pressed") | chain.seconds("loaded"))
        return rows

    def _keep(self, products: Mapping[str, Any], seconds: Mapping[str, float]) -> None:
        """Products of the mechanics and the breast, for the repeats to come, with what they took."""
        names = {"breast", *products_mechanics.PRODUCTS}
        own = (self.touched & names) | self.of_images
        self.kept |= {name: value for name, value in products.items() if name in names}
        self.kept_seconds |= {name: t for name, t in seconds.items() if name in own}

    def _answer(self, name: str, chain: Chain, repeat: int, before: Mapping[str, float]) -> dict[str, Any]:
        quantity = quantities([name])[name]
        try:
            answer = np.atleast_1d(np.asarray(quantity.of(chain), float))
            outcome = OK
        except MammosimError as refusal:
            answer, outcome = np.full(1, np.nan), f"refused: {refusal}"
        if not np.all(np.isfinite(answer)) and outcome == OK:
            outcome = "refused: the answer is not a number"
        numbers = dict(zip(ANSWERS, np.pad(answer, (0, 3 - len(answer)), constant_values=np.nan)))
        return {"quantity": name, "repeat": repeat} | numbers | {
            "seconds": self._seconds(name, chain, before), "outcome": outcome
        }  # fmt: skip

    def _seconds(self, name: str, chain: Chain, before: Mapping[str, float]) -> float:
        """What the products of a quantity took that the knob touches."""
        taken = dict(self.kept_seconds) | dict(before)
        for product in quantities([name])[name].products:
            taken |= {n: t for n, t in chain.seconds(product).items() if n not in self.kept}
        asked = needed([name]) & self.touched | self.of_images
        return sum(t for n, t in taken.items() if n in asked)

    def _refused(
        self, name: str, repeat: int, seconds: Mapping[str, float], refusal: MammosimError
    ) -> dict[str, Any]:
        return {"quantity": name, "repeat": repeat} | dict.fromkeys(ANSWERS, np.nan) | {
            "seconds": sum(seconds.values()), "outcome": f"refused: {refusal}"
        }  # fmt: skip


def peak_memory_mb() -> float:
    """The largest resident memory of this process so far: interpreter, libraries, and all that it made."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
