"""Results of tallies requested of a beam: means per photon with standard errors, and what they took."""

from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.core.units import G_PER_KG, J_PER_KEV, MGY_PER_GY
from mammosim.core.volume import Grid
from mammosim.xray.geometry import Detector
from mammosim.xray.phantom import Phantom
from mammosim.xray.tallies import Estimate


@dataclass(frozen=True)
class MaterialsResult:
    """keV given to each material (n_material,) per photon that leaves the source towards the detector.

    photons_per_mas: how many such photons there are per mAs.
    """

    materials: Estimate
    histories: int
    photons_per_mas: float


@dataclass(frozen=True)
class RegionsResult:
    """The same for boxes (n_region,)."""

    regions: Estimate
    histories: int
    photons_per_mas: float


@dataclass(frozen=True)
class ScatterResult:
    """Scatter that reaches each cell of `detector`: (nv, nu) keV, and keV2 for its noise, per photon.

    requested: (nv, nu) bool, the cells whose uncertainty was requested.
    """

    scatter: Estimate
    scatter_squared: Estimate
    detector: Detector
    requested: np.ndarray
    histories: int
    photons_per_mas: float

    def per_mas(self, cells: Estimate) -> Estimate:
        """A tally (nv, nu) as keV (or keV2) per mm2 and mAs."""
        scale = self.photons_per_mas / self.detector.pixel_mm**2
        return Estimate(cells.value * scale, cells.error * scale)

    def to_primary(self, primary: np.ndarray) -> Estimate:
        """Scatter-to-primary ratio (nv, nu) of the cells; primary: per mAs, on the detector's own pixels.

        Raises XrayError when the pixels do not divide the cells.
        """
        (rows, columns), shape = primary.shape, self.detector.shape
        if rows % shape[0] or columns % shape[1]:
            raise XrayError(f"primary {primary.shape} cannot be gathered in {shape} cells; use one detector")
        cells = primary.reshape(shape[0], rows // shape[0], shape[1], columns // shape[1]).mean(axis=(1, 3))
        scatter = self.per_mas(self.scatter)
        return Estimate(scatter.value / cells, scatter.error / cells)


@dataclass(frozen=True)
class MapResult:
    """keV given to each cell of `grid` (nz, ny, nx) per photon that leaves towards the detector."""

    energy: Estimate
    grid: Grid
    histories: int
    photons_per_mas: float

    def dose_per_mas(self, phantom: Phantom) -> Estimate:
        """mGy per mAs in each cell: its energy over the mass of its voxels."""
        size = np.round(self.grid.spacing[::-1] / phantom.grid.spacing[::-1]).astype(int)
        density = np.array([m.density_g_cm3 for m in phantom.materials])[phantom.index]
        padded = np.pad(density, [(0, n * k - d) for n, k, d in zip(self.grid.shape, size, density.shape)])
        shape = np.stack([self.grid.shape, size], axis=1).ravel()
        mass_g = padded.reshape(shape).sum(axis=(1, 3, 5)) * phantom.grid.voxel_volume / 1e3
        scale = self.photons_per_mas * J_PER_KEV * G_PER_KG * MGY_PER_GY / mass_g
        return Estimate(self.energy.value * scale, self.energy.error * scale)


TallyResult = MaterialsResult | RegionsResult | ScatterResult | MapResult
