"""How slices parallel to a detector are seen by it: one linear operator per view, and its transpose.

The ray to pixel (r, c) crosses slice k at the voxel (y, x) = (y0 + y1 r, x0 + x1 c), and reads it linearly
between voxels, zero outside. Rows and columns separate: along x once per row of voxels, then along y.

    p[r, c] = sum_k sum_j Y_k[r, j] sum_i X_k[c, i] V[k, j, i]

The line integral at pixel (r, c) is A V = dz/cos(theta) p, theta from the normal of the slices.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import map_coordinates

from mammosim.core.errors import XrayError
from mammosim.core.volume import Grid
from mammosim.io.compiled import njit, prange
from mammosim.xray.geometry import Detector, Geometry

BLOCK = 32  # rows of pixels traced together, so that what they share stays in the cache
PARALLEL = 1e-9


@njit(cache=True)
def taps(start: float, step: float, size: int, place: np.ndarray, low: np.ndarray, high: np.ndarray) -> None:
    """Where start + step n falls in 0..size-1 with a zero at each end: place, weights of it and the next."""
    for n in range(len(place)):
        at = min(max(start + step * n + 1.0, 0.0), size + 1.0)
        i = min(int(at), size)
        place[n] = i
        low[n], high[n] = 1.0 - (at - i), at - i


@njit(cache=True, parallel=True)
def add_sums(volume: np.ndarray, across: np.ndarray, image: np.ndarray) -> None:
    """Adds to image (nv, nu) the sums p of volume (nz, ny, nx); across (nz, 4): x0, x1, y0, y1."""
    nz, ny, nx = volume.shape
    nv, nu = image.shape
    for block in prange((nv + BLOCK - 1) // BLOCK):
        first, last = block * BLOCK, min((block + 1) * BLOCK, nv)
        at_x, low_x, high_x = np.empty(nu, np.uint32), np.empty(nu, image.dtype), np.empty(nu, image.dtype)
        at_y, low_y, high_y = np.empty(nv, np.uint32), np.empty(nv, image.dtype), np.empty(nv, image.dtype)
        row = np.zeros(nx + 2, image.dtype)
        crossed = np.zeros((ny + 2, nu), image.dtype)
        for k in range(nz):
            taps(across[k, 0], across[k, 1], nx, at_x, low_x, high_x)
            taps(across[k, 2], across[k, 3], ny, at_y, low_y, high_y)
            j_first = max(min(at_y[first], at_y[last - 1]), 1)
            j_last = min(max(at_y[first], at_y[last - 1]) + 1, ny)
            for j in range(j_first, j_last + 1):
                row[1 : nx + 1] = volume[k, j - 1]
                for c in range(nu):
                    crossed[j, c] = low_x[c] * row[at_x[c]] + high_x[c] * row[at_x[c] + np.uint32(1)]
            for r in range(first, last):
                below, above = crossed[at_y[r]], crossed[at_y[r] + 1]
                w_low, w_high = low_y[r], high_y[r]
                for c in range(nu):
                    image[r, c] += w_low * below[c] + w_high * above[c]


@njit(cache=True, parallel=True)
def add_transposed(
    image: np.ndarray, across: np.ndarray, per_voxel: tuple[np.ndarray, np.ndarray], volume: np.ndarray
) -> None:
    """Adds to volume (nz, ny, nx) per_y[k, j] per_x[k, i] times the transposed sums of image (nv, nu).

    per_voxel: (per_y (nz, ny), per_x (nz, nx)).
    """
    nz, ny, nx = volume.shape
    nv, nu = image.shape
    per_y, per_x = per_voxel
    for k in prange(nz):
        at_x, low_x, high_x = np.empty(nu, np.uint32), np.empty(nu, image.dtype), np.empty(nu, image.dtype)
        at_y, low_y, high_y = np.empty(nv, np.uint32), np.empty(nv, image.dtype), np.empty(nv, image.dtype)
        taps(across[k, 0], across[k, 1], nx, at_x, low_x, high_x)
        taps(across[k, 2], across[k, 3], ny, at_y, low_y, high_y)
        crossed = np.zeros((ny + 2, nu), image.dtype)
        for r in range(nv):
            below, above = crossed[at_y[r]], crossed[at_y[r] + 1]
            w_low, w_high = low_y[r], high_y[r]
            for c in range(nu):
                below[c] += w_low * image[r, c]
                above[c] += w_high * image[r, c]
        row = np.zeros(nx + 2, image.dtype)
        for j in range(1, ny + 1):
            row[:] = 0
            for c in range(nu):
                row[at_x[c]] += low_x[c] * crossed[j, c]
                row[at_x[c] + np.uint32(1)] += high_x[c] * crossed[j, c]
            for i in range(nx):
                volume[k, j - 1, i] += per_y[k, j - 1] * per_x[k, i] * row[i + 1]


@dataclass(frozen=True)
class View:
    """Slices of a grid as one geometry sees them.

    across: (nz, 4) x0, x1, y0, y1: pixel (r, c) sees slice k at the voxel (y0 + y1 r, x0 + x1 c).
    way: (nv, nu) dz/cos(theta) mm: what a ray crosses of one slice.
    rows: (nv, nu) sum of the weights of each ray, in slices.
    of_y, of_x: (nz, ny), (nz, nx), whose product is the sum of the weights of voxel (k, j, i).
    """

    across: np.ndarray
    way: np.ndarray
    rows: np.ndarray
    of_y: np.ndarray
    of_x: np.ndarray

    def project(self, V: np.ndarray) -> np.ndarray:
        """A V: line integrals (nv, nu) through slices V (nz, ny, nx), in mm times its unit."""
        p = np.zeros(self.way.shape, V.dtype)
        add_sums(V, self.across, p)
        AV: np.ndarray = p * self.way.astype(V.dtype)
        return AV

    def transpose(self, p: np.ndarray) -> np.ndarray:
        """A^T p: (nz, ny, nx) from an image p (nv, nu)."""
        V = np.zeros((len(self.across), self.of_y.shape[1], self.of_x.shape[1]), p.dtype)
        ones = (np.ones(self.of_y.shape, p.dtype), np.ones(self.of_x.shape, p.dtype))
        add_transposed(p * self.way.astype(p.dtype), self.across, ones, V)
        return V


def view_of(grid: Grid, geometry: Geometry) -> View:
    """How a geometry sees the slices of a grid.

    Raises XrayError when its detector is not parallel to the slices, or does not lie below all of them.
    """
    d, (dx, dy, dz) = geometry.detector, grid.spacing
    if not np.allclose(grid.direction, np.eye(3), atol=1e-6):
        raise XrayError("slices must follow the axes x, y, z; resample their grid")
    if max(np.abs(d.u[1:]).max(), np.abs(d.v[[0, 2]]).max(), abs(d.normal[2] - 1)) > PARALLEL:
        raise XrayError("the detector is not parallel to the slices; see seen_flat for a turned detector")
    z = grid.origin[2] + dz * np.arange(grid.shape[0])
    if not d.origin[2] <= z[0] - dz / 2 < z[-1] + dz / 2 < geometry.source[2]:
        raise XrayError(
            f"slices from z = {z[0]:g} to {z[-1]:g} mm must lie between the detector at {d.origin[2]:g} "
            f"and the source at {geometry.source[2]:g} mm"
        )
    t = (geometry.source[2] - z) / geometry.source_height_mm
    columns = []
    for axis, step, e in ((0, dx, d.u[0]), (1, dy, d.v[1])):
        first = geometry.source[axis] + t * (d.origin[axis] - geometry.source[axis])
        columns += [(first - grid.origin[axis]) / step, t * d.pixel_mm * e / step]
    across = np.ascontiguousarray(np.stack(columns, axis=1))
    in_x, of_x = _sums(across[:, :2], d.shape[1], grid.shape[2])
    in_y, of_y = _sums(across[:, 2:], d.shape[0], grid.shape[1])
    return View(across, dz / _cosines(geometry), in_y.T @ in_x, of_y, of_x)


@njit(cache=True)
def _sums(across: np.ndarray, n_pixel: int, n_voxel: int) -> tuple[np.ndarray, np.ndarray]:
    """Along one axis: the weights of each pixel (nz, n_pixel) and of each voxel (nz, n_voxel), added."""
    nz = len(across)
    pixels, voxels = np.zeros((nz, n_pixel)), np.zeros((nz, n_voxel + 2))
    place, low, high = np.empty(n_pixel, np.uint32), np.empty(n_pixel), np.empty(n_pixel)
    for k in range(nz):
        taps(across[k, 0], across[k, 1], n_voxel, place, low, high)
        for n in range(n_pixel):
            voxels[k, place[n]] += low[n]
            voxels[k, place[n] + np.uint32(1)] += high[n]
            pixels[k, n] = (low[n] if place[n] > 0 else 0.0) + (high[n] if place[n] < n_voxel else 0.0)
    return pixels, voxels[:, 1:-1].copy()


def _cosines(geometry: Geometry) -> np.ndarray:
    """cos(theta) (nv, nu) of the rays to the pixels' centres."""
    d = geometry.detector
    c, h = d.origin - geometry.source, geometry.source_height_mm
    u, v = (c @ e + d.pixel_mm * np.arange(n) for e, n in ((d.u, d.shape[1]), (d.v, d.shape[0])))
    cosines: np.ndarray = h / np.sqrt(h**2 + u**2 + v[:, None] ** 2)
    return cosines


def seen_flat(integrals: np.ndarray, geometry: Geometry) -> tuple[np.ndarray, Geometry]:
    """What a detector parallel to the slices (normal z) would have seen in place of a turned one.

    integrals: (nv, nu) line integrals, which belong to a ray wherever it ends. Pixels stay as large, and the
    middle of the chest edge stays in place; what the turned detector did not see is that of its border.
    """
    # ASSUME: line integrals are linear between the pixels of a turned detector.
    d = geometry.detector
    middle = d.origin + (d.shape[1] - 1) / 2 * d.pixel_mm * d.u
    u = np.array([np.sign(d.u[0]), 0.0, 0.0])
    flat = Detector(middle - (d.shape[1] - 1) / 2 * d.pixel_mm * u, u, d.v, d.shape, d.pixel_mm)
    rows, columns = np.indices(d.shape)
    at = flat.origin + d.pixel_mm * (columns[..., None] * flat.u + rows[..., None] * flat.v)
    uv = geometry.project(at.reshape(-1, 3)).T.reshape(2, *d.shape) / d.pixel_mm - 0.5
    found = map_coordinates(integrals, uv[::-1], order=1, mode="nearest")
    return found, Geometry(geometry.source, flat)
