"""What happens to an image between the body and the number in a pixel: each step is an object, or absent.

Every step takes what a detector pixel holds, in keV, and returns it changed. Their order is that of the
light: tube (Heel, FocalSpot), grid, counting of quanta, spread in the detector (Blur), pixels (Structure),
electronics. From the quanta n on all are linear, so that a weighted sum of pixels has a known mean:

    g = G B n + e:    mean w.g = (B G w).mean n,    var w.g = (B G w)^2.var n + w^2.var e
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import ClassVar, Protocol, cast

import numpy as np
from scipy.fft import dctn, idctn
from scipy.ndimage import gaussian_filter
from scipy.special import ndtr

from mammosim.core.errors import XrayError
from mammosim.core.rng import generator

FWHM_PER_SIGMA = 2 * np.sqrt(2 * np.log(2))
FEW = (
    30.0  # photons; of more, the expansion has their mean, their variance to 2e-6, the third moment to 0.4 %
)


@dataclass(frozen=True)
class Energy:
    """Sums per pixel (nv, nu) over its photons: of what each leaves, keV, and of the square of that, keV2."""

    signal: np.ndarray
    squared: np.ndarray

    def times(self, factor: np.ndarray | float) -> "Energy":
        """The same photons, more or fewer of them."""
        return Energy(self.signal * factor, self.squared * factor)


@dataclass(frozen=True)
class Shot:
    """One exposure of pixels of pixel_mm: primary and scatter to come, and what was made of them.

    image, mean, variance: (nv, nu) in keV, keV, keV2; the image is the mean and one draw of the noise.
    rng, rng_electronic: of photons, and of the read-out.
    """

    primary: Energy
    scatter: Energy
    pixel_mm: float
    rng: np.random.Generator
    rng_electronic: np.random.Generator
    image: np.ndarray
    mean: np.ndarray
    variance: np.ndarray

    def detected(self) -> "Shot":
        """The image of primary and scatter, still without noise."""
        mean = self.primary.signal + self.scatter.signal
        return replace(self, image=mean, mean=mean, variance=np.zeros_like(mean))


class ImagingStep(Protocol):
    """stage: its place in the order of the light; below DETECTION it changes photons, above it the image."""

    stage: ClassVar[int]

    def __call__(self, shot: Shot) -> Shot: ...


DETECTION = 3


class DetectorStep(ImagingStep, Protocol):
    """A step from DETECTION on, which is linear but for the noise that it adds."""

    def back(self, w: np.ndarray, shot: Shot) -> tuple[np.ndarray, float]:
        """Weights of what comes in whose sum is that of what goes out with weights w (nv, nu).

        And the variance in keV2 that the step's own noise adds to the sum.
        """
        ...


@dataclass(frozen=True)
class Heel:
    """The anode's own absorption: the primary of each pixel times factor (nv, nu), see xray.equipment."""

    stage: ClassVar[int] = 0
    factor: np.ndarray

    def __call__(self, shot: Shot) -> Shot:
        # ASSUME: the heel takes photons of all energies alike; scatter, from everywhere, does not show it.
        return replace(shot, primary=shot.primary.times(self.factor))


@dataclass(frozen=True)
class FocalSpot:
    """A Gaussian focal spot of fwhm_mm (full width at half maximum), seen at a magnification.

    Raises XrayError when the width is not positive, or the magnification below one.
    """

    stage: ClassVar[int] = 1
    fwhm_mm: float
    magnification: float

    def __post_init__(self) -> None:
        if not 0 < self.fwhm_mm < 5 or not 1 <= self.magnification < 5:
            raise XrayError(
                f"focal spot of {self.fwhm_mm} mm at magnification {self.magnification}: "
                "usual are 0.1 to 0.4 mm at 1 to 2"
            )

    def __call__(self, shot: Shot) -> Shot:
        # ASSUME: the whole body is blurred like one plane of it, that of the given magnification.
        sigma = self.fwhm_mm * (self.magnification - 1) / FWHM_PER_SIGMA / shot.pixel_mm
        sums = (shot.primary.signal, shot.primary.squared)
        return replace(shot, primary=Energy(*(gaussian_filter(e, sigma, mode="nearest") for e in sums)))


@dataclass(frozen=True)
class Grid:
    """An anti-scatter grid: the shares of primary and of scatter that pass.

    Raises XrayError when one is outside (0, 1].
    """

    stage: ClassVar[int] = 2
    primary: float
    scatter: float

    def __post_init__(self) -> None:
        if not (0 < self.primary <= 1 and 0 < self.scatter <= 1):
            raise XrayError(
                f"a grid passes shares, not {self.primary} of primary and {self.scatter} of scatter"
            )

    def __call__(self, shot: Shot) -> Shot:
        # ASSUME: a grid passes the same share everywhere and at all energies, and shows no lines.
        return replace(
            shot, primary=shot.primary.times(self.primary), scatter=shot.scatter.times(self.scatter)
        )


@dataclass(frozen=True)
class QuantumNoise:
    """Poisson many photons: variance is the sum of the squares of what each leaves."""

    stage: ClassVar[int] = DETECTION

    def __call__(self, shot: Shot) -> Shot:
        # ASSUME: the energy in a pixel is q times a Poisson number, q = variance/mean: both are right.
        squared, mean = shot.primary.squared + shot.scatter.squared, shot.mean
        q = np.divide(squared, mean, out=np.ones_like(mean), where=mean > 0)
        image = q * poisson_at(shot.rng.standard_normal(mean.shape), mean / q)
        return replace(shot, image=image, variance=shot.variance + squared)

    def back(self, w: np.ndarray, shot: Shot) -> tuple[np.ndarray, float]:
        return w, float(np.sum(w**2 * (shot.primary.squared + shot.scatter.squared)))


def poisson_at(z: np.ndarray, mean: np.ndarray) -> np.ndarray:
    """The Poisson number at the quantile of a normal number z; z and mean have the same shape.

    One normal number a pixel, whatever its mean: images of one stream differ only by what their bodies do.
    Above FEW the number is not rounded, mean + sqrt(mean) z + (z^2 - 1)/6 + (z - z^3)/(72 sqrt(mean))
    (Cornish & Fisher 1938, Rev Int Stat Inst 5:307), which has the moments of Poisson as FEW says.
    """
    few = mean < FEW
    root = np.sqrt(np.where(few, 1.0, mean))
    number: np.ndarray = mean + root * z + (z**2 - 1) / 6 + (z - z**3) / (72 * root)
    from scipy.stats import poisson  # here, since it takes a third of a second that most stages need not

    number[few] = np.where(mean[few] > 0, poisson.ppf(ndtr(z[few]), np.maximum(mean[few], 1e-12)), 0.0)
    return number


@dataclass(frozen=True)
class Blur:
    """Spread in the detector with the transfer T(f), gaussian exp(-(f/f0)^2) or lorentzian 1/(1 + (f/f0)^2).

    The aperture of the pixel, sinc(f pixel), is in the image already. Raises XrayError for another shape.
    """

    stage: ClassVar[int] = 4
    shape: str
    per_mm: float

    def __post_init__(self) -> None:
        if self.shape not in ("gaussian", "lorentzian") or not self.per_mm > 0:
            raise XrayError(f"blur {self.shape!r} of {self.per_mm}/mm: gaussian or lorentzian, 1 to 20/mm")

    def transfer(self, f: np.ndarray) -> np.ndarray:
        """T at spatial frequencies f per mm."""
        s2 = (f / self.per_mm) ** 2
        return np.exp(-s2) if self.shape == "gaussian" else 1 / (1 + s2)

    def __call__(self, shot: Shot) -> Shot:
        # ASSUME: the detector blurs what its pixels sampled: frequencies beyond theirs do not fold back.
        T = self._on(shot.image.shape, shot.pixel_mm)
        # white noise of neighbours mixes: its variance falls by the mean of T^2
        left = float(np.mean(T**2))
        return replace(
            shot,
            image=_filtered(shot.image, T),
            mean=_filtered(shot.mean, T),
            variance=_filtered(shot.variance, T) * left,
        )

    def back(self, w: np.ndarray, shot: Shot) -> tuple[np.ndarray, float]:
        return _filtered(w, self._on(w.shape, shot.pixel_mm)), 0.0

    def _on(self, shape: tuple[int, ...], pixel_mm: float) -> np.ndarray:
        """T at the frequencies of the cosine transform of an image."""
        fv, fu = (np.arange(n) / (2 * n * pixel_mm) for n in shape)
        return self.transfer(np.hypot(fv[:, None], fu))


@dataclass(frozen=True)
class Structure:
    """Pixels whose gain differs by `share` (standard deviation), the same in every image of one `seed`."""

    stage: ClassVar[int] = 5
    share: float
    seed: int

    def __call__(self, shot: Shot) -> Shot:
        gain = self.gain(shot.image.shape)
        return replace(shot, image=shot.image * gain, variance=shot.variance + (self.share * shot.mean) ** 2)

    def back(self, w: np.ndarray, shot: Shot) -> tuple[np.ndarray, float]:
        return w * self.gain(w.shape), 0.0

    def gain(self, shape: tuple[int, ...]) -> np.ndarray:
        """The gain of each pixel."""
        # ASSUME: what flat-field correction leaves of the gains is white.
        return 1 + self.share * generator(self.seed, "structure").standard_normal(shape)


@dataclass(frozen=True)
class ElectronicNoise:
    """Normal noise of the read-out, kev per pixel (standard deviation)."""

    stage: ClassVar[int] = 6
    kev: float

    def __call__(self, shot: Shot) -> Shot:
        noise = self.kev * shot.rng_electronic.standard_normal(shot.image.shape)
        return replace(shot, image=shot.image + noise, variance=shot.variance + self.kev**2)

    def back(self, w: np.ndarray, shot: Shot) -> tuple[np.ndarray, float]:
        return w, float(self.kev**2 * np.sum(w**2))


def after(steps: Iterable[ImagingStep], shot: Shot) -> Shot:
    """What the steps make of a shot, in the order of the light, in whatever order they are given."""
    before, behind = _ordered(steps)
    shot = _photons(before, shot)
    for step in behind:
        shot = step(shot)
    return shot


def weighted_sum(steps: Iterable[ImagingStep], shot: Shot, w: np.ndarray) -> tuple[float, float]:
    """Mean and variance of sum w g over all exposures like this one, keV and keV2; w (nv, nu)."""
    before, behind = _ordered(steps)
    shot, variance = _photons(before, shot), 0.0
    for step in reversed(behind):
        w, added = step.back(w, shot)
        variance += added
    return float(np.sum(w * shot.mean)), variance


def _ordered(steps: Iterable[ImagingStep]) -> tuple[list[ImagingStep], list[DetectorStep]]:
    """Those of the photons and those of the detector, in the order of the light."""
    ordered = sorted(steps, key=lambda step: step.stage)
    behind = [cast(DetectorStep, step) for step in ordered if step.stage >= DETECTION]
    return ordered[: len(ordered) - len(behind)], behind


def _photons(steps: Iterable[ImagingStep], shot: Shot) -> Shot:
    """What reaches the detector, still without noise."""
    for step in steps:
        shot = step(shot)
    return shot.detected()


def _filtered(image: np.ndarray, T: np.ndarray) -> np.ndarray:
    """An image times T (nv, nu) at k/(2 n pixel), mirrored at its borders: what the cosine transform does."""
    filtered: np.ndarray = idctn(dctn(image) * T)
    return filtered
