"""What a configuration lets one expect to fail, said before the run: the run then has rows with reasons."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import get_type_hints

from mammosim.chain.graph import Chain, pruned
from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import Positive, Settings, read

# Where the fields of Study stand in the configuration.
KEYS = {
    "volunteers": "volunteers",
    "thickness_mm": "compression.thickness_mm",
    "smallest_mm": "compression.smallest_mm",
    "moduli": "compression.moduli",
    "plates_width_mm": "compression.plate_mm.width",
    "source_mm": "xray.source_to_detector_mm",
    "support_mm": "xray.support_to_detector_mm",
    "field_width_mm": "xray.field_mm.width",
    "effects": "xray.effects",
    "system": "xray.tomosynthesis.system",
}


@dataclass(frozen=True)
class Study(Settings):
    """What is foreseen from, by its KEYS; source_mm and support_mm: above the detector.

    thickness_mm: volunteer -> of her standard compression, where given; smallest_mm: that any may be
    pressed to.
    """

    volunteers: tuple[str, ...]
    thickness_mm: Mapping[str, Positive]
    smallest_mm: Positive
    moduli: tuple[str, ...]
    plates_width_mm: Positive
    source_mm: Positive
    support_mm: float
    field_width_mm: Positive
    effects: tuple[str, ...]
    system: str

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.below_source_mm <= 0:
            raise ConfigurationError(
                f"{KEYS['source_mm']} = {self.source_mm:g} leaves no room for the support and a breast; "
                "move the source away"
            )

    @property
    def below_source_mm(self) -> float:
        """From the source to the top of the thinnest breast."""
        return self.source_mm - self.support_mm - self.smallest_mm

    @classmethod
    def of(cls, configuration: Mapping[str, object]) -> "Study":
        """Of the whole configuration. Raises ConfigurationError as core.settings.read does."""
        chain, kinds = Chain(None, configuration, frozenset(), {}), get_type_hints(cls, include_extras=True)
        return cls(**{name: read(kinds[name], chain.setting(key), key) for name, key in KEYS.items()})


@dataclass(frozen=True)
class StrategyEnd(Settings):
    """When a strategy stops, where that may be impossible: at a share of the thickness, at a pressure."""

    thickness_share: Positive | None = None
    pressure_kpa: Mapping[str, Positive] | None = None

    @classmethod
    def of(cls, strategy: Mapping[str, Mapping[str, object]]) -> "StrategyEnd":
        """Of an entry of config/strategies.yaml."""
        return read(cls, pruned(strategy["until"], ("thickness_share", "pressure_kpa")), "until")


# A row of the table imaging_systems, None or NaN where it has a gap.
System = Mapping[str, str | float | None]


def foreseen(study: Study, ends: Mapping[str, StrategyEnd], systems: Mapping[str, System]) -> list[str]:
    """One sentence for each thing that cannot, or may not, be answered.

    ends: of the strategies compared, by their names; systems: by their names.
    """
    return [*_strategies(study, ends), *_system(study, systems), *_field(study), *_beam(study)]


def _strategies(study: Study, ends: Mapping[str, StrategyEnd]) -> Iterator[str]:
    """Of strategies that press further than any may, or whose pressure is stated for other moduli."""
    for name, until in ends.items():
        share = until.thickness_share
        known = [woman for woman in study.volunteers if woman in study.thickness_mm]
        goals = {woman: share * study.thickness_mm[woman] for woman in known} if share else {}
        for woman, goal in goals.items():
            if goal < study.smallest_mm:
                yield (
                    f"the strategy {name} would press {woman} to {goal:g} mm, and compression.smallest_mm is "
                    f"{study.smallest_mm:g}"
                )
        stated = until.pressure_kpa
        if stated is not None and (lacking := [m for m in study.moduli if m not in stated]):
            yield f"the strategy {name} states no pressure_kpa for the moduli {', '.join(lacking)}"


def _system(study: Study, systems: Mapping[str, System]) -> Iterator[str]:
    """Of a system whose row lacks something."""
    row = systems.get(study.system, {})
    if lacking := [key for key, value in row.items() if value is None or value != value]:
        yield f"the system {study.system} lacks {', '.join(lacking)}, so that it makes no slices"


def _field(study: Study) -> Iterator[str]:
    """Of a field of mammography that is narrower than the plates: a breast between them may be, too."""
    shadow = study.plates_width_mm * study.source_mm / study.below_source_mm
    if study.field_width_mm < shadow:
        yield (
            f"xray.field_mm.width = {study.field_width_mm:g} holds no breast as wide as the plates, "
            f"whose shadow is {shadow:.0f} mm: images of larger breasts will be missing"
        )


def _beam(study: Study) -> Iterator[str]:
    """Of a beam that no machine has: all photons of one energy, or no paddle in their way."""
    for effect, words in (("polychromatic", "photons of many energies"), ("paddle", "the paddle")):
        if effect not in study.effects:
            yield f"exposure, dose and contrast as they are with {words}, since xray.effects lacks {effect}"
