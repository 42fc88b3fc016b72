"""What a configuration lets one expect to fail, said before the run: the run then has rows with reasons."""

from collections.abc import Iterator, Mapping
from typing import Any

Values = Mapping[str, Any]


def foreseen(settings: Values, strategies: Mapping[str, Values], systems: Mapping[str, Values]) -> list[str]:
    """One sentence for each thing that cannot, or may not, be answered.

    settings: of the study; strategies: those compared, as in config/strategies.yaml; systems: rows of the
    table imaging_systems by name.
    """
    return [
        *_strategies(settings, strategies),
        *_system(settings, systems),
        *_field(settings),
        *_beam(settings),
    ]


def _strategies(settings: Values, strategies: Mapping[str, Values]) -> Iterator[str]:
    """Of strategies that press further than any may, or whose pressure is stated for other moduli."""
    pressing = settings["compression"]
    for name, strategy in strategies.items():
        share = strategy["until"].get("thickness_share")
        for woman in settings["volunteers"] if share is not None else ():
            goal = share * pressing["thickness_mm"][woman]
            if goal < pressing["smallest_mm"]:
                yield (
                    f"the strategy {name} would press {woman} to {goal:g} mm, and compression.smallest_mm is "
                    f"{pressing['smallest_mm']:g}"
                )
        known = strategy["until"].get("pressure_kpa")
        if known is not None and (lacking := [m for m in pressing["moduli"] if m not in known]):
            yield f"the strategy {name} states no pressure_kpa for the moduli {', '.join(lacking)}"


def _system(settings: Values, systems: Mapping[str, Values]) -> Iterator[str]:
    """Of a system whose row lacks something."""
    name = settings["xray"]["tomosynthesis"]["system"]
    row = systems.get(name, {})
    if lacking := [key for key, value in row.items() if value is None or value != value]:
        yield f"the system {name} lacks {', '.join(lacking)}, so that it makes no slices"


def _field(settings: Values) -> Iterator[str]:
    """Of a field of mammography that is narrower than the plates: a breast between them may be, too."""
    xray, plates = settings["xray"], settings["compression"]["plate_mm"]
    magnified = xray["source_to_detector_mm"] / (
        xray["source_to_detector_mm"]
        - xray["support_to_detector_mm"]
        - settings["compression"]["smallest_mm"]
    )
    if xray["field_mm"]["width"] < plates["width"] * magnified:
        yield (
            f"xray.field_mm.width = {xray['field_mm']['width']:g} holds no breast as wide as the plates, "
            f"whose shadow is {plates['width'] * magnified:.0f} mm: images of larger breasts will be missing"
        )


def _beam(settings: Values) -> Iterator[str]:
    """Of a beam that no machine has: all photons of one energy, or no paddle in their way."""
    for effect, words in (("polychromatic", "photons of many energies"), ("paddle", "the paddle")):
        if effect not in settings["xray"]["effects"]:
            yield f"exposure, dose and contrast as they are with {words}, since xray.effects lacks {effect}"
