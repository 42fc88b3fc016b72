"""What a configuration lets one expect to fail, said before the run: the run then has rows with reasons."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from mammosim.chain.graph import pruned
from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import Positive, Settings, read

READS = (
    "volunteers",
    *(f"compression.{name}" for name in ("thickness_mm", "smallest_mm", "moduli", "plate_mm.width")),
    *(f"xray.{name}" for name in ("source_to_detector_mm", "support_to_detector_mm", "field_mm.width")),
    *("xray.effects", "xray.tomosynthesis.system"),
)


@dataclass(frozen=True)
class Width(Settings):
    """Of the plates, or of the field at the detector, in mm."""

    width: Positive


@dataclass(frozen=True)
class Pressing(Settings):
    """thickness_mm: volunteer -> of her standard compression; smallest_mm: that any may be pressed to."""

    thickness_mm: Mapping[str, Positive]
    smallest_mm: Positive
    moduli: tuple[str, ...]
    plate_mm: Width


@dataclass(frozen=True)
class Tomosynthesis(Settings):
    """system: a row of the table imaging_systems."""

    system: str


@dataclass(frozen=True)
class Imaging(Settings):
    """Distances from the detector to source and support of the breast, and the effects of an image."""

    source_to_detector_mm: Positive
    support_to_detector_mm: float
    field_mm: Width
    effects: tuple[str, ...]
    tomosynthesis: Tomosynthesis


@dataclass(frozen=True)
class Study(Settings):
    """What is foreseen from: the settings READS of the configuration."""

    volunteers: tuple[str, ...]
    compression: Pressing
    xray: Imaging

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.below_source_mm <= 0:
            raise ConfigurationError(
                f"xray.source_to_detector_mm = {self.xray.source_to_detector_mm:g} leaves no room for the "
                "support and a breast; move the source away"
            )

    @property
    def below_source_mm(self) -> float:
        """From the source to the top of the thinnest breast."""
        xray = self.xray
        return xray.source_to_detector_mm - xray.support_to_detector_mm - self.compression.smallest_mm

    @classmethod
    def of(cls, configuration: Mapping[str, object]) -> "Study":
        """Of the whole configuration. Raises ConfigurationError as core.settings.read does."""
        return read(cls, pruned(configuration, READS), "the configuration")


@dataclass(frozen=True)
class Until(Settings):
    """When a strategy stops, where that may be impossible: at a share of the thickness, at a pressure."""

    thickness_share: Positive | None = None
    pressure_kpa: Mapping[str, Positive] | None = None

    @classmethod
    def of(cls, strategy: Mapping[str, Mapping[str, object]]) -> "Until":
        """Of an entry of config/strategies.yaml."""
        return read(cls, pruned(strategy["until"], ("thickness_share", "pressure_kpa")), "until")


System = Mapping[
    str, str | float | None
]  # a row of the table imaging_systems, None or NaN where it has a gap


def foreseen(study: Study, ends: Mapping[str, Until], systems: Mapping[str, System]) -> list[str]:
    """One sentence for each thing that cannot, or may not, be answered.

    ends: of the strategies compared, by their names; systems: by their names.
    """
    return [*_strategies(study, ends), *_system(study, systems), *_field(study), *_beam(study)]


def _strategies(study: Study, ends: Mapping[str, Until]) -> Iterator[str]:
    """Of strategies that press further than any may, or whose pressure is stated for other moduli."""
    pressing = study.compression
    for name, until in ends.items():
        goals = (
            {}
            if until.thickness_share is None
            else {woman: until.thickness_share * pressing.thickness_mm[woman] for woman in study.volunteers}
        )
        for woman, goal in goals.items():
            if goal < pressing.smallest_mm:
                yield (
                    f"the strategy {name} would press {woman} to {goal:g} mm, and compression.smallest_mm is "
                    f"{pressing.smallest_mm:g}"
                )
        known = until.pressure_kpa
        if known is not None and (lacking := [m for m in pressing.moduli if m not in known]):
            yield f"the strategy {name} states no pressure_kpa for the moduli {', '.join(lacking)}"


def _system(study: Study, systems: Mapping[str, System]) -> Iterator[str]:
    """Of a system whose row lacks something."""
    name = study.xray.tomosynthesis.system
    row = systems.get(name, {})
    if lacking := [key for key, value in row.items() if value is None or value != value]:
        yield f"the system {name} lacks {', '.join(lacking)}, so that it makes no slices"


def _field(study: Study) -> Iterator[str]:
    """Of a field of mammography that is narrower than the plates: a breast between them may be, too."""
    plates, field = study.compression.plate_mm.width, study.xray.field_mm.width
    shadow = plates * study.xray.source_to_detector_mm / study.below_source_mm
    if field < shadow:
        yield (
            f"xray.field_mm.width = {field:g} holds no breast as wide as the plates, "
            f"whose shadow is {shadow:.0f} mm: images of larger breasts will be missing"
        )


def _beam(study: Study) -> Iterator[str]:
    """Of a beam that no machine has: all photons of one energy, or no paddle in their way."""
    for effect, words in (("polychromatic", "photons of many energies"), ("paddle", "the paddle")):
        if effect not in study.xray.effects:
            yield f"exposure, dose and contrast as they are with {words}, since xray.effects lacks {effect}"
