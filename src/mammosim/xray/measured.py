"""What a physicist measures on images: noise power of flat fields, transfer of an edge, point-spread widths.

The first two follow IEC 62220-1-2: periodograms of squares, and a slanted edge resampled finely. The depth
profile of a small ball in slices, (S(z) - B(z)) / (S(z0) - B(z0)), is the artefact spread function (Wu et al.
2004, Med Phys 31:2636): S at the ball's place in each slice, B in the background of the same slice.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.core.volume import Image

BINS_PER_PIXEL = 8
NEAR_PIXELS = 8  # where the line spread is looked for


@dataclass(frozen=True)
class Curve:
    """A function of the spatial frequency f (n,) per mm: value (n,) and its standard error (n,)."""

    f: np.ndarray
    value: np.ndarray
    error: np.ndarray


def noise_power(images: Sequence[np.ndarray], mean: np.ndarray, *, pixel_mm: float, side: int = 64) -> Curve:
    """Radial noise power of flat images (nv, nu) about their known mean, signal squared times mm2.

    NPS = pixel^2/side^2 <|DFT(I - mean)|^2> over squares of side^2 pixels, averaged over rings of |f|.
    The error is that of independent periodograms, each as large as its own standard deviation; a pair of
    opposite frequencies is one of them. Raises XrayError when no square fits.
    """
    rows, columns = (n // side for n in mean.shape)
    if rows * columns == 0:
        raise XrayError(f"no square of {side} pixels fits into images of {mean.shape}; make side smaller")
    total, count = np.zeros((side, side)), 0
    for image in images:
        cut = (image - mean)[: rows * side, : columns * side]
        squares = cut.reshape(rows, side, columns, side).swapaxes(1, 2).reshape(-1, side, side)
        total += np.sum(np.abs(np.fft.fft2(squares)) ** 2, axis=0)
        count += len(squares)
    power = total * pixel_mm**2 / side**2 / count
    f = np.hypot(*np.meshgrid(np.fft.fftfreq(side, pixel_mm), np.fft.fftfreq(side, pixel_mm)))
    step = 1 / (side * pixel_mm)
    ring = np.round(f / step).astype(int).ravel()
    used = (ring > 0) & (ring <= side // 2)
    n = np.bincount(ring[used])[1:]
    value = np.bincount(ring[used], power.ravel()[used])[1:] / n
    at = np.bincount(ring[used], f.ravel()[used])[1:] / n
    return Curve(at, value, value / np.sqrt(count * n / 2))


def edge_transfer(images: Sequence[np.ndarray], *, slope: float, pixel_mm: float) -> Curve:
    """Presampled transfer function, up to the pixels' limit, from images of an edge x = x0 + slope y.

    Rows shifted by the slope fill bins of an eighth of a pixel. The derivative of this profile is the line
    spread s, and T(f) = sum_n s_n cos(2 pi f (x_n - x0)) / sum_n s_n, x0 the centroid of the symmetric s.
    The error is that of the mean of the images.
    Raises XrayError when there are fewer than two images, or the slope is not small or fills no bins.
    """
    nv, nu = images[0].shape
    if len(images) < 2 or not 1 / nv <= abs(slope) < 0.2:
        raise XrayError(f"give two images or more, and a slope from 1/rows to 0.2, not {slope}")
    spreads = np.array([_line_spread(image, slope) for image in images])
    x = np.arange(spreads.shape[1]) / BINS_PER_PIXEL
    mean = spreads.mean(axis=0)
    near = np.abs(x - x[np.argmax(np.abs(mean))]) < NEAR_PIXELS
    x0 = x[near] @ mean[near] / mean[near].sum()
    f = np.arange(1, nu // 4) / (nu // 2)
    # bins average over their width, and differences are taken over one: each is a sinc
    T = spreads @ np.cos(2 * np.pi * np.outer(x - x0, f)) / np.sinc(f / BINS_PER_PIXEL) ** 2
    T /= spreads.sum(axis=1, keepdims=True)
    return Curve(f / pixel_mm, T.mean(axis=0), T.std(axis=0, ddof=1) / np.sqrt(len(images)))


def _line_spread(image: np.ndarray, slope: float) -> np.ndarray:
    """Differences between bins of an edge profile, the middle of the rows at rest."""
    nv, nu = image.shape
    place = np.arange(nu) - slope * (np.arange(nv)[:, None] - (nv - 1) / 2)
    margin = int(np.ceil(abs(slope) * nv / 2)) + 1
    bins = np.floor((place - margin) * BINS_PER_PIXEL).astype(int)
    n = (nu - 2 * margin) * BINS_PER_PIXEL
    used = (bins >= 0) & (bins < n)
    return np.diff(np.bincount(bins[used], image[used], n) / np.bincount(bins[used], minlength=n))


@dataclass(frozen=True)
class PointSpreadWidths:
    """Widths in mm along x, the motion of the source, along y, and in depth z; where it is seen (3,) mm."""

    x_mm: float
    y_mm: float
    z_mm: float
    place: np.ndarray


def point_spread_widths(image: Image, place: np.ndarray, *, radius_mm: float) -> PointSpreadWidths:
    """Widths of a ball near place (3,) mm.

    Profiles run through the brightest voxel within radius_mm of it in x and y. Their background is the median
    of the slice within 4 radii.
    Raises XrayError when place is not inside, or a profile does not fall to its half on both sides.
    """
    grid, V = image.grid, image.values
    k, j, i = np.round(grid.indices(np.asarray(place, float)[None])[0]).astype(int)
    if not all(0 <= n < size for n, size in zip((k, j, i), V.shape)):
        raise XrayError(f"place {place} mm is outside the slices")
    near = max(int(np.ceil(radius_mm / grid.spacing[:2].min())), 1)
    low_j, low_i = max(j - near, 0), max(i - near, 0)
    window = V[:, low_j : j + near + 1, low_i : i + near + 1]
    k, dj, di = np.unravel_index(int(np.argmax(window)), window.shape)
    j, i = low_j + int(dj), low_i + int(di)
    far = 4 * near
    around = V[:, max(j - far, 0) : j + far + 1, max(i - far, 0) : i + far + 1].astype(float)
    background = np.median(around, axis=(1, 2))
    profiles = (V[k, j] - background[k], V[k, :, i] - background[k], V[:, j, i] - background)
    x, y, z = (_width(p, n) * h for p, n, h in zip(profiles, (i, j, k), grid.spacing))
    return PointSpreadWidths(x, y, z, grid.points(np.array([[k, j, i]], float))[0])


def _width(profile: np.ndarray, peak: int) -> float:
    """Full width at half of the value at the peak, in samples, linear between them."""
    half, sides = profile[peak] / 2, []
    for side in (profile[peak::-1], profile[peak:]):
        below = np.nonzero(side < half)[0]
        if not below.size:
            raise XrayError("a profile does not fall to its half inside the slices; make them larger")
        n = int(below[0])
        sides.append(n - 1 + (side[n - 1] - half) / (side[n - 1] - side[n]))
    return float(sum(sides))
