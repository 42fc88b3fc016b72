"""Settings as frozen dataclasses, whose annotations say what may stand there, and their reader.

    radius_mm: Annotated[float, Limits(above=0, at_most=1000)]

A dataclass asks for its own keys, a Mapping takes those of its annotation; tuple[T, ...] is a list. Numbers
are finite unless their Limits say otherwise.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, is_dataclass
from difflib import get_close_matches
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints, overload

import numpy as np

from mammosim.core.errors import ConfigurationError, MammosimError


@dataclass(frozen=True)
class Limits:
    """Of a number: above < x < below, at_least <= x <= at_most; advice: why it may have left them."""

    above: float = -np.inf
    below: float = np.inf
    at_least: float = -np.inf
    at_most: float = np.inf
    finite: bool = True
    advice: str = ""

    def require(self, x: float, place: str) -> None:
        """Raise ConfigurationError for a number outside."""
        if self.finite and not np.isfinite(x):
            raise ConfigurationError(f"{place} = {x:g} is not a finite number; write one")
        if self.finite and not (self.above < x < self.below and self.at_least <= x <= self.at_most):
            low = f"({self.above:g}" if self.above >= self.at_least else f"[{self.at_least:g}"
            high = f"{self.below:g})" if self.below <= self.at_most else f"{self.at_most:g}]"
            raise ConfigurationError(
                f"{place} = {x:g} is outside {low}, {high}; {self.advice or 'change it'}"
            )


T = TypeVar("T")
FINITE = Limits()
_NAMES = {float: "a number", int: "a whole number", bool: "true or false", str: "a word"}
# For values that another part of the program is to reject.
Unchecked = Annotated[float, Limits(finite=False)]
Positive = Annotated[float, Limits(above=0)]
NotNegative = Annotated[float, Limits(at_least=0)]
Count = Annotated[int, Limits(at_least=1)]
Triple = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class OneOf:
    """One of several classes by name: {name: values}; or, with a key, {key: name, and its values}."""

    kinds: Mapping[str, type]
    key: str = ""


@dataclass(frozen=True, eq=False)
class SomeOf:
    """A tuple of one or more of several classes, as {name: values, name: values}."""

    kinds: Mapping[str, type]


class Settings:
    """Base of frozen dataclasses that guard their validity by raising ConfigurationError."""

    def __post_init__(self) -> None:
        """Each field as its annotation has it: lists become tuples, whole numbers floats."""
        for name, kind in annotations(type(self)).items():
            object.__setattr__(self, name, read(kind, getattr(self, name), name))


@overload
def read(kind: type[T], value: Any, place: str) -> T: ...
@overload
def read(kind: Any, value: Any, place: str) -> Any: ...
def read(kind: Any, value: Any, place: str) -> Any:
    """Plain values as the class or annotation `kind`; place: the path of keys, named in errors.

    Raises ConfigurationError for an unknown or missing key, another type, a number not finite or outside.
    """
    origin, inside = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return _annotated(inside[0], inside[1], value, place)
    if origin in (Union, UnionType):
        return _of_any([k for k in inside if k is not np.ndarray], value, place)
    if origin is Literal:
        if value not in inside:
            raise ConfigurationError(f"{place} = {value!r}: choose one of: {', '.join(map(str, inside))}")
        return value
    if origin is tuple:
        return _list(inside, value, place)
    if kind is Any:
        return value
    if is_dataclass(kind) and isinstance(kind, type):
        return value if isinstance(value, kind) else _object(kind, value, place)
    if origin is Mapping:
        pairs = _mapping(value, place).items()
        return {read(inside[0], k, f"a key of {place}"): read(inside[1], v, f"{place}.{k}") for k, v in pairs}
    return _plain(kind, value, place, FINITE)


def looked_up(kind: type[T], setting: Callable[[str], Any], place: str) -> T:
    """As read, each setting of the class looked up by its dotted name, `{place}.{name}`."""
    return read(kind, {name: setting(f"{place}.{name}") for name in annotations(kind)}, place)


def words(value: Any) -> str:
    """Settings in one line, without what is not set."""
    if is_dataclass(value):
        given = {f.name: getattr(value, f.name) for f in fields(value)}
        return ", ".join(f"{n.replace('_', ' ')} {words(v)}" for n, v in given.items() if v is not None)
    if isinstance(value, tuple):
        return " ".join(map(words, value))
    return f"{value:g}" if isinstance(value, (int, float)) else str(value)


def named_words(value: Any) -> str:
    """And the name of the class: RigidSlip(...) as `rigid slip ...`."""
    return f"{re.sub('(?<!^)(?=[A-Z])', ' ', type(value).__name__).lower()} {words(value)}"


def annotations(kind: type) -> dict[str, Any]:
    """The annotation of each field that a dataclass is made of."""
    hints = get_type_hints(kind, include_extras=True)
    return {f.name: hints[f.name] for f in fields(kind) if f.init}


def _of_any(kinds: Sequence[Any], value: Any, place: str) -> Any:
    """A value of the first kind that takes it; what the first one says where none does."""
    if value is None and NoneType in kinds:
        return None
    errors = []
    for kind in (kind for kind in kinds if kind is not NoneType):
        try:
            return read(kind, value, place)
        except ConfigurationError as error:
            errors.append(error)
    raise errors[0]


def _annotated(kind: Any, about: Any, value: Any, place: str) -> Any:
    if isinstance(about, Limits):
        return _plain(kind, value, place, about)
    kinds, several = tuple(about.kinds.values()), isinstance(about, SomeOf) and isinstance(value, tuple)
    if isinstance(value, kinds) or (several and all(isinstance(one, kinds) for one in value)):
        return value
    given = dict(_mapping(value, place))
    if isinstance(about, OneOf) and about.key:
        return _named(about.kinds, given.pop(about.key, None), given, place)
    if not given or (len(given) > 1 and isinstance(about, OneOf)):
        raise ConfigurationError(f"{place} has {len(given)} keys; give one of: {', '.join(about.kinds)}")
    found = tuple(_named(about.kinds, name, v, f"{place}.{name}") for name, v in given.items())
    return found[0] if isinstance(about, OneOf) else found


def _named(kinds: Mapping[str, type], name: Any, values: Any, place: str) -> Any:
    if not isinstance(name, str) or name not in kinds:
        raise ConfigurationError(f"{place}: {name!r} is unknown; choose one of: {', '.join(kinds)}")
    return _object(kinds[name], values, place)


def _mapping(value: Any, place: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise ConfigurationError(f"{place} = {value!r} has no keys; write them as `key: value`")
    return value


def _object(kind: type, value: Any, place: str) -> Any:
    known, given = annotations(kind), _mapping(value, place)
    for key in given.keys() - known.keys():
        near = get_close_matches(str(key), known, n=1)
        advice = f"did you mean {near[0]!r}?" if near else f"choose one of: {', '.join(known) or 'none'}"
        raise ConfigurationError(f"{place} has no key {key!r}; {advice}")
    needed = [
        f.name for f in fields(kind) if f.init and f.default is MISSING and f.default_factory is MISSING
    ]
    if absent := [name for name in needed if name not in given]:
        raise ConfigurationError(f"{place} lacks {', '.join(absent)}; add it")
    values = {key: read(known[key], v, f"{place}.{key}") for key, v in given.items()}
    try:
        return kind(**values)
    except MammosimError as error:
        raise ConfigurationError(f"{place}: {error}") from None


def _list(inside: tuple[Any, ...], value: Any, place: str) -> tuple[Any, ...]:
    if not isinstance(value, (list, tuple)):
        raise ConfigurationError(f"{place} = {value!r} is no list; write [...]")
    kinds = inside[:1] * len(value) if inside[-1] is Ellipsis else inside
    if len(value) != len(kinds):
        raise ConfigurationError(f"{place} has {len(value)} values; write {len(kinds)}")
    return tuple(read(kind, v, f"{place}[{i}]") for i, (kind, v) in enumerate(zip(kinds, value)))


def _plain(kind: Any, value: Any, place: str, limits: Limits) -> Any:
    wanted = (int, float, np.integer, np.floating) if kind is float else (kind,)
    if not isinstance(value, wanted) or (isinstance(value, bool) and kind is not bool):
        raise ConfigurationError(
            f"{place} = {value!r} is of type {type(value).__name__}; write {_NAMES.get(kind, kind.__name__)}"
        )
    if kind in (int, float):
        limits.require(_float(value), place)
    return _float(value) if kind is float else value


def _float(x: Any) -> float:
    """As a float; a whole number that none can hold is infinite."""
    try:
        return float(x)
    except OverflowError:
        return np.inf if x > 0 else -np.inf


def require_within(name: str, value: float, low: float, high: float, advice: str = "change it") -> None:
    """Raise ConfigurationError unless low <= value <= high."""
    Limits(at_least=low, at_most=high, advice=advice).require(value, name)


def require_positive(settings: object, *names: str) -> None:
    """Raise ConfigurationError unless the settings with these names are above 0 and finite."""
    for name in names:
        Limits(above=0).require(getattr(settings, name), name)
