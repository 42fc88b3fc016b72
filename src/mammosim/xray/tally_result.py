"""Tallies of a beam: means per photon over blocks of histories, with standard errors s/sqrt(n_block).

Tallies are those of plain transport, the other results those of one request each.
"""

from dataclasses import dataclass, field

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.core.units import G_PER_KG, J_PER_KEV, MGY_PER_GY
from mammosim.core.volume import Grid
from mammosim.xray.geometry import Detector
from mammosim.xray.phantom import Phantom


@dataclass(frozen=True)
class Estimate:
    """A tally and its standard error, arrays of the same shape."""

    value: np.ndarray
    error: np.ndarray


@dataclass(frozen=True)
class Tallies:
    """Means per photon that leaves the source towards the detector.

    materials: (n_material,) keV deposited in each material; [0] is the air, also that outside the grid.
    regions: (n_region,) keV deposited in the requested boxes.
    primary, scatter: (nv, nu) keV that reaches each cell of `detector`; scatter_squared: keV2, for its noise.
    emitted_kev, escaped_kev: what started and what left; photons_per_mas: how many start per mAs.
    """

    histories: int
    photons_per_mas: float
    detector: Detector
    materials: Estimate
    regions: Estimate
    primary: Estimate
    scatter: Estimate
    scatter_squared: Estimate
    emitted_kev: float
    escaped_kev: float

    @property
    def lost_kev(self) -> float:
        """Energy that is in no tally: emitted - deposited - detected - escaped; zero but for rounding."""
        detected = self.primary.value.sum() + self.scatter.value.sum()
        return float(self.emitted_kev - self.materials.value.sum() - detected - self.escaped_kev)

    def per_mas(self, cells: Estimate) -> Estimate:
        """A detector tally (nv, nu) as keV (or keV2) per mm2 and mAs."""
        scale = self.photons_per_mas / self.detector.pixel_mm**2
        return Estimate(cells.value * scale, cells.error * scale)


@dataclass
class Sums:
    """Running sums over blocks of each tally (n_tally,) and of its square."""

    blocks: int = 0
    first: np.ndarray = field(default_factory=lambda: np.zeros(()))
    second: np.ndarray = field(default_factory=lambda: np.zeros(()))

    def add(self, means: np.ndarray) -> None:
        """Blocks (n_block, n_tally), in their order."""
        self.blocks += len(means)
        self.first = self.first + means.sum(axis=0)
        self.second = self.second + (means**2).sum(axis=0)

    def estimate(self) -> Estimate:
        """Mean and s/sqrt(n)."""
        n, mean = self.blocks, self.first / self.blocks
        variance = np.maximum(self.second / n - mean**2, 0) * n / (n - 1)
        return Estimate(mean, np.sqrt(variance / n))


def tallies(estimates: list[Estimate], histories: int, photons: float, detector: Detector) -> Tallies:
    """The tallies of estimates of materials, regions, cells (3, nv, nu) and balance."""
    materials, regions, cells, balance = estimates
    primary, scatter, squared = (Estimate(cells.value[i], cells.error[i]) for i in range(3))
    emitted, escaped = map(float, balance.value)
    return Tallies(
        histories, photons, detector, materials, regions, primary, scatter, squared, emitted, escaped
    )


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
