"""Which values a varied setting takes: a list, named groups, a range, or the span that a design samples."""

import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mammosim.core.errors import ConfigurationError

DIGITS = 6  # significant ones of values that are computed: they read well, and name the same point tomorrow
LINEAR, LOG = "linear", "log"
SCALES = (LINEAR, LOG)
WHOLE = 1e15  # of larger numbers not every whole one is a float
AT_MOST = 100_000  # points of a campaign
CONTROL = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029]")  # what ends a line, or is no text
Shown = float | int | str | bool


@dataclass(frozen=True)
class Level:
    """One value of a setting: what tables show of it, and what it is, which may be a group."""

    shown: Shown
    value: Any


@dataclass(frozen=True)
class Span:
    """What a design samples of a setting, from low to high, evenly or evenly in its logarithm."""

    low: float
    high: float
    scale: str = LINEAR

    def at(self, share: float) -> float:
        """The value at a share of the span, 0 to 1."""
        if self.scale == LOG:
            return rounded(self.low * (self.high / self.low) ** share)
        return rounded(self.low + (self.high - self.low) * share)


@dataclass(frozen=True)
class Axis:
    """A varied setting by its dotted key: its levels, or the span that a design samples, and its scale."""

    key: str
    levels: tuple[Level, ...] = ()
    span: Span | None = None
    scale: str = LINEAR

    @property
    def is_numeric(self) -> bool:
        """Whether it can be drawn along a line: not where its values are names."""
        return all(is_number(level.shown) for level in self.levels)


@dataclass(frozen=True)
class Design:
    """How spans are sampled: by which kind, of how many points, from which seed."""

    kind: str
    number: int
    seed: int = 1


SOBOL, LATIN_HYPERCUBE, SALTELLI = "sobol", "latin_hypercube", "saltelli"
LEAST_SALTELLI = 2  # the interval of an index is of samples drawn from these
DESIGNS = (SOBOL, LATIN_HYPERCUBE, SALTELLI)


def is_number(value: Any) -> bool:
    """Whether it is a number, which true and false are not."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def is_finite(value: float | int) -> bool:
    """Whether a float can hold it, as it can neither hold nan nor a whole number of 400 digits."""
    return abs(value) <= sys.float_info.max


def rounded(value: float) -> float:
    """To DIGITS significant digits."""
    return float(f"{value:.{DIGITS}g}")


def axis(key: str, given: Any, place: str) -> Axis:
    """Of what stands under `vary`; place: file and key, for errors.

    Raises ConfigurationError for a list without values or with one twice, for what has no name, or one with
    a line break in it, a number that is not finite, a range without beginning, end or number or whose values
    cannot be told apart, and a logarithmic one that reaches 0.
    """
    if isinstance(given, Mapping):
        if "named" in given:
            return Axis(key, _named(given, place))
        return _range(key, given, place)
    if not isinstance(given, (list, tuple)) or not given:
        raise ConfigurationError(f"{place} = {given!r}: give a list of values, or {{from, to, number}}")
    if groups := [value for value in given if isinstance(value, (Mapping, list, tuple))]:
        raise ConfigurationError(
            f"{place} has the group {groups[0]!r}; name it, as {{named: {{a: ..., b: ...}}}}"
        )
    if None in given:
        raise ConfigurationError(f"{place} has an empty value; name it, as {{named: {{none: null, a: 10}}}}")
    if endless := [value for value in given if is_number(value) and not is_finite(value)]:
        raise ConfigurationError(f"{place} has {endless[0]!r}, which is no finite number; leave it out")
    return Axis(key, _once([Level(_plain(value), _plain(value)) for value in given], place))


def _plain(value: Any) -> Any:
    """The number itself, whether it is written with a point or without, or too long for a whole one."""
    if not is_number(value) or not is_finite(value) or value != int(value):
        return value
    return int(value) if abs(value) < WHOLE else float(value)


def _named(given: Mapping[str, Any], place: str) -> tuple[Level, ...]:
    groups = given["named"]
    if set(given) != {"named"} or not isinstance(groups, Mapping) or not groups:
        raise ConfigurationError(f"{place}: named = {groups!r}: give {{named: {{a: ..., b: ...}}}} alone")
    if not all(str(name).strip() for name in groups):
        raise ConfigurationError(f"{place}: named: an empty name; write one")
    return _once([Level(str(name), value) for name, value in groups.items()], place)


def _once(levels: Sequence[Level], place: str) -> tuple[Level, ...]:
    shown = [level.shown for level in levels]
    if twice := [value for n, value in enumerate(shown) if value in shown[:n]]:
        raise ConfigurationError(f"{place} has {twice[0]!r} twice; keep one")
    if broken := [value for value in shown if isinstance(value, str) and CONTROL.search(value)]:
        raise ConfigurationError(
            f"{place} has {broken[0]!r}: no line of a table has such a character; leave it out"
        )
    return tuple(levels)


def _range(key: str, given: Mapping[str, Any], place: str) -> Axis:
    if unknown := set(given) - {"from", "to", "number", "scale"}:
        raise ConfigurationError(
            f"{place} has no key {min(unknown)!r}; a range has from, to, number and scale"
        )
    for end, words in (("from", "beginning"), ("to", "end")):
        if end not in given:
            raise ConfigurationError(f"{place} has no {words}: add `{end}:`")
        if not is_number(given[end]) or not is_finite(given[end]):
            raise ConfigurationError(f"{place}.{end} = {given[end]!r} is no finite number; write one")
    low, high, scale = given["from"], given["to"], given.get("scale", LINEAR)
    if scale not in SCALES:
        raise ConfigurationError(f"{place}.scale = {scale!r}: choose one of: {', '.join(SCALES)}")
    if not low < high:
        raise ConfigurationError(f"{place}: from = {low:g} is not below to = {high:g}; exchange them")
    if scale == LOG and low <= 0:
        raise ConfigurationError(f"{place}.from = {low:g}: a logarithmic range begins above 0; raise it")
    if rounded(low) == rounded(high):
        raise ConfigurationError(f"{place}: {low!r} and {high!r} are one value of {DIGITS} digits; widen it")
    if "number" not in given:
        return Axis(key, span=Span(low, high, scale), scale=scale)
    return Axis(key, _spaced(low, high, _number(given["number"], place), scale, place), scale=scale)


def _number(number: Any, place: str) -> int:
    number = _plain(number)
    if not isinstance(number, int) or isinstance(number, bool) or number < 2:
        raise ConfigurationError(f"{place}.number = {number!r}: write a whole number of 2 or more")
    if number > AT_MOST:
        raise ConfigurationError(f"{place}.number = {number:,} is more than {AT_MOST:,}; ask for fewer")
    return number


def _spaced(low: float, high: float, number: int, scale: str, place: str) -> tuple[Level, ...]:
    values = (np.geomspace if scale == LOG else np.linspace)(low, high, number)
    shown = dict.fromkeys(_plain(rounded(float(value))) for value in values)
    if len(shown) < number:
        raise ConfigurationError(
            f"{place}: {low!r} to {high!r} has {len(shown)} values of {DIGITS} digits and not {number}; "
            "widen it, or ask for fewer"
        )
    return tuple(Level(value, value) for value in shown)


def design(given: Any, place: str) -> Design:
    """Of what stands under `design`. Raises ConfigurationError for anything but one of DESIGNS and a seed."""
    kinds = [key for key in given if key != "seed"] if isinstance(given, Mapping) else []
    if len(kinds) != 1 or kinds[0] not in DESIGNS:
        raise ConfigurationError(f"{place} = {given!r}: write one of {', '.join(DESIGNS)}, as {{sobol: 256}}")
    number, seed = (
        each if isinstance(each, int) else _plain(each) for each in (given[kinds[0]], given.get("seed", 1))
    )
    for name, value in ((kinds[0], number), ("seed", seed)):
        if not isinstance(value, int) or isinstance(value, bool) or value < 1:
            raise ConfigurationError(f"{place}.{name} = {value!r}: write a whole number above 0")
    if number <= AT_MOST and kinds[0] != LATIN_HYPERCUBE and number & (number - 1):
        near = 1 << (number.bit_length() - 1)
        raise ConfigurationError(
            f"{place}.{kinds[0]} = {number}: its balance needs a power of two; write {near} or {2 * near}"
        )
    if kinds[0] == SALTELLI and number < LEAST_SALTELLI:
        raise ConfigurationError(f"{place}.{SALTELLI} = {number}: no interval is had of one; write 64")
    return Design(kinds[0], number, seed)


def size(how: Design, axes: int) -> int:
    """How many points a design has of so many spans."""
    return how.number * (axes + 2) if how.kind == SALTELLI else how.number


def sampled(how: Design, spans: Mapping[str, Span]) -> list[dict[str, float]]:
    """The points of a design: key -> value. A Sobol sequence of more points begins with those of fewer.

    Of Saltelli's design (Saltelli 2010): A and B, then for each setting in turn A with that one of B.
    """
    shares = _shares(how, len(spans))
    return [{key: span.at(float(share)) for (key, span), share in zip(spans.items(), row)} for row in shares]


def _shares(how: Design, d: int) -> np.ndarray:
    """In the unit cube (n, d)."""
    from scipy.stats import qmc  # only where a campaign has a design: this takes half a second

    if how.kind == LATIN_HYPERCUBE:
        return np.asarray(qmc.LatinHypercube(d, rng=how.seed).random(how.number))
    if how.kind == SOBOL:
        return np.asarray(qmc.Sobol(d, rng=how.seed).random(how.number))
    both = qmc.Sobol(2 * d, rng=how.seed, bits=64).random(how.number)
    A, B = both[:, :d], both[:, d:]
    mixed = np.repeat(A[None], d, axis=0)
    for i in range(d):
        mixed[i, :, i] = B[:, i]
    return np.concatenate([A, B, *mixed])
