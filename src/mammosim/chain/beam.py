"""The beam that reaches the breast, source and detector, and what automatic exposure chooses.

Effects: polychromatic, paddle.
"""

from collections.abc import Mapping

import pandas as pd

from mammosim.chain.field import MAMMOGRAM, field_rows, require_held
from mammosim.chain.graph import Inputs
from mammosim.chain.mammogram import SENSOR_MM, xray_phantom
from mammosim.chain.phantom import healthy
from mammosim.chain.view import craniocaudal, spectrum_from, spectrum_table
from mammosim.core.units import UGY_PER_MGY
from mammosim.io.tables import read_json, read_table, write_json, write_table
from mammosim.xray.geometry import Geometry
from mammosim.xray.projector import path_lengths, primary
from mammosim.xray.quality import Paddle, automatic_mas, in_the_way
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.tube import tube_spectrum

TUBE = ("anode", "filter", "filter_um", "peak_kv")
GEOMETRY = ("source_to_detector_mm", "support_to_detector_mm", "pixel_mm", "field_mm")


def spectrum(inputs: Inputs) -> Spectrum:
    """Of the photons that reach the breast; without `polychromatic` all have their mean energy."""
    anode, filter_, filter_um, kv = (inputs.setting(f"xray.{name}") for name in TUBE)
    paddle = (Paddle(**inputs.setting("xray.paddle")),) if inputs.has("paddle") else ()
    beam = in_the_way(tube_spectrum(anode, filter_, filter_um / 1e3, kv), paddle)
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
    """Whether the detectors of mammography and tomosynthesis hold the breast, see chain.field."""
    return field_rows(
        inputs["phantom"],
        chest_y_mm=inputs["pressed"].plates["chest_y_mm"],
        geometry={name: inputs.setting(f"xray.{name}") for name in GEOMETRY},
        scan={name: inputs.setting(f"xray.tomosynthesis.{name}") for name in ("system", "pixel_mm")},
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
    settings = {name: inputs.setting(f"xray.{name}") for name in GEOMETRY}
    return craniocaudal(inputs["phantom"], chest_y_mm=inputs["pressed"].plates["chest_y_mm"], **settings)


def exposure(inputs: Inputs) -> float:
    """mAs of automatic exposure of the breast without its lesion."""
    geometry, phantom = inputs["geometry"], xray_phantom(healthy(inputs["phantom"]))
    return automatic_mas(
        primary(phantom, geometry, inputs["spectrum"]).kerma_mgy,
        path_lengths(phantom, geometry)[..., 1:].sum(axis=-1) > 0,
        target_mgy=inputs.setting("xray.detector_kerma_ugy") / UGY_PER_MGY,
        sensor_pixels=max(round(SENSOR_MM / geometry.detector.pixel_mm), 1),
    )
