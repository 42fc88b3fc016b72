"""Images of the photons that pass without interaction: polychromatic Beer-Lambert along exact rays.

At a pixel, I = sum_E N(E) R(E) exp(-sum_m mu_m(E) L_m) (d/r)^2 cos(theta): N photons per mm2 at distance d,
R the signal of one photon, L_m mm in material m, r mm from the source, theta the angle to the normal.
"""

from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.xray.attenuation import linear_attenuation
from mammosim.xray.geometry import Geometry
from mammosim.xray.phantom import Phantom
from mammosim.xray.siddon import lengths_to, transmitted
from mammosim.xray.spectrum import Spectrum, kerma_per_fluence


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
    d = geometry.detector
    rows, columns = np.indices(d.shape)
    targets = d.origin + d.pixel_mm * (columns[..., None] * d.u + rows[..., None] * d.v)
    lengths = lengths_to(
        phantom.index, phantom.low, phantom.grid.spacing, geometry.source, targets.reshape(-1, 3),
        len(phantom.materials),
    )  # fmt: skip
    return lengths.reshape(*d.shape, -1)


def primary(
    phantom: Phantom,
    geometry: Geometry,
    spectrum: Spectrum,
    *,
    response: np.ndarray | None = None,
    supersampling: int = 1,
) -> Primary:
    """The primary image; response (n_energy,) is the mean energy in keV that a photon leaves in the detector.

    supersampling: rays per pixel and axis; their transmissions are averaged, not their lengths.
    Raises XrayError when the response does not fit the spectrum.
    """
    # ASSUME: without a given response, the detector absorbs every photon; the signal is its energy.
    E, N = spectrum.energies_kev, spectrum.fluence * spectrum.distance_mm**2
    R = E if response is None else np.asarray(response, float)
    if R.shape != E.shape:
        raise XrayError(f"response {R.shape} must have one value per energy of the spectrum {E.shape}")
    mu = np.array([linear_attenuation(m, E) for m in phantom.materials])
    weights = np.array([N * R, N * R**2, N * kerma_per_fluence(E)])
    d = geometry.detector

    def images(index: np.ndarray, rows: np.ndarray) -> np.ndarray:
        return transmitted(
            index, phantom.low, phantom.grid.spacing, np.asarray(geometry.source, float), d.corner,
            d.pixel_mm * d.u, d.pixel_mm * d.v, d.shape, supersampling, mu, rows,
        )  # fmt: skip

    signal, squared, kerma = images(phantom.index, weights)
    (unobstructed,) = images(np.zeros((1, 1, 1), np.uint8), weights[:1])
    return Primary(signal, squared, kerma, unobstructed)
