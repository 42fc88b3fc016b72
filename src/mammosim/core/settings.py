"""Settings as frozen dataclasses, read from nested plain values: every key and every value is checked.

A class says what a group of settings holds, by the names and types of its fields, and guards their limits in
its own __post_init__; whoever has its object needs no further check.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields, is_dataclass
from types import NoneType, UnionType
from typing import Any, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import numpy as np

from mammosim.core.errors import ConfigurationError, MammosimError

T = TypeVar("T")
WORDS = {float: "a finite number", int: "a whole number", str: "a word", bool: "true or false"}


def read(kind: type[T], values: Any, *, at: str) -> T:
    """An object of a dataclass from a mapping of its fields' names; one with a default may be left out.

    at: the dotted name of the mapping, from which that of each value follows. Raises ConfigurationError for a
    missing or an unknown key, a value of another type or that is not finite, and what the class rejects.
    """
    names = settings_of(kind)
    if not isinstance(values, Mapping):
        raise ConfigurationError(f"{at} = {values!r} is no group of settings; give: {', '.join(names)}")
    missing, unknown = (
        [name for name in _needed(kind) if name not in values],
        sorted(set(values) - set(names)),
    )
    if missing or unknown:
        raise ConfigurationError(
            f"{at}: missing {missing}, unknown {unknown}; give exactly: {', '.join(names)}"
        )
    hints = get_type_hints(kind)
    given = {name: read_value(hints[name], values[name], at=f"{at}.{name}") for name in values}
    try:
        return kind(**given)
    except MammosimError as error:
        raise ConfigurationError(f"{at}: {error}") from error


def looked_up(kind: type[T], setting: Callable[[str], Any], at: str) -> T:
    """As read, each setting of the class looked up by its dotted name, `{at}.{name}`."""
    return read(kind, {name: setting(f"{at}.{name}") for name in settings_of(kind)}, at=at)


def settings_of(kind: type) -> tuple[str, ...]:
    """The names of the settings that a dataclass holds."""
    return tuple(field.name for field in fields(cast(Any, kind)) if field.init)


def _needed(kind: type) -> tuple[str, ...]:
    return tuple(
        field.name
        for field in fields(cast(Any, kind))
        if field.init and field.default is MISSING and field.default_factory is MISSING
    )


def read_value(hint: Any, value: Any, *, at: str) -> Any:
    """A value of a type: number, text, list, mapping or dataclass. Raises ConfigurationError as read does."""
    origin = get_origin(hint)
    if origin in (Union, UnionType):
        return _of_any(get_args(hint), value, at)
    if origin is tuple:
        return _tuple(get_args(hint), value, at)
    if origin is not None and issubclass(origin, Mapping):
        return _mapping(get_args(hint)[1], value, at)
    if is_dataclass(hint):
        return value if isinstance(value, cast(type, hint)) else read(cast(type, hint), value, at=at)
    if not _is(hint, value):
        raise ConfigurationError(f"{at} = {value!r} must be {WORDS.get(hint, hint)}; correct it")
    return value


def _is(hint: Any, value: Any) -> bool:
    if hint is float:
        number = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
        return number and math.isfinite(value)
    if hint is int:
        return isinstance(value, int | np.integer) and not isinstance(value, bool)
    return hint is Any or isinstance(value, hint)


def _of_any(hints: tuple[Any, ...], value: Any, at: str) -> Any:
    """A value of the first type that it has; raises what the first one says where it has none."""
    if value is None and NoneType in hints:
        return None
    errors = []
    for hint in (hint for hint in hints if hint is not NoneType):
        try:
            return read_value(hint, value, at=at)
        except ConfigurationError as error:
            errors.append(error)
    raise errors[0]


def _tuple(hints: tuple[Any, ...], value: Any, at: str) -> tuple[Any, ...]:
    if not isinstance(value, list | tuple):
        raise ConfigurationError(f"{at} = {value!r} must be a list")
    each = (hints[0],) * len(value) if hints[-1] is Ellipsis else hints
    if len(value) != len(each):
        raise ConfigurationError(f"{at} = {list(value)!r} must be a list of {len(each)} values")
    return tuple(read_value(hint, part, at=f"{at}[{n}]") for n, (hint, part) in enumerate(zip(each, value)))


def _mapping(hint: Any, value: Any, at: str) -> dict[str, Any]:
    if not isinstance(value, Mapping):
        raise ConfigurationError(f"{at} = {value!r} must be a mapping of names to values")
    return {str(name): read_value(hint, part, at=f"{at}.{name}") for name, part in value.items()}


def require_within(name: str, value: float, low: float, high: float, advice: str = "correct it") -> None:
    """Raise ConfigurationError unless low <= value <= high."""
    if not low <= value <= high:
        raise ConfigurationError(f"{name} = {value:g} is outside [{low:g}, {high:g}]; {advice}")


def require_positive(settings: object, *names: str) -> None:
    """Raise ConfigurationError unless the settings with these names are above 0 and finite."""
    for name in names:
        if not 0 < getattr(settings, name) < math.inf:
            raise ConfigurationError(
                f"{name} = {getattr(settings, name):g} must be above 0 and finite; correct it"
            )
