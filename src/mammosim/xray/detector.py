"""What a detector shows of primary and scatter: signal, noise, and whatever steps of imaging there are.

A pixel of area A gathers S = sum of what each of its Poisson-many photons leaves, so that
mean(S) = A mAs (p + s), var(S) = A mAs (p2 + s2), with p, s in keV/mm2/mAs and p2, s2 in keV2/mm2/mAs.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import map_coordinates

from mammosim.core.errors import XrayError
from mammosim.xray.geometry import Detector
from mammosim.xray.imaging_steps import Energy, ImagingStep, QuantumNoise, Shot, after, weighted_sum
from mammosim.xray.projector import Primary
from mammosim.xray.response import Response


@dataclass(frozen=True)
class Scatter:
    """Scatter on the pixels of a detector (nv, nu), per mAs: signal in keV/mm2, its square in keV2/mm2."""

    signal: np.ndarray
    signal_squared: np.ndarray

    def left_in(self, response: Response) -> "Scatter":
        """What the same photons leave in a detector that does not absorb all of them."""
        # ASSUME: the response to scatter is that to photons of its mean energy, weighted by energy.
        E = np.divide(
            self.signal_squared, self.signal, out=np.full_like(self.signal, 20.0), where=self.signal > 0
        )
        knots = np.linspace(E.min(), E.max(), 50) if np.ptp(E) > 0 else np.array([E.flat[0]])
        first, second = (np.interp(E, knots, moment) for moment in response.moments(knots))
        return Scatter(self.signal * first / E, self.signal_squared * second / E**2)


@dataclass(frozen=True)
class Exposure:
    """Images (nv, nu) of one exposure, keV per pixel: with noise, its mean, its standard deviation."""

    image: np.ndarray
    mean: np.ndarray
    noise: np.ndarray
    mas: float


def on_pixels(values: np.ndarray, cells: Detector, pixels: Detector) -> np.ndarray:
    """Values (nv, nu) of coarse cells, linear between their centres, on pixels in the same plane."""
    # ASSUME: scatter varies so slowly that it is linear between the centres of coarse cells.
    rows, columns = np.indices(pixels.shape)
    s, t = cells.along(pixels.origin)
    at = np.stack([rows * pixels.pixel_mm + t, columns * pixels.pixel_mm + s]) / cells.pixel_mm - 0.5
    fine: np.ndarray = map_coordinates(values, at, order=1, mode="nearest")
    return fine


def expose(
    primary: Primary,
    scatter: Scatter | None,
    *,
    mas: float,
    pixel_mm: float,
    rng: np.random.Generator,
    steps: tuple[ImagingStep, ...] = (QuantumNoise(),),
) -> Exposure:
    """One exposure of `mas` on pixels of pixel_mm with some steps of imaging; no scatter when it is None.

    Raises XrayError when mas is not positive, or primary and scatter have different pixels.
    """
    shot = after(steps, _shot(primary, scatter, mas=mas, pixel_mm=pixel_mm, rng=rng))
    return Exposure(shot.image, shot.mean, np.sqrt(shot.variance), mas)


def template_sum(
    template: np.ndarray,
    primary: Primary,
    scatter: Scatter | None,
    *,
    mas: float,
    pixel_mm: float,
    steps: tuple[ImagingStep, ...] = (QuantumNoise(),),
) -> tuple[float, float]:
    """Mean and variance of the sum of template times image over all exposures; see expose.

    template: (nv, nu); in keV and keV2 where it is a pure number.
    """
    rng = np.random.default_rng(0)  # nothing is drawn from it
    shot = _shot(primary, scatter, mas=mas, pixel_mm=pixel_mm, rng=rng)
    return weighted_sum(steps, shot, template)


def _shot(
    primary: Primary, scatter: Scatter | None, *, mas: float, pixel_mm: float, rng: np.random.Generator
) -> Shot:
    """What is to come of one exposure."""
    if not 0 < mas < np.inf:
        raise XrayError(f"mas = {mas} must be positive; an automatic exposure gives it")
    nothing = np.zeros_like(primary.signal)
    if scatter is None:
        scatter = Scatter(nothing, nothing)
    if scatter.signal.shape != nothing.shape:
        raise XrayError(f"primary {nothing.shape} and scatter {scatter.signal.shape} have different pixels")
    per = pixel_mm**2 * mas
    direct, scattered = (Energy(e.signal, e.signal_squared).times(per) for e in (primary, scatter))
    # A stream of its own for the read-out, so that it leaves that of the photons as it is.
    photons, electronic = rng.spawn(2)
    return Shot(direct, scattered, pixel_mm, photons, electronic, nothing, nothing, nothing)
