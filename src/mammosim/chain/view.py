"""The craniocaudal view of a compressed breast: geometry and spectrum from plain values."""

from collections.abc import Mapping

import pandas as pd

from mammosim.chain.mammogram import xray_phantom
from mammosim.core.volume import LabelMap
from mammosim.xray.geometry import Geometry
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.views import mammography_geometry

COLUMNS = ["energy_kev", "photons_per_mm2_mas"]


def craniocaudal(
    labels: LabelMap,
    *,
    chest_y_mm: float,
    source_to_detector_mm: float,
    support_to_detector_mm: float,
    field_mm: Mapping[str, float],
    pixel_mm: float,
) -> Geometry:
    """Source above the plates' chest edge, detector below the support.

    field_mm: depth from the chest edge to anterior, width along x. Raises XrayError when the breast's shadow
    leaves the field.
    """
    return mammography_geometry(
        xray_phantom(labels),
        chest_wall_y_mm=chest_y_mm,
        source_to_detector_mm=source_to_detector_mm,
        air_gap_mm=support_to_detector_mm,
        field_mm=(field_mm["depth"], field_mm["width"]),
        pixel_mm=pixel_mm,
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
