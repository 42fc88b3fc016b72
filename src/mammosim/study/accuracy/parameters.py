"""Numerical parameters: settings of the chain that trade accuracy for time, from draft to reference."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from typing import Literal

from mammosim.chain.graph import Chain, nested, pruned
from mammosim.chain.quantities import quantities
from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import Count, Positive, Settings, read

Nested = Mapping[str, object]  # settings of the chain as its configuration has them, groups in groups
# What error and cost are fitted against, from the number that a value is.
SIZES = {"value": lambda number: float(number), "inverse": lambda number: 1 / float(number)}


@dataclass(frozen=True)
class Overrides(Settings):
    """Settings of the chain in place of the study's; text: JSON, dotted name -> value, sorted by names."""

    text: str

    def __post_init__(self) -> None:
        super().__post_init__()
        try:
            named = isinstance(self.by_name, dict) and bool(self.by_name)
        except ValueError:
            named = False
        if not named:
            raise ConfigurationError(
                f"{self.text!r} sets nothing; write dotted names of settings with values"
            )

    @classmethod
    def of(cls, by_name: object, place: str) -> "Overrides":
        """Of settings by their dotted names. Raises ConfigurationError for values not plain or finite."""
        try:
            return read(cls, {"text": json.dumps(by_name, sort_keys=True, allow_nan=False)}, place)
        except (TypeError, ValueError):
            raise ConfigurationError(f"{place}: {by_name} is not plain and finite; write what is") from None

    @property
    def by_name(self) -> dict[str, object]:
        """Dotted name -> value."""
        found: dict[str, object] = json.loads(self.text)
        return found

    def hold_in(self, settings: Nested) -> bool:
        """Whether nested settings have all of these values."""
        return pruned(settings, self.by_name) == nested(self.by_name)


@dataclass(frozen=True)
class Load(Settings):
    """Where the nipple is asked, and how the breast is pressed."""

    position: str
    strategy: str


@dataclass(frozen=True)
class Repeats(Settings):
    """How often a value is tried: where something long ends in presses, and everything else."""

    presses: Count
    others: Count


@dataclass(frozen=True)
class Entry(Settings):
    """What the file says of one parameter: its values, from draft to reference, and whose error is looked at.

    stage: the part of the chain; size: of SIZES, or the name of a number in the values; sizes: in its place,
    one per value.
    """

    stage: str
    values: tuple[Overrides, ...]
    quantities: tuple[str, ...]
    kind: Literal["deterministic", "stochastic"]
    size: str | None = None
    sizes: tuple[Positive, ...] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        quantities(list(self.quantities))
        if len(self.values) < 2:
            raise ConfigurationError(f"{len(self.values)} values; give two at least, from draft to reference")
        if len({tuple(value.by_name) for value in self.values}) > 1:
            raise ConfigurationError("its values do not all set the same settings; let each set all of them")
        if self.sizes is not None and len(self.sizes) != len(self.values):
            raise ConfigurationError(
                f"{len(self.sizes)} sizes for {len(self.values)} values; give each one its size"
            )

    @classmethod
    def of(cls, given: Mapping[str, object], place: str) -> "Entry":
        """Of the values of the file: of one `setting`, or each a mapping of dotted names."""
        rest = {key: value for key, value in given.items() if key != "setting"}
        if isinstance(values := given.get("values"), list):
            each = values if "setting" not in given else [{given["setting"]: value} for value in values]
            rest["values"] = [Overrides.of(one, f"{place}.values[{n}]") for n, one in enumerate(each)]
        return read(cls, rest, place)


@dataclass(frozen=True)
class AccuracySettings(Settings):
    """What is tried, on whose breast, how often; presets: name -> quantity -> tolerance in its unit."""

    volunteer: str
    side: Literal["left", "right"]
    load: Load
    repeats: Repeats
    presets: Mapping[str, Mapping[str, Positive]]
    parameters: Mapping[str, Entry]

    def __post_init__(self) -> None:
        super().__post_init__()
        for limits in self.presets.values():
            quantities(list(limits))

    @classmethod
    def of(cls, given: Mapping[str, object]) -> "AccuracySettings":
        """Of the values of config/accuracy/parameters.yaml."""
        entries = given.get("parameters")
        if isinstance(entries, Mapping):
            found = {name: Entry.of(entry, f"parameters.{name}") for name, entry in entries.items()}
            given = {**given, "parameters": found}
        return read(cls, given, "accuracy")


@dataclass(frozen=True)
class Value(Settings):
    """One value of a parameter; size: None where it is not a number.

    today: whether the configuration has it; reference: whether the others are measured by it.
    """

    name: str
    settings: Overrides
    size: float | None = None
    today: bool = False
    reference: bool = False


@dataclass(frozen=True)
class NumericalParameter(Settings):
    """values: from draft to reference, one of them today's; stochastic: whether its error is stochastic."""

    name: str
    stage: str
    quantities: tuple[str, ...]
    values: tuple[Value, ...]
    stochastic: bool = False

    def alone(self, name: str) -> dict[str, object]:
        """Of one of its values and of the draft, as plain values: what a trial of the value depends on."""
        return asdict(replace(self, values=(self.values[0], self.value(name))))

    def value(self, name: str) -> Value:
        """The value with this name. Raises ConfigurationError when there is none."""
        for value in self.values:
            if value.name == name:
                return value
        known = ", ".join(value.name for value in self.values)
        raise ConfigurationError(f"the parameter {self.name} has no value {name!r}; choose one of: {known}")

    @classmethod
    def of(cls, name: str, entry: Entry, settings: Nested) -> "NumericalParameter":
        """Of its entry; settings: today's.

        Today's value is put in its place by size where the entry lacks it.
        Raises ConfigurationError for a setting that is not there, for an unknown size, and for sizes that do
        not fall from draft to reference.
        """
        chain = Chain(None, settings, frozenset(), {})
        today = Overrides.of({key: chain.setting(key) for key in entry.values[0].by_name}, name)
        sizes = entry.sizes or [_size(value, entry.size) for value in entry.values]
        values = [
            Value(_name(value), value, size, value.hold_in(settings))
            for value, size in zip(entry.values, sizes)
        ]
        if not any(value.today for value in values):
            if entry.sizes is not None:
                raise ConfigurationError(
                    f"{name}: today's {_name(today)} is not among its values; add it, with its size"
                )
            values = _with_today(values, Value(_name(today), today, _size(today, entry.size), True))
        _require_falling(name, [value.size for value in values if value.size is not None])
        values[-1] = replace(values[-1], reference=True)
        return cls(name, entry.stage, entry.quantities, tuple(values), entry.kind == "stochastic")


def parameters(entries: Mapping[str, Entry], settings: Nested) -> Mapping[str, NumericalParameter]:
    """The numerical parameters of a file; settings: today's."""
    return {name: NumericalParameter.of(name, entry, settings) for name, entry in entries.items()}


def _size(overrides: Overrides, word: str | None) -> float | None:
    """By the word `size` of an entry: value, inverse, or the name of one of the numbers in the value."""
    value = next(iter(overrides.by_name.values()))
    if word is None:
        return None
    if isinstance(value, Mapping) and word in value:
        return float(value[word])
    if word in SIZES and isinstance(value, int | float):
        return SIZES[word](value)
    known = [*value] if isinstance(value, Mapping) else [*SIZES]
    raise ConfigurationError(f"no size {word!r} in {value}; choose one of: {', '.join(known)}")


def _require_falling(name: str, sizes: Sequence[float]) -> None:
    if not all(coarser > finer for coarser, finer in pairwise(sizes)):
        words = ", ".join(f"{size:g}" for size in sizes)
        raise ConfigurationError(
            f"{name}: sizes {words} do not fall from draft to reference; order its values"
        )


def _name(overrides: Overrides) -> str:
    return "_".join(_word(value) for value in overrides.by_name.values())


def _word(value: object) -> str:
    if isinstance(value, Mapping):
        return "_".join(_word(each) for each in value.values())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return "_".join(_word(each) for each in value)
    return f"{value:g}" if isinstance(value, (int, float)) else str(value)


def _with_today(values: list[Value], today: Value) -> list[Value]:
    """Before the first that is finer; before the reference where there are no sizes."""
    if today.size is None:
        return [*values[:-1], today, values[-1]]
    finer = (
        place for place, value in enumerate(values) if value.size is not None and value.size < today.size
    )
    place = next(finer, len(values))
    return [*values[:place], today, *values[place:]]
