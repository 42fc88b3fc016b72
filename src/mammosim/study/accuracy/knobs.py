"""Knobs of the chain: settings that trade accuracy for time, each with values from draft to reference."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from mammosim.chain.graph import Chain
from mammosim.chain.quantities import quantities
from mammosim.core.errors import ConfigurationError

# What error and cost are fitted against, from the number that a value is.
SIZES = {"value": lambda number: float(number), "inverse": lambda number: 1 / float(number)}


@dataclass(frozen=True)
class Value:
    """One setting of a knob: settings, dotted name -> value; size: NaN where it is not a number.

    today: whether the configuration has it; reference: whether the others are measured by it.
    """

    name: str
    settings: Mapping[str, Any]
    size: float = np.nan
    today: bool = False
    reference: bool = False

    @property
    def text(self) -> str:
        """The settings as JSON, the same for the same settings."""
        return json.dumps(self.settings, sort_keys=True)


@dataclass(frozen=True)
class Knob:
    """values: from draft to reference, one of them today's; random: whether its error is that of chance."""

    name: str
    stage: str
    quantities: tuple[str, ...]
    values: tuple[Value, ...]
    random: bool = False

    def alone(self, name: str) -> dict[str, Any]:
        """Of one of its values and of the draft, as plain values: what a trial of the value depends on."""
        return asdict(replace(self, values=(self.values[0], self.value(name))))

    @classmethod
    def plain(cls, given: Mapping[str, Any]) -> "Knob":
        """The inverse of `alone`."""
        return cls(**{**given, "values": tuple(Value(**value) for value in given["values"])})

    def value(self, name: str) -> Value:
        """The value with this name. Raises ConfigurationError when there is none."""
        for value in self.values:
            if value.name == name:
                return value
        known = ", ".join(value.name for value in self.values)
        raise ConfigurationError(f"the knob {self.name} has no value {name!r}; choose one of: {known}")

    @classmethod
    def of(cls, name: str, given: Mapping[str, Any], settings: Mapping[str, Any]) -> "Knob":
        """The knob of one entry of config/accuracy/knobs.yaml; settings: today's, nested.

        Today's value is put in its place by size where the entry lacks it.
        Raises ConfigurationError for a setting that is not there, for an unknown quantity or size, and for
        sizes that do not fall from draft to reference.
        """
        quantities(given["quantities"])
        values = _values(given)
        chain = Chain(None, settings, frozenset(), {})
        today = {key: chain.setting(key) for key in values[0].settings}
        marked = [replace(value, today=value.settings == today) for value in values]
        if not any(value.today for value in marked):
            if "sizes" in given:
                raise ConfigurationError(
                    f"{name}: today's {_word(today)} is not among its values; add it, with its size"
                )
            marked = _with_today(marked, _named(today, given, None))
        _require_falling(name, [value.size for value in marked])
        marked[-1] = replace(marked[-1], reference=True)
        return cls(name, given["stage"], tuple(given["quantities"]), tuple(marked), given["kind"] == "random")


def knobs(given: Mapping[str, Any], settings: Mapping[str, Any]) -> Mapping[str, Knob]:
    """The knobs of config/accuracy/knobs.yaml."""
    return {name: Knob.of(name, entry, settings) for name, entry in given.items()}


def _values(given: Mapping[str, Any]) -> list[Value]:
    """Those of an entry: of one setting, or each a mapping of dotted names."""
    sizes = given.get("sizes", [None] * len(given["values"]))
    if len(sizes) != len(given["values"]):
        raise ConfigurationError(
            f"{len(sizes)} sizes for {len(given['values'])} values; give each one its size"
        )
    several = "setting" not in given
    each = [value if several else {given["setting"]: value} for value in given["values"]]
    return [_named(value, given, size) for value, size in zip(each, sizes)]


def _named(settings: Mapping[str, Any], given: Mapping[str, Any], size: float | None) -> Value:
    name = "_".join(_word(value) for value in settings.values())
    return Value(name, settings, _size(settings, given) if size is None else float(size))


def _size(settings: Mapping[str, Any], given: Mapping[str, Any]) -> float:
    """By the word `size` of the entry: value, inverse, or the name of one of the numbers in the value."""
    word = given.get("size")
    if word is None:
        return float("nan")
    value = next(iter(settings.values()))
    if word in SIZES:
        return SIZES[word](value)
    if not isinstance(value, Mapping) or word not in value:
        known = [*SIZES, *(value if isinstance(value, Mapping) else ())]
        raise ConfigurationError(f"no size {word!r} in {value}; choose one of: {', '.join(known)}")
    return float(value[word])


def _require_falling(name: str, sizes: Sequence[float]) -> None:
    if not np.all(np.isnan(sizes)) and not np.all(np.diff(sizes) < 0):
        words = ", ".join(f"{size:g}" for size in sizes)
        raise ConfigurationError(
            f"{name}: sizes {words} do not fall from draft to reference; order its values"
        )


def _word(value: Any) -> str:
    if isinstance(value, Mapping):
        return "_".join(_word(each) for each in value.values())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return "_".join(_word(each) for each in value)
    return f"{value:g}" if isinstance(value, (int, float)) else str(value)


def _with_today(values: list[Value], today: Value) -> list[Value]:
    """Before the first that is finer; before the reference where there are no sizes."""
    finer = [place for place, value in enumerate(values) if value.size < today.size]
    place = finer[0] if finer else len(values) if np.isfinite(today.size) else len(values) - 1
    return [*values[:place], replace(today, today=True), *values[place:]]
