"""gecatsim (XCIST, Wu et al. 2022, Phys Med Biol 67:194002) as another engine of the primary image.

Its distance-driven projector averages lengths over a pixel, where xray.projector follows single rays. Only
this compiled part is used (xray.catsim_library): it is given our materials as attenuation less that of air,
and one view at a time, so that its tube, filters, trajectory and scatter (made for computed tomography) do
not enter.
"""

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.xray.attenuation import linear_attenuation
from mammosim.xray.catsim_library import Flat, Voxels, depths
from mammosim.xray.geometry import Geometry
from mammosim.xray.phantom import Phantom
from mammosim.xray.projector import Primary
from mammosim.xray.response import Response
from mammosim.xray.spectrum import Spectrum, kerma_per_fluence

PARALLEL = 1e-9


def primary_by_catsim(
    phantom: Phantom, geometry: Geometry, spectrum: Spectrum, *, response: Response | None = None
) -> Primary:
    """The primary image as by xray.projector.primary, but with lengths averaged over pixels by gecatsim.

    The library writes messages to the terminal. Raises XrayError when gecatsim is not installed, the axes of
    the detector are not x and y, or voxels are not as long in z as in x.
    """
    _require_along_axes(geometry)
    E, N = spectrum.energies_kev, spectrum.fluence * spectrum.distance_mm**2
    first, second = (E, E**2) if response is None else response.moments(E)
    mu = np.array([linear_attenuation(m, E) for m in phantom.materials])  # (n_material, n_energy)
    depth = _depths(phantom, geometry, mu[1:] - mu[0])
    d = geometry.detector
    rows, columns = np.indices(d.shape)
    ends = d.origin + d.pixel_mm * (columns[..., None] * d.u + rows[..., None] * d.v)
    r = np.linalg.norm(ends - geometry.source, axis=-1)
    passed = np.exp(-mu[0] * r[..., None]) * (geometry.source_height_mm / r**3)[..., None]
    unobstructed = passed @ (N * first)
    passed *= np.exp(-depth)
    weights = (N * first, N * second, N * kerma_per_fluence(E))
    signal, squared, kerma = (passed @ w for w in weights)
    return Primary(signal, squared, kerma, unobstructed)


def _require_along_axes(geometry: Geometry) -> None:
    d = geometry.detector
    if max(np.abs(d.u[1:]).max(), np.abs(d.v[[0, 2]]).max()) > PARALLEL:
        raise XrayError("gecatsim's projector needs a detector along x and y; use xray.projector.primary")


def _depths(phantom: Phantom, geometry: Geometry, mu: np.ndarray) -> np.ndarray:
    """sum_m mu_m L_m (nv, nu, n_energy), mu (n_material - 1, n_energy) 1/mm of all materials but the air."""
    d = geometry.detector
    voxels = Voxels(phantom.index, (phantom.low + phantom.high) / 2, phantom.grid.spacing, mu)
    image = depths(voxels, Flat(geometry.source, d.middle, d.shape, d.pixel_mm))
    return image[:: 1 if d.v[1] > 0 else -1, :: 1 if d.u[0] > 0 else -1]
