"""Mean glandular dose of this breast by Monte Carlo: energy in the gland over the mass of the gland.

D = N q E / m: N photons per mAs, E keV per photon in the glandular voxels of mass m, q joule per keV.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.core.units import G_PER_KG, J_PER_KEV, MGY_PER_GY
from mammosim.xray.attenuation import Material
from mammosim.xray.geometry import Geometry
from mammosim.xray.phantom import Phantom
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.tally_result import Estimate

PROTOCOL = "this breast, heterogeneous, Monte Carlo"


@dataclass(frozen=True)
class GlandularDose:
    """Mean glandular dose, and how it was found.

    mgy_per_mas, standard_error_mgy_per_mas: dose and its standard error; incident_kerma_mgy_per_mas: the air
    kerma at the breast's surface that it belongs to; glandular_mass_g; protocol: in words.
    """

    mgy_per_mas: float
    standard_error_mgy_per_mas: float
    incident_kerma_mgy_per_mas: float
    glandular_mass_g: float
    protocol: str = PROTOCOL

    @property
    def mgy_per_mgy(self) -> float:
        """Dose per incident air kerma."""
        return self.mgy_per_mas / self.incident_kerma_mgy_per_mas

    @property
    def relative_error(self) -> float:
        """Standard error of the dose, of itself."""
        return self.standard_error_mgy_per_mas / self.mgy_per_mas


class Energies(Protocol):
    """What a dose is made of: keV per photon in each material (n_material,), and photons per mAs."""

    @property
    def materials(self) -> Estimate: ...

    @property
    def photons_per_mas(self) -> float: ...


def mean_glandular_dose(
    tallies: Energies, phantom: Phantom, *, index: int, incident_kerma_mgy_per_mas: float
) -> GlandularDose:
    """Dose to the voxels of material `index`, from the tallies of a transport through the same phantom.

    Raises XrayError when the phantom has no such voxel.
    """
    # ASSUME: the gland is the voxels labelled glandular; gland finer than a voxel has no dose of its own.
    mass = phantom.mass_g(index)
    if mass == 0:
        raise XrayError(
            f"no voxel has index {index}, so there is no glandular dose; was the gland lost by voxels?"
        )
    mgy_per_kev = tallies.photons_per_mas * J_PER_KEV / mass * G_PER_KG * MGY_PER_GY
    energy, error = tallies.materials.value[index], tallies.materials.error[index]
    return GlandularDose(
        float(energy * mgy_per_kev), float(error * mgy_per_kev), incident_kerma_mgy_per_mas, mass
    )


def air_kerma_at(point: np.ndarray, geometry: Geometry, spectrum: Spectrum, *, air: Material) -> float:
    """Air kerma in mGy/mAs at a point (3,) mm that the beam reaches through air only, without backscatter.

    With a point on the breast's upper surface this is the incident air kerma.
    Raises XrayError when the point is not between source and detector.
    """
    n = geometry.detector.normal
    if not 0 < (geometry.source - point) @ n <= geometry.source_height_mm:
        raise XrayError(f"point {point} mm is not between the source and the detector")
    r = float(np.linalg.norm(point - geometry.source))
    return spectrum.at(r).through(air, r).kerma_mgy_per_mas
