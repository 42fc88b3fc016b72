"""The beam that reaches the breast: what a paddle and air leave of the tube's spectrum, its quality, and the
mAs at which the detector behind the breast receives a wanted air kerma.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.ndimage import uniform_filter

from mammosim.core.errors import XrayError
from mammosim.xray.attenuation import material
from mammosim.xray.spectrum import Spectrum, value_layer

PLASTICS = ("pmma", "polycarbonate")
PADDLE_LIMITS_MM = (0.5, 5.0)


@dataclass(frozen=True)
class Paddle:
    """A compression paddle in the beam. Raises XrayError for another plastic or an unlikely thickness."""

    plastic: str = "pmma"
    thickness_mm: float = 2.0

    def __post_init__(self) -> None:
        low, high = PADDLE_LIMITS_MM
        if self.plastic not in PLASTICS:
            raise XrayError(f"no paddle is of {self.plastic!r}; choose one of: {', '.join(PLASTICS)}")
        if not low <= self.thickness_mm <= high:
            raise XrayError(
                f"paddle of {self.thickness_mm} mm is outside {low:g} to {high:g} mm; give mm, usual is 2"
            )

    def __call__(self, beam: Spectrum) -> Spectrum:
        """The beam behind the paddle."""
        # ASSUME: what the paddle scatters towards the breast is lost, unless it is part of the phantom.
        return beam.through(material(self.plastic), self.thickness_mm)


@dataclass(frozen=True)
class AirGap:
    """The air between the tube and a place length_mm away, where the beam then is: inverse square and air.

    Raises XrayError when the length is not positive.
    """

    length_mm: float

    def __post_init__(self) -> None:
        if not 0 < self.length_mm < 5000:
            raise XrayError(f"an air gap of {self.length_mm} mm is outside 0 to 5000 mm")

    def __call__(self, beam: Spectrum) -> Spectrum:
        """The beam at length_mm from the source, in air."""
        return beam.at(self.length_mm).through(material("air"), self.length_mm)


def in_the_way(beam: Spectrum, layers: Iterable[Paddle | AirGap]) -> Spectrum:
    """The beam behind some layers; without any the beam itself."""
    for layer in layers:
        beam = layer(beam)
    return beam


def quality(beam: Spectrum) -> dict[str, float | str]:
    """One row: name, half-value layers, homogeneity, mean energy, and air kerma per mAs at its distance."""
    first, both = (value_layer(beam, fraction=f) for f in (0.5, 0.25))
    return {
        "beam": beam.name,
        "hvl_mm_al": first,
        "second_hvl_mm_al": both - first,
        "homogeneity": first / (both - first),
        "mean_energy_kev": beam.mean_energy_kev,
        "kerma_ugy_per_mas": 1e3 * beam.kerma_mgy_per_mas,
        "distance_mm": beam.distance_mm,
    }


def quality_table(beams: Iterable[Spectrum], layers: tuple[Paddle | AirGap, ...] = ()) -> pd.DataFrame:
    """One row per beam, see quality; with layers the half-value layer behind them is hvl_behind_mm_al."""
    rows = []
    for beam in beams:
        row = quality(beam)
        if layers:
            behind = in_the_way(beam, layers)
            row |= {
                "hvl_behind_mm_al": behind.hvl_mm_al,
                "kerma_behind_ugy_per_mas": 1e3 * behind.kerma_mgy_per_mas,
            }
        rows.append(row)
    return pd.DataFrame(rows)


def automatic_mas(
    kerma_mgy_per_mas: np.ndarray, breast: np.ndarray, *, target_mgy: float, sensor_pixels: int
) -> float:
    """mAs = target/K, K the least mean air kerma of a square of sensor_pixels^2 behind the breast.

    kerma_mgy_per_mas: (nv, nu) at the detector; breast: (nv, nu) bool, its shadow.
    Raises XrayError when the target is not positive, or no such square fits in the shadow.
    """
    # ASSUME: automatic exposure sees the air kerma of the primary behind the densest square of the breast.
    if not 0 < target_mgy < np.inf:
        raise XrayError(
            f"target_mgy = {target_mgy} must be positive; detectors are exposed to 0.02 to 0.2 mGy"
        )
    size = sensor_pixels
    inside = uniform_filter(breast.astype(float), size, mode="constant") > 1 - 0.5 / size**2
    if not inside.any():
        raise XrayError(
            f"no square of {size} x {size} pixels fits in the breast's shadow; make sensor_pixels smaller"
        )
    K = uniform_filter(kerma_mgy_per_mas, size, mode="nearest")[inside].min()
    return float(target_mgy / K)
