"""Monte Carlo tallies: means per photon over blocks of histories, with standard errors s/sqrt(n_block)."""

from dataclasses import dataclass, field

import numpy as np

from mammosim.xray.geometry import Detector


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
