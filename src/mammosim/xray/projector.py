"""Images of the photons that pass without interaction: polychromatic Beer-Lambert along exact rays.

At a pixel, I = sum_E N(E) R(E) exp(-sum_m mu_m(E) L_m) (d/r)^2 cos(theta): N photons per mm2 at distance d,
R the signal of one photon, L_m mm in material m, r mm from the source, theta the angle to the normal.
Rows of pixels along an axis of the grid are traced together (xray.rows), others ray by ray (xray.siddon).
"""

from dataclasses import dataclass

import numpy as np

from mammosim.xray.attenuation import linear_attenuation
from mammosim.xray.geometry import Geometry
from mammosim.xray.phantom import Phantom
from mammosim.xray.response import Response
from mammosim.xray.rows import Rows, lines_along, no_lines, row_images, row_lengths
from mammosim.xray.siddon import lengths_to, transmitted
from mammosim.xray.spectrum import Spectrum, kerma_per_fluence

PARALLEL = 1e-12  # largest other component of a unit vector along an axis


@dataclass(frozen=True)
class Aligned:
    """Which pixels of a geometry's detector are a row: along `axis` of the grid (0, 1, 2 for x, y, z).

    transposed: the columns of the image are the rows of rays; flipped: they run to lower coordinates.
    """

    geometry: Geometry
    axis: int
    transposed: bool
    flipped: bool

    def rows(self, samples: int) -> Rows:
        """The rows of rays, `samples` rays per pixel, in the axes of xray.rows.Lines."""
        d = self.geometry.detector
        along, across = (d.v, d.u) if self.transposed else (d.u, d.v)
        n_row, n = d.shape[::-1] if self.transposed else d.shape
        corner = d.corner + (n * d.pixel_mm * along if self.flipped else 0.0)
        order = [self.axis, *(a for a in range(3) if a != self.axis)]
        source = np.asarray(self.geometry.source, float)
        return Rows(
            source[order],
            corner[order],
            d.pixel_mm * np.asarray(across, float)[order],
            d.pixel_mm / samples,
            self.geometry.source_height_mm,
            n_row,
            n * samples,
        )

    def as_image(self, found: np.ndarray) -> np.ndarray:
        """Values (n, n_row, n_ray) as images (n, nv, nu)."""
        found = found[..., ::-1] if self.flipped else found
        return np.ascontiguousarray(found.swapaxes(1, 2) if self.transposed else found)


def aligned_rows(geometry: Geometry) -> Aligned | None:
    """How the detector's pixels form rows along an axis of the grid; None when neither u nor v does."""
    for transposed, along in ((False, geometry.detector.u), (True, geometry.detector.v)):
        axis = int(np.argmax(np.abs(along)))
        if np.abs(np.delete(along, axis)).max() <= PARALLEL:
            return Aligned(geometry, axis, transposed, bool(along[axis] < 0))
    return None


@dataclass(frozen=True)
class Primary:
    """Images (nv, nu) of the primary, per mAs.

    signal: energy absorbed, keV/mm2; signal_squared: the same of its square, keV2/mm2: the quantum noise;
    kerma_mgy: air kerma at the detector; unobstructed: the signal with air only.
    """

    signal: np.ndarray
    signal_squared: np.ndarray
    kerma_mgy: np.ndarray
    unobstructed: np.ndarray


def path_lengths(phantom: Phantom, geometry: Geometry) -> np.ndarray:
    """Lengths (nv, nu, n_material) mm of the rays from the source to the pixel centres; [0] is the air."""
    n_material, aligned = len(phantom.materials), aligned_rows(geometry)
    if aligned is not None:
        lengths = row_lengths(lines_along(phantom, aligned.axis), aligned.rows(1), n_material)
        return np.ascontiguousarray(np.moveaxis(aligned.as_image(lengths), 0, -1))
    d = geometry.detector
    rows, columns = np.indices(d.shape)
    targets = d.origin + d.pixel_mm * (columns[..., None] * d.u + rows[..., None] * d.v)
    lengths = lengths_to(
        phantom.index, phantom.low, phantom.grid.spacing, geometry.source, targets.reshape(-1, 3), n_material
    )
    return lengths.reshape(*d.shape, -1)


def primary(
    phantom: Phantom,
    geometry: Geometry,
    spectrum: Spectrum,
    *,
    response: Response | None = None,
    supersampling: int = 1,
) -> Primary:
    """The primary image; the response is that of the detector to each photon.

    supersampling: rays per pixel and axis; their transmissions are averaged, not their lengths.
    """
    # ASSUME: without a response, the detector absorbs every photon; the signal is its energy.
    E, N = spectrum.energies_kev, spectrum.fluence * spectrum.distance_mm**2
    first, second = (E, E**2) if response is None else response.moments(E)
    mu = np.array([linear_attenuation(m, E) for m in phantom.materials])
    weights = np.array([N * first, N * second, N * kerma_per_fluence(E)])
    signal, squared, kerma = _images(phantom, geometry, mu, weights, supersampling)
    (unobstructed,) = _images(None, geometry, mu[:1], weights[:1], supersampling)
    return Primary(signal, squared, kerma, unobstructed)


def _images(
    phantom: Phantom | None, geometry: Geometry, mu: np.ndarray, weights: np.ndarray, samples: int
) -> np.ndarray:
    """Images (n_weight, nv, nu) of the spectra `weights`; without phantom of air."""
    aligned = aligned_rows(geometry)
    if aligned is not None:
        lines = no_lines() if phantom is None else lines_along(phantom, aligned.axis)
        return aligned.as_image(row_images(lines, aligned.rows(samples), samples, mu, weights))
    d, voxel = geometry.detector, np.ones(3)
    body = (np.zeros((1, 1, 1), np.uint8), -voxel, voxel)
    if phantom is not None:
        body = (phantom.index, phantom.low, phantom.grid.spacing)
    return transmitted(
        *body, np.asarray(geometry.source, float), d.corner, d.pixel_mm * d.u, d.pixel_mm * d.v, d.shape,
        samples, mu, weights,
    )  # fmt: skip
