"""A campaign: whose breasts, which settings take which values, what is asked, and what is left out."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property
from itertools import permutations, product
from math import prod
from typing import Any

from mammosim.chain.conditions import UNDER_GRAVITY
from mammosim.chain.graph import upstream
from mammosim.chain.quantities import QUANTITIES
from mammosim.chain.stages import STAGES
from mammosim.core.errors import ConfigurationError
from mammosim.study.campaigns.axes import AT_MOST, Axis, Design, Level, Shown, axis, design, sampled, size
from mammosim.study.campaigns.conditions import Condition
from mammosim.study.campaigns.settings import Known, depends

# Quantities by what their values are called in the unit of the table: 'agd_mgy' for 'agd_percent'.
ASKED: Mapping[str, str] = {quantity.column or name: name for name, quantity in QUANTITIES.items()}
LOADS = ("position", "strategy")
DEFAULT_LOAD = {"strategy": "standard", "moduli": UNDER_GRAVITY}
STRESS_FREE = "stress_free"  # what says by what all moduli of a woman were multiplied
EXAMPLE = "asked: [force_n]"


@dataclass(frozen=True)
class Point:
    """shown: column -> what the table has; values: setting -> its value."""

    shown: Mapping[str, Shown]
    values: Mapping[str, Any]


@dataclass(frozen=True)
class Campaign:
    """subjects: (volunteer, side); load: position, strategy and moduli by name, where they do not vary.

    tissues: a file of config/tissues, the study's if empty; accuracy: a preset, or study; settings: nested,
    in place of the study's; asked: keys of ASKED; file: where it stands, for errors.
    """

    name: str
    title: str
    subjects: tuple[tuple[str, str], ...]
    load: Mapping[str, str]
    tissues: str
    accuracy: str
    settings: Mapping[str, Any]
    axes: tuple[Axis, ...]
    design: Design | None
    asked: tuple[str, ...]
    exclude: tuple[Condition, ...]
    file: str = ""

    @classmethod
    def of(cls, name: str, given: Mapping[str, Any], *, file: str) -> "Campaign":
        """Of the values of its file, which has passed its schema, with its subjects.

        Raises ConfigurationError, one line with file and key, for what cannot be meant.
        """
        vary = given["vary"]
        axes = tuple(axis(key, value, f"{file}: vary.{key}") for key, value in vary.items())
        how = design(given["design"], f"{file}: design") if "design" in given else None
        conditions = given.get("exclude", [])
        found = cls(
            name=name,
            title=given["title"],
            subjects=tuple((v, side) for v, sides in given["subjects"].items() for side in sides),
            load=DEFAULT_LOAD | given.get("load", {}),
            tissues=given.get("tissues", ""),
            accuracy=given.get("accuracy", "study"),
            settings=given.get("settings", {}),
            axes=axes,
            design=how,
            asked=tuple(given["asked"]),
            exclude=tuple(
                Condition.read(text, [each.key for each in axes], f"{file}: exclude[{n}]")
                for n, text in enumerate(conditions)
            ),
            file=file,
        )
        found._require()
        return found

    def _require(self) -> None:
        self._require_apart()
        self._require_asked()
        self._require_design()
        if self.size > AT_MOST:
            raise ConfigurationError(
                f"{self.file}: {self.size:,} points are more than {AT_MOST:,}; vary less, or sample a design"
            )
        self._require_load()

    def _require_apart(self) -> None:
        for group, key in permutations(self.keys, 2):
            # A file of tissues is read before single values of it are changed.
            if key.startswith(f"{group}.") and group != "tissues":
                raise ConfigurationError(
                    f"{self.file}: vary.{key} is inside vary.{group}, whose values would take its place; "
                    "vary one of them"
                )

    def _require_asked(self) -> None:
        for name in self.asked:
            if name not in ASKED:
                own = next((column for column, quantity in ASKED.items() if quantity == name), None)
                near = [own] if own else get_close_matches(name, ASKED, n=1)
                advice = f"did you mean {near[0]!r}?" if near else f"choose among: {', '.join(ASKED)}"
                raise ConfigurationError(f"{self.file}: asked: no stage answers {name!r}; {advice}")

    def _require_design(self) -> None:
        if self.spans and self.design is None:
            raise ConfigurationError(
                f"{self.file}: vary.{min(self.spans)} has no number of values: add `number:` to it, or a "
                "`design:` that samples it"
            )
        if self.design is not None and not self.spans:
            raise ConfigurationError(
                f"{self.file}: design has nothing to sample; give a setting {{from, to}} without a number"
            )

    def _require_load(self) -> None:
        for name in self.asked:
            for setting in LOADS:
                read = any(
                    f"load.{setting}" in STAGES[each].reads
                    for end in QUANTITIES[ASKED[name]].products
                    for each in (*upstream(STAGES, end), end)
                )
                if read and setting not in self.load and f"load.{setting}" not in self.keys:
                    raise ConfigurationError(
                        f"{self.file}: {name} needs a {setting}: add `load: {{{setting}: "
                        f"{'upright' if setting == 'position' else 'standard'}}}`, or do not ask for it"
                    )

    @property
    def keys(self) -> tuple[str, ...]:
        """The varied settings."""
        return tuple(each.key for each in self.axes)

    @cached_property
    def spans(self) -> dict[str, Any]:
        """What the design samples."""
        return {each.key: each.span for each in self.axes if each.span is not None}

    @property
    def size(self) -> int:
        """Points before any is left out."""
        listed = prod(len(each.levels) for each in self.axes if each.span is None)
        sample = size(self.design, len(self.spans)) if self.design else 1
        return len(self.subjects) * listed * sample

    @property
    def products(self) -> list[str]:
        """What the chain has to make to answer."""
        return sorted({each for name in self.asked for each in QUANTITIES[ASKED[name]].products})

    @property
    def read(self) -> list[str]:
        """These, what they are read with, and the shape that says by what all moduli were multiplied."""
        beside = {each for name in self.asked for each in QUANTITIES[ASKED[name]].beside}
        weighed = (
            {STRESS_FREE} if any(STRESS_FREE in upstream(STAGES, each) for each in self.products) else set()
        )
        return sorted({*self.products, *beside, *weighed})

    def check(self, known: Known) -> None:
        """Raise ConfigurationError for a setting that does not exist or changes nothing, and for one none of
        whose values its schema allows."""
        for each in self.axes:
            place = f"{self.file}: vary.{each.key}"
            try:
                known.limits(each.key)
            except ConfigurationError as error:
                raise ConfigurationError(f"{place}: {error}") from None
            if not depends(each.key, self.products):
                raise ConfigurationError(
                    f"{place} changes nothing of {', '.join(self.asked)}; leave it out, or ask for more"
                )
            ends = [each.span.low, each.span.high] if each.span else [level.value for level in each.levels]
            faults = [known.fault(each.key, value, f"{self.file}: vary") for value in ends]
            if all(faults):
                raise ConfigurationError(f"{faults[0]}; no value of it is allowed")

    def points(self) -> Iterator[Point]:
        """Every point that is not left out, the first setting slowest; those of a design innermost.

        Raises ConfigurationError where none is left.
        """
        found = False
        for point in self._all():
            if not self._leaves_out(point):
                found = True
                yield point
        if not found:
            raise ConfigurationError(f"{self.file}: exclude leaves no point; remove or narrow a condition")

    def _leaves_out(self, point: Point) -> bool:
        """Whether a condition holds of a point. Raises ConfigurationError, with the file."""
        try:
            return any(condition.holds(point.shown) for condition in self.exclude)
        except ConfigurationError as error:
            raise ConfigurationError(f"{self.file}: exclude: {error}") from None

    def _all(self) -> Iterator[Point]:
        sample = sampled(self.design, self.spans) if self.design else [{}]
        listed = [each for each in self.axes if each.span is None]
        for levels in product(*(each.levels for each in listed)):
            yield from (self._point(listed, levels, drawn) for drawn in sample)

    def _point(self, listed: Sequence[Axis], levels: Sequence[Level], drawn: Mapping[str, Any]) -> Point:
        shown = {**{each.key: level.shown for each, level in zip(listed, levels)}, **drawn}
        values = {**{each.key: level.value for each, level in zip(listed, levels)}, **drawn}
        order = self.keys
        return Point({key: shown[key] for key in order}, {key: values[key] for key in order})
