"""An ideal energy-integrating detector: what it shows of primary and scatter, and its quantum noise.

A pixel of area A gathers S = sum of the energies of Poisson-many photons, so that
mean(S) = A mAs (p + s), var(S) = A mAs (p2 + s2), with p, s in keV/mm2/mAs and p2, s2 in keV2/mm2/mAs.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import map_coordinates

from mammosim.core.errors import XrayError
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.projector import Primary
from mammosim.xray.tallies import Tallies


@dataclass(frozen=True)
class Scatter:
    """Scatter on the pixels of a detector (nv, nu), per mAs: signal in keV/mm2, its square in keV2/mm2."""

    signal: np.ndarray
    signal_squared: np.ndarray


@dataclass(frozen=True)
class Exposure:
    """Images (nv, nu) of one exposure, gain x keV per pixel: with noise, its mean, its standard deviation."""

    image: np.ndarray
    mean: np.ndarray
    noise: np.ndarray
    mas: float


def scatter_on(tallies: Tallies, geometry: Geometry) -> Scatter:
    """The scatter of the tallies' coarse cells, interpolated to the pixels of the geometry's detector.

    Raises XrayError when cells and pixels do not belong to the same detector.
    """
    # ASSUME: scatter varies so slowly that it is linear between the centres of coarse cells.
    pixels, cells = geometry.detector, tallies.detector
    if not np.allclose(pixels.corner, cells.corner) or not np.allclose(pixels.size_mm, cells.size_mm):
        raise XrayError("the tallies belong to another detector; run transport with this geometry")
    per_mas = (tallies.per_mas(tally).value for tally in (tallies.scatter, tallies.scatter_squared))
    return Scatter(*(on_pixels(tally, cells.pixel_mm, pixels) for tally in per_mas))


def on_pixels(cells: np.ndarray, cell_mm: float, pixels: Detector) -> np.ndarray:
    """Values of coarse cells, linear between their centres, on the pixels (nv, nu) of the same detector."""
    ratio = pixels.pixel_mm / cell_mm
    rows, columns = np.indices(pixels.shape)
    at = np.stack([(rows + 0.5) * ratio - 0.5, (columns + 0.5) * ratio - 0.5])
    return map_coordinates(cells, at, order=1, mode="nearest")


def expose(
    primary: Primary,
    scatter: Scatter | None,
    *,
    mas: float,
    pixel_mm: float,
    rng: np.random.Generator,
    gain: float = 1.0,
) -> Exposure:
    """One exposure of `mas` on pixels of pixel_mm, signal in gain x keV; without scatter when it is None.

    Raises XrayError when mas is not positive, or primary and scatter have different pixels.
    """
    if not 0 < mas < np.inf:
        raise XrayError(f"mas = {mas} must be positive; an automatic exposure gives it")
    signal, squared = primary.signal, primary.signal_squared
    if scatter is not None:
        if scatter.signal.shape != signal.shape:
            raise XrayError(
                f"primary {signal.shape} and scatter {scatter.signal.shape} have different pixels"
            )
        signal, squared = signal + scatter.signal, squared + scatter.signal_squared
    mean, variance = signal * pixel_mm**2 * mas, squared * pixel_mm**2 * mas
    # ASSUME: the energy in a pixel is q times a Poisson number, q = variance/mean: right mean and variance.
    # ASSUME: pixels are independent: the detector neither blurs nor adds electronic noise.
    q = np.divide(variance, mean, out=np.ones_like(mean), where=mean > 0)
    image = q * rng.poisson(mean / q)
    return Exposure(gain * image, gain * mean, gain * np.sqrt(variance), mas)
