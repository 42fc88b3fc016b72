"""The compiled distance-driven projector of gecatsim, driven by ctypes; numpy is all that it needs.

Its axes are (x, z, y) of ours, and its first slice along z is the highest. It keeps materials, voxels and
detector between calls, one of each per process.
"""

import ctypes
from ctypes import POINTER, byref, c_float, c_int
from dataclasses import dataclass
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from numpy.ctypeslib import ndpointer

from mammosim.core.errors import XrayError

TO_CATSIM = [0, 2, 1]
ARRAY = ndpointer(c_float)


@dataclass(frozen=True)
class Voxels:
    """index (nz, ny, nx) of materials, 0 is none; middle (3,) of the grid, mm; spacing (3,) mm, dz = dx.

    mu: (n_material, n_energy) 1/mm of the materials 1, 2, ...

    Raises XrayError when voxels are not as long in z as in x.
    """

    index: np.ndarray
    middle: np.ndarray
    spacing: np.ndarray
    mu: np.ndarray

    def __post_init__(self) -> None:
        dx, _, dz = self.spacing
        if not np.isclose(dx, dz, rtol=1e-6):
            raise XrayError(
                f"gecatsim's voxels are as long in z as in x, not {dz:g} and {dx:g} mm; resample them"
            )


@dataclass(frozen=True)
class Flat:
    """A source (3,) over a detector (nv, nu) along x and y around its middle (3,), mm."""

    source: np.ndarray
    middle: np.ndarray
    shape: tuple[int, int]
    pixel_mm: float


def depths(voxels: Voxels, view: Flat) -> np.ndarray:
    """sum_m mu_m L_m (nv, nu, n_energy), rows and columns with y and x growing; memory is given back."""
    load(voxels)
    return project(voxels, view, last=True)


def load(voxels: Voxels) -> None:
    """Hands materials and voxels over. Raises XrayError when there is no memory for them."""
    count, n_energy = voxels.mu.shape
    nz, ny, nx = voxels.index.shape
    _library().set_material_info_vox(count, n_energy, _single(voxels.mu.T))
    # slices from above, then (x, y): the order of its volumes
    index = voxels.index[::-1].transpose(0, 2, 1)
    dims = np.array([nx, nz, ny, count], np.int32)
    offset = _single(voxels.middle)[TO_CATSIM]
    dx, dy, _ = voxels.spacing
    mask = np.ones((2 * nz, nx), np.uint8)
    for m in range(1, count + 1):
        status = c_int(0)
        volume = _single(index == m).ravel()
        _library().set_phantom_info_vox(byref(status), volume, dims, *offset, dx, dy, mask, m, count)
        if status.value:
            raise XrayError(
                f"gecatsim has no memory for the phantom (status {status.value}); make it smaller"
            )


def project(voxels: Voxels, view: Flat, *, last: bool) -> np.ndarray:
    """As `depths`, of voxels that were loaded; last: their memory is given back."""
    _set_detector(view.shape, view.pixel_mm)
    count, n_energy = voxels.mu.shape
    nv, nu = view.shape
    depth = np.zeros((nu * nv, n_energy), np.float32)
    for m in range(1, count + 1):
        depth += _projected(view, m, n_energy, last=last and m == count)
    return depth.reshape(nu, nv, n_energy).swapaxes(0, 1)


def _set_detector(shape: tuple[int, int], pixel_mm: float) -> None:
    """One module of all pixels, its columns along x, its rows along y, one sample in the middle of each."""
    nv, nu = shape
    u, v = (pixel_mm * (np.arange(n) - (n - 1) / 2) for n in (nu, nv))
    cells = _single(np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2))
    height, width = c_float((nv + 1) * pixel_mm), c_float((nu + 1) * pixel_mm)
    one = c_int(1)
    samples, weights = np.zeros((1, 2), np.float32), np.ones((1, 1), np.float32)
    _library().set_module_info_vox(
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
    _library().set_src_info_vox(np.ones(1, np.float32), 1)


def _projected(view: Flat, m: int, n_energy: int, *, last: bool) -> np.ndarray:
    """mu_m L_m (nu nv, n_energy) of one material; the memory of all is given back after the last one."""
    source, middle = (_single(np.asarray(p)[TO_CATSIM]) for p in (view.source, view.middle))
    along_x, along_y = (np.array([e], np.float32) for e in ((1, 0, 0), (0, 0, 1)))
    found = np.zeros((view.shape[0] * view.shape[1], n_energy), np.float32)
    kinds, unused = np.zeros((1, 1), np.int32), c_int(0)
    _library().voxelized_projector(
        byref(c_int(0)), 1, found, source, 1, byref(c_float(0)), 0, byref(unused), 1, kinds, along_y, along_x,
        middle[None], 0, 0, m, m, 0, int(last),
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
        raise XrayError("gecatsim is not installed; install mammosim[peers] on Linux")
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
