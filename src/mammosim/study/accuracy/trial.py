"""One value of one knob tried on one breast: what is answered, and the processor time that it costs."""

import resource
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd

from mammosim.chain import imaging as products_images
from mammosim.chain import mechanics as products_mechanics
from mammosim.chain import xray as products_xray
from mammosim.chain.breast import Breast
from mammosim.chain.graph import Chain, Product
from mammosim.chain.imaging import Imaged
from mammosim.chain.quantities import quantities
from mammosim.core.errors import MammosimError
from mammosim.study.accuracy.knobs import Knob, Value

IMAGES: Mapping[str, Product] = products_images.PRODUCTS
PRODUCTS: Mapping[str, Product] = {**products_mechanics.PRODUCTS, **products_xray.PRODUCTS}
OK = "ok"
ANSWERS = ("answer_1", "answer_2", "answer_3")  # a place has three coordinates, the rest one number
MECHANICS = frozenset(products_mechanics.PRODUCTS)
# What takes long is repeated as often as presses: mechanics are kept for what follows, slices are an end.
COSTLY, COSTLY_END = frozenset({"mesh", "pressed"}), frozenset({"slices"})


@dataclass(frozen=True)
class Start:
    """Where trials begin: a breast, as its images and as they were labelled; today's settings and effects.

    given: products of the chain that were made at today's settings.
    """

    imaged: Imaged
    breast: Breast
    settings: Mapping[str, Any]
    effects: frozenset[str]
    given: Mapping[str, Any] = field(default_factory=dict)

    def images(self, value: Value, repeat: int) -> Chain:
        """The chain from the images to a breast; what the value leaves as it was is that of the breast."""
        subject = replace(
            self.imaged,
            names=_stream(self.imaged.names, repeat),
            breast_names=_stream(self.imaged.breast_names, repeat),
        )
        was = {"segmentation": self.breast.labels, "registration": self.breast.to_reference}
        kept = {name: each for name, each in was.items() if name not in touched(IMAGES, value.settings)}
        return Chain(subject, self.settings, frozenset(), IMAGES).with_settings(value.settings).given(kept)

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
    """The last value of a knob, tried as often as `repeats` says of presses and of others.

    kept, kept_seconds: the mechanics that are not made again, and what they took.
    """

    start: Start
    knob: Knob
    repeats: Mapping[str, int]
    kept: dict[str, Any] = field(default_factory=dict)
    kept_seconds: dict[str, float] = field(default_factory=dict)
    breast: Breast | None = None

    def __post_init__(self) -> None:
        value = self.knob.values[-1]
        self.of_images = touched(IMAGES, value.settings)
        self.touched = frozenset(PRODUCTS) if self.of_images else touched(PRODUCTS, value.settings)
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
        if not (ends or self.costly or self.of_images):
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
        chain = self.start.chain(self.knob.values[0], 0).given(self._given())
        for name in self.knob.quantities:
            answered(name, chain)

    def _given(self) -> dict[str, Any]:
        """The products that need not be made."""
        was = {n: each for n, each in self.start.given.items() if n not in self.touched}
        return {n: each for n, each in (was | self.kept).items() if n in PRODUCTS}

    def _repeat(self, repeat: int) -> list[dict[str, Any]]:
        """The rows of one repeat."""
        before: dict[str, float] = {}
        breast = self.breast
        if self.of_images and breast is None:
            images = self.start.images(self.value, repeat)
            labelled = images.make("breast")
            before = {name: t for name, t in images.seconds("breast").items() if name in self.of_images}
            if labelled.refusal is not None:
                return [
                    _row(name, repeat, refused(labelled.refusal), sum(before.values()))
                    for name in self.knob.quantities
                ]
            breast = labelled.value
        chain = self.start.chain(self.value, repeat, breast).given(self._given())
        rows = []
        for name in self.knob.quantities:
            answer = answered(name, chain)
            rows.append(_row(name, repeat, answer, self._seconds(name, chain, before)))
        if self.costly and not self.kept and repeat + 1 >= self.repeats["presses"]:
            made = {
                name: chain.make(name).value
                for name in MECHANICS & PRODUCTS.keys()
                if chain.key(name) in chain.made
            }
            self._keep(made, before | {n: t for name in made for n, t in chain.seconds(name).items()}, breast)
        return rows

    def _keep(self, products: Mapping[str, Any], seconds: Mapping[str, float], breast: Breast | None) -> None:
        """Products of the mechanics and the breast that they are of, for the repeats to come."""
        own = (self.touched & MECHANICS) | self.of_images
        self.kept = {name: each for name, each in products.items() if name in MECHANICS}
        self.kept_seconds = {name: t for name, t in seconds.items() if name in own}
        self.breast = breast

    def _seconds(self, name: str, chain: Chain, before: Mapping[str, float]) -> float:
        """What the products of a quantity took that the knob touches."""
        taken = self.kept_seconds | dict(before)
        for product in quantities([name])[name].products:
            taken |= {n: t for n, t in chain.seconds(product).items() if n not in self.kept}
        asked = (needed([name]) & self.touched) | self.of_images
        return sum(t for n, t in taken.items() if n in asked)


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
