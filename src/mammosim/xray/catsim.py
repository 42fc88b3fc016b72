"""gecatsim (XCIST, Wu et al. 2022, Phys Med Biol 67:194002) as another engine of the primary image.

Its distance-driven projector averages lengths over a pixel, where xray.projector follows single rays. Only
this compiled part is used, by ctypes: it is given our materials as attenuation less that of air, and one view
at a time, so that its tube, filters, trajectory and scatter (made for computed tomography) do not enter.
Its axes are (x, z, y) of ours, and its first slice along z is the highest.
"""

import ctypes
from ctypes import POINTER, byref, c_float, c_int
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from numpy.ctypeslib import ndpointer

from mammosim.core.errors import XrayError
from mammosim.xray.attenuation import linear_attenuation
from mammosim.xray.geometry import Geometry
from mammosim.xray.phantom import Phantom
from mammosim.xray.projector import Primary
from mammosim.xray.response import Response
from mammosim.xray.spectrum import Spectrum, kerma_per_fluence

TO_CATSIM = [0, 2, 1]
ARRAY = ndpointer(c_float)
PARALLEL = 1e-9


def primary_by_catsim(
    phantom: Phantom, geometry: Geometry, spectrum: Spectrum, *, response: Response | None = None
) -> Primary:
    """The primary image as by xray.projector.primary, but with lengths averaged over pixels by gecatsim.

    The library writes messages to the terminal. Raises XrayError when gecatsim is not installed, the axes of
    the detector are not x and y, or voxels are not as long in z as in x.
    """
    _require_simple(phantom, geometry)
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


def _require_simple(phantom: Phantom, geometry: Geometry) -> None:
    d, (dx, _, dz) = geometry.detector, phantom.grid.spacing
    if max(np.abs(d.u[1:]).max(), np.abs(d.v[[0, 2]]).max()) > PARALLEL:
        raise XrayError("gecatsim's projector needs a detector along x and y; use xray.projector.primary")
    if not np.isclose(dx, dz, rtol=1e-6):
        raise XrayError(
            f"gecatsim's voxels are as long in z as in x, not {dz:g} and {dx:g} mm; resample them"
        )


def _depths(phantom: Phantom, geometry: Geometry, mu: np.ndarray) -> np.ndarray:
    """sum_m mu_m L_m (nv, nu, n_energy), mu (n_material - 1, n_energy) 1/mm of all materials but the air."""
    library, d = _library(), geometry.detector
    count, n_energy = mu.shape
    (nv, nu), (nz, ny, nx) = d.shape, phantom.index.shape
    library.set_material_info_vox(count, n_energy, _single(mu.T))
    # slices from above, then (x, y): the order of its volumes
    index = phantom.index[::-1].transpose(0, 2, 1)
    dims = np.array([nx, nz, ny, count], np.int32)
    offset = _single((phantom.low + phantom.high) / 2)[TO_CATSIM]
    dx, dy, _ = phantom.grid.spacing
    mask = np.ones((2 * nz, nx), np.uint8)
    for m in range(1, count + 1):
        status = c_int(0)
        volume = _single(index == m).ravel()
        library.set_phantom_info_vox(byref(status), volume, dims, *offset, dx, dy, mask, m, count)
        if status.value:
            raise XrayError(
                f"gecatsim has no memory for the phantom (status {status.value}); make it smaller"
            )
    _set_detector(library, d.shape, d.pixel_mm)
    depth = np.zeros((nu * nv, n_energy))
    for m in range(1, count + 1):
        depth += _projected(library, geometry, m, n_energy, last=m == count)
    image = depth.reshape(nu, nv, n_energy).swapaxes(0, 1)
    return image[:: 1 if d.v[1] > 0 else -1, :: 1 if d.u[0] > 0 else -1]


def _set_detector(library: ctypes.CDLL, shape: tuple[int, int], pixel_mm: float) -> None:
    """One module of all pixels, its columns along x, its rows along y, one sample in the middle of each."""
    nv, nu = shape
    u, v = (pixel_mm * (np.arange(n) - (n - 1) / 2) for n in (nu, nv))
    cells = _single(np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2))
    height, width = c_float((nv + 1) * pixel_mm), c_float((nu + 1) * pixel_mm)
    one = c_int(1)
    samples, weights = np.zeros((1, 2), np.float32), np.ones((1, 1), np.float32)
    library.set_module_info_vox(
        byref(height),
        byref(width),
        byref(c_int(nu * nv)),
        cells,
        byref(one),
        samples,
        weights,
        1,
        nu * nv,
        1,
        2,
    )
    library.set_src_info_vox(np.ones(1, np.float32), 1)


def _projected(library: ctypes.CDLL, geometry: Geometry, m: int, n_energy: int, *, last: bool) -> np.ndarray:
    """mu_m L_m (nu nv, n_energy) of one material; its memory is given back after the last one."""
    d = geometry.detector
    centre = d.corner + (d.size_mm[0] * d.u + d.size_mm[1] * d.v) / 2
    source, centre = (_single(np.asarray(p)[TO_CATSIM]) for p in (geometry.source, centre))
    along_x, along_y = (np.array([e], np.float32) for e in ((1, 0, 0), (0, 0, 1)))
    found = np.zeros((d.shape[0] * d.shape[1], n_energy), np.float32)
    kinds, unused = np.zeros((1, 1), np.int32), c_int(0)
    library.voxelized_projector(
        byref(c_int(0)), 1, found, source, 1, byref(c_float(0)), 0, byref(unused), 1, kinds, along_y, along_x,
        centre[None], 0, 0, m, m, 0, int(last),
    )  # fmt: skip
    return found


def _single(values: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(values, np.float32)


@lru_cache
def _library() -> ctypes.CDLL:
    """The compiled part of gecatsim, typed where it is called. Raises XrayError when there is none."""
    found = find_spec("gecatsim")
    path = Path(found.origin or "").parent / "lib" / "libcatsim.so" if found else Path()
    if not path.is_file():
        raise XrayError("gecatsim is not installed; install mammosim[catsim] on Linux")
    library = ctypes.CDLL(str(path))
    number, bytes_, whole = POINTER(c_float), ndpointer(np.uint8), POINTER(c_int)
    library.set_material_info_vox.argtypes = [c_int, c_int, ARRAY]
    library.set_phantom_info_vox.argtypes = [
        whole, ARRAY, ndpointer(c_int), *[c_float] * 5, bytes_, c_int, c_int
    ]  # fmt: skip
    library.set_module_info_vox.argtypes = [number, number, whole, ARRAY, whole, ARRAY, ARRAY, *[c_int] * 4]
    library.set_src_info_vox.argtypes = [ARRAY, c_int]
    library.voxelized_projector.argtypes = [
        whole, c_float, ARRAY, ARRAY, c_int, number, c_int, whole, c_int, ndpointer(c_int),
        ARRAY, ARRAY, ARRAY, *[c_int] * 4, c_float, c_int,
    ]  # fmt: skip
    return library
