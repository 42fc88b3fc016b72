"""The points of a campaign: their names, what each reads of the study, and what is made for it.

A point is named by a digest of all that it depends on, but for the content of its inputs, which may not be
there yet: whose breast, the settings that its products read, the code of these. So a value that is added
tomorrow leaves every other point its name.
"""

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from mammosim.chain.graph import Chain, read_by
from mammosim.chain.stages import STAGES
from mammosim.core.errors import ConfigurationError
from mammosim.study.campaigns.axes import Shown
from mammosim.study.campaigns.campaign import Campaign, Point
from mammosim.study.campaigns.settings import EFFECTS, Known, changes

LOAD = ("strategy", "moduli", "position")


@dataclass(frozen=True)
class Case:
    """One breast in a campaign.

    chain: with the settings of the campaign, before any varies; study: of a load by names (strategy, moduli,
    position), the study's own chain, and paths: a product of it -> where its files are.
    """

    volunteer: str
    side: str
    chain: Chain
    study: Callable[[Mapping[str, str]], Chain]
    paths: Callable[[str, Mapping[str, str]], Mapping[str, str]]


@dataclass(frozen=True)
class Planned:
    """A point that is to be computed.

    shown: column -> value; changes: settings of the chain by dotted name; effects: None for those of the
    case; kept: product -> file -> path, of what the study has; own: product -> digest, of what is made,
    each after those that it is made of; rejected: why it cannot be meant, '' where it can.
    """

    name: str
    volunteer: str
    side: str
    shown: Mapping[str, Shown]
    changes: Mapping[str, Any] = field(default_factory=dict)
    effects: tuple[str, ...] | None = None
    kept: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    own: Mapping[str, str] = field(default_factory=dict)
    rejected: str = ""


def text(value: Any) -> str:
    """A setting as text that is the same however a number or a group of keys is written."""
    return json.dumps(_canonical(value), sort_keys=True, default=str)


def _canonical(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _canonical(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_canonical(each) for each in value]
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return int(value)
    return value


def short(*parts: Any) -> str:
    """16 hexadecimal digits of what these say."""
    return hashlib.sha256(json.dumps(parts, default=str).encode()).hexdigest()[:16]


@dataclass
class Digests:
    """The digests of products: two chains of one subject that agree in it share the product.

    texts: of settings by identity, which most points have in common; each is held, so that it stays the same.
    """

    texts: dict[int, tuple[Any, str]] = field(default_factory=dict)
    found: dict[tuple[Any, ...], str] = field(default_factory=dict)

    def of(self, chain: Chain, name: str, known: dict[str, str]) -> str:
        """Of one product; known: those of this chain so far."""
        if name not in known:
            stage = STAGES[name]
            parts = (
                name,
                *(self.text(chain.setting(each)) for each in stage.reads),
                *(effect for effect in stage.effects if effect in chain.effects),
                *(self.of(chain, need, known) for need in chain.needs(name)),
            )
            if parts not in self.found:
                self.found[parts] = short(*parts)
            known[name] = self.found[parts]
        return known[name]

    def text(self, value: Any) -> str:
        """See `text`."""
        if not isinstance(value, (Mapping, list)):
            return text(value)
        if id(value) not in self.texts:
            self.texts[id(value)] = value, text(value)
        return self.texts[id(value)][1]


def plan(campaign: Campaign, cases: Sequence[Case], known: Known, library: str) -> list[Planned]:
    """Every point.

    library: of the code that the answers depend on. Raises ConfigurationError where no point can be meant.
    """
    campaign.check(known)
    listed, faults = list(campaign.points()), Faults(campaign, known)
    points = [each for case in cases for each in _planned(campaign, case, listed, known, faults, library)]
    if all(point.rejected for point in points):
        raise ConfigurationError(f"{points[0].rejected}; no point of {campaign.file} is allowed")
    return points


@dataclass
class Faults:
    """Why values cannot be meant, each looked at once."""

    campaign: Campaign
    known: Known
    found: dict[tuple[str, Shown], str] = field(default_factory=dict)

    def of(self, point: Point) -> str:
        """Of the first value of a point that cannot be meant, '' where all can."""
        for key, shown in point.shown.items():
            if (key, shown) not in self.found:
                self.found[key, shown] = self.known.fault(
                    key, point.values[key], f"{self.campaign.file}: vary"
                )
            if self.found[key, shown]:
                return self.found[key, shown]
        return ""


def _planned(
    campaign: Campaign, case: Case, points: Iterable[Point], known: Known, faults: Faults, library: str
) -> Iterator[Planned]:
    digests, studies, acts = Digests(), _Studies(case), _Acting(campaign.read)
    whose = short(asdict(case.chain.subject), library)
    for point in points:
        why = faults.of(point)
        try:
            made = {} if why else acts.on(changes(point.values, case.chain.settings, known))
        except ConfigurationError as error:
            why = f"{campaign.file}: {error}"
        if why:
            name = short(whose, text(point.shown), why)
            yield Planned(name, case.volunteer, case.side, point.shown, rejected=why)
            continue
        chain, effects = varied(case.chain, made)
        load = {name: point.values.get(f"load.{name}", campaign.load.get(name, "")) for name in LOAD}
        known_digests: dict[str, str] = {}
        taken, own = _taken(campaign.read, chain, digests, known_digests, studies, load)
        yield Planned(
            short(whose, *(digests.of(chain, each, known_digests) for each in campaign.read)),
            case.volunteer,
            case.side,
            point.shown,
            {key: value for key, value in made.items() if key not in EFFECTS},
            effects,
            {each: case.paths(each, load) for each in taken},
            own,
        )


def varied(chain: Chain, made: Mapping[str, Any]) -> tuple[Chain, tuple[str, ...] | None]:
    """A chain with other settings, and its effects where these say them."""
    settings = {key: value for key, value in made.items() if key not in EFFECTS}
    found = chain.with_settings(settings) if settings else chain
    if not any(key in made for key in EFFECTS):
        return found, None
    effects = tuple(effect for key in EFFECTS for effect in made.get(key, chain.setting(key)))
    return found.with_effects(effects), effects


class _Acting:
    """Which changes act on products: others, as what is pressed on what only hangs, are left out."""

    def __init__(self, products: Iterable[str]) -> None:
        self.read, self.found = read_by(STAGES, products), dict.fromkeys(EFFECTS, True)

    def on(self, made: Mapping[str, Any]) -> dict[str, Any]:
        """Those of the changes that act."""
        for key in (key for key in made if key not in self.found):
            self.found[key] = any(f"{key}.".startswith(f"{n}.") or n.startswith(f"{key}.") for n in self.read)
        return {key: value for key, value in made.items() if self.found[key]}


@dataclass
class _Studies:
    """The study's own chains of one breast, by their load, with their digests."""

    case: Case
    found: dict[tuple[str, ...], tuple[Chain, dict[str, str]]] = field(default_factory=dict)

    def of(self, load: Mapping[str, str]) -> tuple[Chain, dict[str, str]]:
        key = tuple(load.values())
        if key not in self.found:
            self.found[key] = self.case.study({name: value for name, value in load.items() if value}), {}
        return self.found[key]


def _taken(
    names: Iterable[str],
    chain: Chain,
    digests: Digests,
    known: dict[str, str],
    studies: _Studies,
    load: Mapping[str, str],
) -> tuple[list[str], dict[str, str]]:
    """The products that are read from the study's files, and those that are made, with their digests."""
    study, of_study = studies.of(load)
    taken: dict[str, None] = {}
    own: dict[str, str] = {}

    def look(name: str) -> None:
        if name in taken or name in own:
            return
        digest = digests.of(chain, name, known)
        if STAGES[name].files is not None and digest == digests.of(study, name, of_study):
            taken[name] = None
            return
        for need in chain.needs(name):
            look(need)
        own[name] = digest

    for name in names:
        look(name)
    return list(taken), own
