"""Mean glandular dose by several routes side by side: each number with its protocol, error and status.

Rows: route, protocol, thickness_mm, glandularity_percent, hvl_mm_al, agd_mgy_per_mgy (per incident air
kerma), standard_error (0 of a table), status.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from mammosim.core.errors import XrayError
from mammosim.core.labels import Label
from mammosim.xray.attenuation import material
from mammosim.xray.blocks import Limits
from mammosim.xray.dance import GLAND, RADIUS_MM, dance_dose, standard_breast, standard_geometry
from mammosim.xray.dose import GlandularDose, air_kerma_at, mean_glandular_dose
from mammosim.xray.exposure_setup import ExposureSetup
from mammosim.xray.phantom import Phantom
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.tally_request import EnergyIn

SIMULATED, TABULATED = "Monte Carlo", "Dance g c s"
STANDARD = "standard breast, homogeneous, under 5 mm of fat"
COMPUTED = "computed here"
CENTRE_MM = 4 * RADIUS_MM / (3 * np.pi)
MAMMOGRAPHIC = (40.0, 50.0, 60.0)  # mm


@dataclass(frozen=True)
class Beam:
    """A spectrum in vacuum, and the anode and filter that Dance's s is listed by, such as 'W/Rh'."""

    spectrum: Spectrum
    combination: str


def glandularity_percent(phantom: Phantom) -> float:
    """Mass of the gland over that of gland and fat, without skin, of a phantom whose index is the label."""
    gland, fat = phantom.mass_g(Label.GLANDULAR), phantom.mass_g(Label.ADIPOSE)
    return 100 * gland / (gland + fat)


def standard_dose(
    spectrum: Spectrum, thickness_mm: float, *, glandularity_percent: float, relative_error: float, seed: int
) -> GlandularDose:
    """Monte Carlo dose of the standard breast; incident air kerma at the middle of its upper side."""
    rng = np.random.default_rng(seed)
    phantom = standard_breast(thickness_mm, glandularity_percent, rng=rng)
    setup = ExposureSetup(phantom, standard_geometry(), spectrum)
    tally = EnergyIn(GLAND, relative_error).result(setup, seed=seed, limits=Limits())
    kerma = air_kerma_at(_top(thickness_mm), setup.geometry, spectrum, air=phantom.materials[0])
    return mean_glandular_dose(tally, phantom, index=GLAND, incident_kerma_mgy_per_mas=kerma)


def standard_rows(
    beam: Beam, thicknesses_mm: tuple[float, ...] = MAMMOGRAPHIC, *, glandularity_percent: float = 50.0,
    relative_error: float, seed: int,
) -> pd.DataFrame:  # fmt: skip
    """Standard breasts by Monte Carlo and by Dance's factors, two rows a thickness."""
    rows = []
    for t in thicknesses_mm:
        kind = {"protocol": STANDARD, "thickness_mm": t, "glandularity_percent": glandularity_percent}
        dose = standard_dose(
            beam.spectrum,
            t,
            glandularity_percent=glandularity_percent,
            relative_error=relative_error,
            seed=seed,
        )
        hvl = entrance_hvl(beam.spectrum, t)
        rows += [
            _row(SIMULATED, kind, hvl, dose.mgy_per_mgy, _error(dose), COMPUTED),
            _row(TABULATED, kind, hvl, *_tabulated(hvl, t, glandularity_percent, beam.combination)),
        ]
    return pd.DataFrame(rows)


def _tabulated(
    hvl_mm_al: float, thickness_mm: float, glandularity_percent: float, combination: str
) -> tuple[float, float, str]:
    """Dose by Dance's factors, its error 0 and status; NaN, and why, where the tables have no such breast."""
    try:
        table = dance_dose(
            hvl_mm_al, thickness_mm, glandularity_percent=glandularity_percent, combination=combination
        )
    except XrayError as error:
        return np.nan, 0.0, f"none: {error}"
    return table.mgy_per_mgy, 0.0, table.status


def three_routes(
    dose: GlandularDose,
    phantom: Phantom,
    beam: Beam,
    *,
    thickness_mm: float,
    relative_error: float,
    seed: int,
) -> pd.DataFrame:
    """Dose of this breast, and of a standard breast of its thickness and glandularity by both routes."""
    here = glandularity_percent(phantom)
    kind = {"protocol": dose.protocol, "thickness_mm": thickness_mm, "glandularity_percent": here}
    hvl = entrance_hvl(beam.spectrum, thickness_mm)
    this = pd.DataFrame([_row(SIMULATED, kind, hvl, dose.mgy_per_mgy, _error(dose), COMPUTED)])
    standard = standard_rows(
        beam, (thickness_mm,), glandularity_percent=here, relative_error=relative_error, seed=seed
    )
    return pd.concat([this, standard], ignore_index=True)


def entrance_hvl(spectrum: Spectrum, thickness_mm: float) -> float:
    """Half-value layer in mm Al where the beam enters the standard breast, after the air."""
    geometry, top = standard_geometry(), _top(thickness_mm)
    r = float(np.linalg.norm(top - geometry.source))
    return spectrum.at(r).through(material("air"), r).hvl_mm_al


def _top(thickness_mm: float) -> np.ndarray:
    """The middle of the breast's upper side, at its centre of mass 4R/(3 pi) from the chest wall."""
    return np.array([CENTRE_MM, 0.0, thickness_mm])


def _error(dose: GlandularDose) -> float:
    return dose.mgy_per_mgy * dose.relative_error


def _row(
    route: str, kind: dict[str, object], hvl: float, value: float, error: float, status: str
) -> dict[str, object]:
    numbers = {"hvl_mm_al": hvl, "agd_mgy_per_mgy": value, "standard_error": error}
    return {"route": route, **kind, **numbers, "status": status}
