"""Before a photon is followed: the beam, the view and its field, and the exposure that the automatic chooses.

Its effects are polychromatic (photons of many energies) and paddle.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from mammosim.chain.graph import Inputs
from mammosim.chain.image_chain import Tube
from mammosim.chain.mammogram import SENSOR_MM, xray_phantom
from mammosim.chain.phantom import healthy
from mammosim.core.errors import ConfigurationError, MissingResult, XrayError
from mammosim.core.settings import looked_up, read, require_positive
from mammosim.core.units import UGY_PER_MGY
from mammosim.core.volume import LabelMap
from mammosim.io.tables import read_json, read_table, write_json, write_table
from mammosim.xray.geometry import Geometry
from mammosim.xray.placement import Outline, Room
from mammosim.xray.projector import path_lengths, primary
from mammosim.xray.quality import Paddle, automatic_mas, in_the_way
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.systems import system_named
from mammosim.xray.tube import tube_spectrum
from mammosim.xray.views import mammography_geometry, tomosynthesis_geometries

COLUMNS = ["energy_kev", "photons_per_mm2_mas"]


@dataclass(frozen=True)
class FieldSize:
    """Of a detector, mm: depth from the chest edge to anterior, width along x."""

    depth: float
    width: float

    def __post_init__(self) -> None:
        require_positive(self, "depth", "width")


@dataclass(frozen=True)
class Mammography:
    """Source and detector of a mammogram, mm. Raises ConfigurationError where they cannot stand so."""

    source_to_detector_mm: float
    support_to_detector_mm: float
    pixel_mm: float
    field_mm: FieldSize

    def __post_init__(self) -> None:
        require_positive(self, "source_to_detector_mm", "pixel_mm")
        if not 0 <= self.support_to_detector_mm < self.source_to_detector_mm:
            raise ConfigurationError(
                f"support_to_detector_mm = {self.support_to_detector_mm:g} is outside "
                f"[0, {self.source_to_detector_mm:g}), where the source is; usual is 20"
            )


def craniocaudal(labels: LabelMap, settings: Mammography, *, chest_y_mm: float) -> Geometry:
    """Source above the plates' chest edge, detector below the support.

    Raises XrayError when the breast's shadow leaves the field.
    """
    return mammography_geometry(
        xray_phantom(labels),
        chest_wall_y_mm=chest_y_mm,
        source_to_detector_mm=settings.source_to_detector_mm,
        air_gap_mm=settings.support_to_detector_mm,
        field_mm=(settings.field_mm.depth, settings.field_mm.width),
        pixel_mm=settings.pixel_mm,
    )


def spectrum_table(spectrum: Spectrum) -> tuple[pd.DataFrame, dict[str, float | str]]:
    """A spectrum as COLUMNS, and what characterises it."""
    table = pd.DataFrame(dict(zip(COLUMNS, (spectrum.energies_kev, spectrum.fluence))))
    facts: dict[str, float | str] = {
        name: getattr(spectrum, name)
        for name in ("name", "distance_mm", "hvl_mm_al", "mean_energy_kev", "kerma_mgy_per_mas")
    }
    return table, facts


def spectrum_from(table: pd.DataFrame, facts: Mapping[str, float | str]) -> Spectrum:
    """The inverse of spectrum_table."""
    energies, fluence = (table[name].to_numpy(float) for name in COLUMNS)
    return Spectrum(energies, fluence, float(facts["distance_mm"]), str(facts["name"]))


HELD = "held"
MAMMOGRAM, TOMOSYNTHESIS = "mammogram", "tomosynthesis"
NUMBERS = ("room_mm", "width_mm", "depth_mm", "shadow_width_mm", "shadow_depth_mm")


@dataclass(frozen=True)
class Scanner:
    """A system of tomosynthesis by name, and its pixels in mm."""

    system: str
    pixel_mm: float

    def __post_init__(self) -> None:
        require_positive(self, "pixel_mm")


def field_rows(
    labels: LabelMap, *, chest_y_mm: float, mammography: Mammography, scanner: Scanner
) -> pd.DataFrame:
    """A row for mammography and one for tomosynthesis: columns view, system, NUMBERS, outcome.

    labels: the pressed breast.
    room_mm: least distance of the shadow, over all views, from the sides and the front of the detector;
    width_mm, depth_mm: of the detector; shadow_*: what the shadows of all views cover; NaN where the breast
    does not fit, and outcome says why; else it is HELD.
    """
    phantom, name = xray_phantom(labels), scanner.system
    points = Outline.of(phantom, chest_y_mm).points

    def one() -> Sequence[Geometry]:
        return (craniocaudal(labels, mammography, chest_y_mm=chest_y_mm),)

    def many() -> Sequence[Geometry]:
        return tomosynthesis_geometries(
            phantom, system_named(name), chest_wall_y_mm=chest_y_mm, pixel_mm=scanner.pixel_mm
        )

    views = {MAMMOGRAM: ("mammography", one), TOMOSYNTHESIS: (name, many)}
    rows = [{"view": v, "system": s, **_measured(points, made)} for v, (s, made) in views.items()]
    return pd.DataFrame(rows)


def _measured(points: np.ndarray, views: Callable[[], Sequence[Geometry]]) -> dict[str, float | str]:
    """NUMBERS and the outcome of the views."""
    try:
        found = views()
    except XrayError as error:
        return dict.fromkeys(NUMBERS, np.nan) | {"outcome": str(error)}
    room = Room.around(points, found)
    numbers = (room.least_mm, *found[0].detector.size_mm, *room.needs_mm)
    return dict(zip(NUMBERS, numbers, strict=True)) | {"outcome": HELD}


def require_held(rows: pd.DataFrame, view: str) -> None:
    """Raise MissingResult, with the reason, when the breast does not fit the detector of a view."""
    row = rows[rows["view"] == view].iloc[0]
    if row.outcome != HELD:
        names = (row[name] for name in ("volunteer", "side", "strategy", "moduli") if name in row)
        raise MissingResult(f"{view} {' '.join(names)}: {row.outcome}")


def spectrum(inputs: Inputs) -> Spectrum:
    """Of the photons that reach the breast; without `polychromatic` all have their mean energy."""
    tube = looked_up(Tube, inputs.setting, "xray")
    # ASSUME: every strategy has the same level sheet in the beam; a cushion attenuates nothing.
    has = inputs.has("paddle")
    paddle = (read(Paddle, inputs.setting("xray.paddle"), "xray.paddle"),) if has else ()
    beam = in_the_way(tube_spectrum(*tube.beam), paddle)
    return beam.rebinned(inputs.setting("xray.energies") if inputs.has("polychromatic") else 1)


def save_spectrum(spectrum: Spectrum, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """Its photons, and what characterises it."""
    table, facts = spectrum_table(spectrum)
    write_table(table, files["table"])
    write_json(facts, files["facts"])


def load_spectrum(files: Mapping[str, str]) -> Spectrum:
    """What save_spectrum wrote."""
    return spectrum_from(read_table(files["table"]), read_json(files["facts"]))


def field(inputs: Inputs) -> pd.DataFrame:
    """Whether the detectors of mammography and tomosynthesis hold the breast, a row each."""
    return field_rows(
        inputs["phantom"],
        chest_y_mm=inputs["pressed"].plates["chest_y_mm"],
        mammography=looked_up(Mammography, inputs.setting, "xray"),
        scanner=looked_up(Scanner, inputs.setting, "xray.tomosynthesis"),
    )


def save_field(table: pd.DataFrame, files: Mapping[str, str], job: Mapping[str, str]) -> None:
    """Its rows."""
    write_table(table.assign(**job)[[*job, *table.columns]], files["rows"])


def load_field(files: Mapping[str, str]) -> pd.DataFrame:
    """What save_field wrote."""
    return read_table(files["rows"])


def geometry(inputs: Inputs) -> Geometry:
    """Of mammography. Raises MissingResult where the detector does not hold the breast."""
    require_held(inputs["field"], MAMMOGRAM)
    settings = looked_up(Mammography, inputs.setting, "xray")
    return craniocaudal(inputs["phantom"], settings, chest_y_mm=inputs["pressed"].plates["chest_y_mm"])


def exposure(inputs: Inputs) -> float:
    """mAs of automatic exposure of the breast without its lesion."""
    geometry, phantom = inputs["geometry"], xray_phantom(healthy(inputs["phantom"]))
    return automatic_mas(
        primary(phantom, geometry, inputs["spectrum"]).kerma_mgy,
        path_lengths(phantom, geometry)[..., 1:].sum(axis=-1) > 0,
        target_mgy=inputs.setting("xray.detector_kerma_ugy") / UGY_PER_MGY,
        sensor_pixels=max(round(SENSOR_MM / geometry.detector.pixel_mm), 1),
    )
