"""What is irradiated, from where, with what; and the same as the compiled kernels read it."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mammosim.xray.attenuation import linear_attenuation
from mammosim.xray.beam import body_of, field_of, require_outside
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.interactions import Matter, matter
from mammosim.xray.phantom import Phantom
from mammosim.xray.source_sampling import Field
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.transport_step import Body


@dataclass(frozen=True)
class ExposureSetup:
    """A phantom in a geometry, and the spectrum of the source.

    Raises XrayError when source or detector are inside the body, or the spectrum leaves the tables.
    """

    phantom: Phantom
    geometry: Geometry
    spectrum: Spectrum

    def __post_init__(self) -> None:
        require_outside(self.phantom, self.geometry)

    @cached_property
    def matter(self) -> Matter:
        """Cross-sections of the phantom's materials."""
        return matter(self.phantom.materials, float(self.spectrum.energies_kev[-1]))

    @cached_property
    def body(self) -> Body:
        """The phantom's voxels."""
        return body_of(self.phantom, self.matter)

    @cached_property
    def photons_per_mas(self) -> float:
        """How many photons start towards the detector, per mAs: N d^2 Omega."""
        N, d = float(self.spectrum.fluence.sum()), self.spectrum.distance_mm
        return N * d**2 * self.geometry.solid_angle()

    def beam(self, detector: Detector, share: np.ndarray | None = None) -> Field:
        """Source and a detector of coarser cells; share: of the energies, when not the spectrum's."""
        spectrum = self.spectrum if share is None else replace(self.spectrum, fluence=share)
        return field_of(self.geometry.source, detector, spectrum)

    def attenuations(self) -> np.ndarray:
        """mu (n_energy, n_material, 2) in 1/mm: total, and of scattering only."""
        E, materials = self.spectrum.energies_kev, self.phantom.materials
        total, absorbed = (
            np.stack([linear_attenuation(m, E, process=process) for m in materials], axis=1)
            for process in ("total", "photoelectric")
        )
        return np.stack([total, total - absorbed], axis=2)
