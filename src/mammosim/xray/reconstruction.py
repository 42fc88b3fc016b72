"""Slices of tomosynthesis from a few views over a small arc: filtered backprojection and SART.

SART (Andersen & Kak 1984, Ultrason Imaging 6:81), view by view, with A of xray.laminography:

    V <- V + lambda  (A^T 1)^-1  A^T  [(b - A V) / (A 1)]

Filtered backprojection: where the rays of a view lean by alpha, f = sum_alpha d(alpha)/cos^2(alpha) (b' * h),
b' = b cos(theta) the integrals along z, h the ramp |f| along the motion of the source times a Hann window.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.core.volume import Grid, Image
from mammosim.xray.geometry import Geometry
from mammosim.xray.laminography import PARALLEL, View, add_sums, add_transposed, seen_flat, view_of

LEAST_SLICES = 1e-3  # rays that cross less of the slices say nothing about them
GOLDEN = 0.6180339887498949


@dataclass(frozen=True)
class Slices:
    """Attenuation 1/mm in slices (nz, ny, nx) float32; residuals: of SART, root mean square per iteration.

    The residual of an iteration is that of b - A V over the pixels, met just before each view is used.
    """

    image: Image
    residuals: tuple[float, ...] = ()


def line_integrals(signal: np.ndarray, unobstructed: np.ndarray) -> np.ndarray:
    """b = -ln(I/I0) float32 of images with and without a body. Raises XrayError unless both are positive."""
    if signal.shape != unobstructed.shape or not (np.all(signal > 0) and np.all(unobstructed > 0)):
        raise XrayError("images must have the same pixels and be positive everywhere; raise mAs or crop")
    b: np.ndarray = -np.log(signal / unobstructed).astype(np.float32)
    return b


def sart(
    integrals: Sequence[np.ndarray],
    geometries: Sequence[Geometry],
    grid: Grid,
    *,
    iterations: int = 3,
    relaxation: float = 0.5,
) -> Slices:
    """Slices on a grid from line integrals (nv, nu) of each geometry, from zero.

    Raises XrayError when numbers of views differ, the grid is not between detector and source, or relaxation
    is outside (0, 2), where the iteration grows.
    """
    if not 0 < relaxation < 2 or iterations < 1:
        raise XrayError(f"relaxation = {relaxation} must be in (0, 2), iterations = {iterations} at least 1")
    seen = _flattened(integrals, geometries)
    views = [view_of(grid, geometry) for _, geometry in seen]
    V = np.zeros(grid.shape, np.float32)
    residuals = []
    # ASSUME: views are used in golden steps, so that neighbours, which say the same, are far apart.
    order = np.argsort(np.arange(len(views)) * GOLDEN % 1)
    for _ in range(iterations):
        squares = [_corrected(V, seen[n][0], views[n], relaxation) for n in order]
        residuals.append(float(np.sqrt(np.mean(squares))))
    return Slices(Image(grid, V), tuple(residuals))


def _corrected(V: np.ndarray, b: np.ndarray, view: View, relaxation: float) -> float:
    """Changes V (nz, ny, nx) by one view of SART, and returns the mean square of b - A V before."""
    p = np.zeros(b.shape, V.dtype)
    add_sums(V, view.across, p)
    way, seen = view.way.astype(V.dtype), view.rows > LEAST_SLICES
    r = b / way - p
    square = float(np.mean((r * way)[seen].astype(float) ** 2))
    np.divide(r, view.rows.astype(V.dtype), out=r, where=seen)
    r[~seen] = 0
    add_transposed(r, view.across, (_inverse(view.of_y, relaxation), _inverse(view.of_x, 1.0)), V)
    return square


def filtered_backprojection(
    integrals: Sequence[np.ndarray], geometries: Sequence[Geometry], grid: Grid
) -> Slices:
    """Slices on a grid by filtering along x, the motion of the source, and averaging the rays of each voxel.

    Frequencies that a small arc does not see are zero: the mean is lost, and depth is blurred.
    Raises XrayError when there are fewer than two views, or the grid is not between detector and source.
    """
    seen = _flattened(integrals, geometries)
    if len(seen) < 2:
        raise XrayError("filtered backprojection needs at least two views")
    middle = grid.origin + (np.array(grid.shape[::-1]) - 1) / 2 * grid.spacing
    towards = np.array([geometry.source for _, geometry in seen]) - middle
    alpha = np.arctan2(towards[:, 0], towards[:, 2])
    weights = np.abs(np.gradient(alpha)) / np.cos(alpha) ** 2
    V = np.zeros(grid.shape, np.float32)
    for (b, geometry), weight in zip(seen, weights):
        view = view_of(grid, geometry)
        filtered = _ramp_filtered(b * (grid.spacing[2] / view.way), geometry.detector.pixel_mm)
        # the ramp per mm of a slice is that per mm of the detector, times the magnification
        magnified = np.abs(geometry.detector.pixel_mm / (view.across[:, 1] * grid.spacing[0]))
        per_y = _inverse(view.of_y, weight) * magnified[:, None].astype(np.float32)
        add_transposed(filtered, view.across, (per_y, _inverse(view.of_x, 1.0)), V)
    return Slices(Image(grid, V))


def _ramp_filtered(b: np.ndarray, pixel_mm: float) -> np.ndarray:
    """b (nv, nu) filtered along its rows with |f| sampled in space (Kak & Slaney 1988), and Hann's window."""
    n = b.shape[1]
    padded = 2 ** int(np.ceil(np.log2(2 * n)))
    offset = np.fft.fftfreq(padded, 1 / padded).round().astype(int)
    h = np.where(offset % 2 == 0, 0.0, -1 / (np.pi**2 * np.where(offset == 0, 1, offset) ** 2.0))
    h[0] = 0.25
    f = np.fft.rfftfreq(padded)
    response = np.fft.rfft(h).real / pixel_mm * (0.5 + 0.5 * np.cos(2 * np.pi * f))
    return np.fft.irfft(np.fft.rfft(b, padded, axis=1) * response, padded, axis=1)[:, :n].astype(np.float32)


def _inverse(sums: np.ndarray, factor: float) -> np.ndarray:
    """factor/sums float32, zero where no ray comes by."""
    some = sums > 1e-6
    inverse: np.ndarray = np.divide(factor, sums, out=np.zeros_like(sums), where=some).astype(np.float32)
    return inverse


def _flattened(
    integrals: Sequence[np.ndarray], geometries: Sequence[Geometry]
) -> list[tuple[np.ndarray, Geometry]]:
    """Views on detectors parallel to the slices. Raises XrayError when images and geometries do not match."""
    if not geometries or len(integrals) != len(geometries):
        raise XrayError(f"{len(integrals)} images, {len(geometries)} geometries: give one for each")
    found = []
    for b, geometry in zip(integrals, geometries):
        if b.shape != geometry.detector.shape or not np.all(np.isfinite(b)):
            raise XrayError(
                f"an image {b.shape} must be finite, and fit its detector {geometry.detector.shape}"
            )
        turned = abs(geometry.detector.normal[2] - 1) > PARALLEL
        b, geometry = seen_flat(b, geometry) if turned else (b, geometry)
        found.append((np.asarray(b, np.float32), geometry))
    return found
