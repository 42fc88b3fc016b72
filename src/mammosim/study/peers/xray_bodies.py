"""What is X-rayed by several programs: a breast of blobs, slabs, and the case of AAPM report 195."""

from typing import Any

import numpy as np
from scipy.ndimage import binary_erosion, gaussian_filter

from mammosim.core.errors import ConfigurationError
from mammosim.core.rng import generator
from mammosim.core.volume import Grid
from mammosim.xray.attenuation import material
from mammosim.xray.exposure_setup import ExposureSetup
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.phantom import AIR, Phantom
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.tube import tube_spectrum

SEED = 6
ADIPOSE, GLANDULAR = 1, 2
BLOB_MM = 2.0
SUPPORT_MM, SOURCE_MM = 15.0, 650.0  # above the detector
COARSER = 8  # times, of what warms a program up
THROUGH = 0.999  # share of the straight way through all slices, of rays that cross their top and bottom
MATERIALS = ("air", "adipose", "glandular")


def grid_of(shape: tuple[int, int, int], voxel_mm: float) -> Grid:
    """Voxels (nz, ny, nx) on the support: x centred, y up to the chest edge at 0, the detector at z = 0."""
    low = np.array([-shape[2] / 2 * voxel_mm, -shape[1] * voxel_mm, SUPPORT_MM])
    return Grid(shape, np.full(3, voxel_mm), low + voxel_mm / 2)


def body(name: str, grid: Grid) -> Phantom:
    """A body by its name in BODIES. Raises ConfigurationError for another."""
    if name not in BODIES:
        raise ConfigurationError(f"unknown body {name!r}; choose one of: {', '.join(BODIES)}")
    return Phantom(grid, BODIES[name](grid), tuple(material(m) for m in MATERIALS))


def _breast(grid: Grid) -> np.ndarray:
    """Half an ellipse, of fat with blobs of gland."""
    noise = generator(SEED, "blobs").standard_normal(grid.shape, dtype=np.float32)
    blobs = gaussian_filter(noise, BLOB_MM / grid.spacing[2]) > 0
    _, ny, nx = grid.shape
    x = (np.arange(nx) + 0.5 - nx / 2) / (nx / 2)
    y = (ny - np.arange(ny) - 0.5)[:, None] / ny
    inside = x**2 + y**2 < 1
    return np.where(inside, np.where(blobs, GLANDULAR, ADIPOSE), AIR).astype(np.uint8)


def _slabs(grid: Grid) -> np.ndarray:
    """Fat below, gland above."""
    index = np.full(grid.shape, ADIPOSE, np.uint8)
    index[grid.shape[0] // 2 :] = GLANDULAR
    return index


BODIES = {"breast": _breast, "slabs": _slabs}


def geometry_at(angle_deg: float, pixels: tuple[int, int], pixel_mm: float) -> Geometry:
    """A still detector (nv, nu) along x and y; the source on an arc about the middle of its chest edge."""
    a, (nv, nu) = np.radians(angle_deg), pixels
    origin = np.array([-(nu - 1) / 2 * pixel_mm, -(nv - 0.5) * pixel_mm, 0.0])
    x, y, _ = np.eye(3)
    source = SOURCE_MM * np.array([np.sin(a), 0.0, np.cos(a)])
    return Geometry(source, Detector(origin, x, y, pixels, pixel_mm))


def beam(energies: int) -> Spectrum:
    """Tungsten and rhodium, 28 kVp, in so many energies."""
    return tube_spectrum("W", "Rh", 0.05, 28.0).rebinned(energies)


def setup_facts(setup: ExposureSetup) -> dict[str, Any]:
    """A setup but for its voxels, in plain values: mm, keV, photons per mm2 and mAs at a distance."""
    grid, d, spectrum = setup.phantom.grid, setup.geometry.detector, setup.spectrum
    return {
        "spacing_mm": grid.spacing.tolist(),
        "origin_mm": grid.origin.tolist(),
        "materials": [vars(m) for m in setup.phantom.materials],
        "source_mm": np.asarray(setup.geometry.source, float).tolist(),
        "detector": {name: np.asarray(value).tolist() for name, value in vars(d).items()},
        "energies_kev": spectrum.energies_kev.tolist(),
        "fluence": spectrum.fluence.tolist(),
        "distance_mm": spectrum.distance_mm,
    }


def ways(geometry: Geometry) -> np.ndarray:
    """Distance (nv, nu) of the pixels' centres from the source, mm."""
    d = geometry.detector
    rows, columns = np.indices(d.shape)
    ends = d.origin + d.pixel_mm * (columns[..., None] * d.u + rows[..., None] * d.v)
    return np.linalg.norm(ends - geometry.source, axis=-1)


def through(phantom: Phantom, geometry: Geometry, lengths: np.ndarray) -> np.ndarray:
    """(nv, nu) bool: pixels all of whose rays cross all slices inside the body, as their lengths
    (nv, nu, n_material) and those of the pixels around them say."""
    thickness = phantom.grid.spacing[2] * phantom.grid.shape[0]
    whole = thickness * ways(geometry) / geometry.source_height_mm
    return binary_erosion(lengths[..., 1:].sum(axis=-1) > THROUGH * whole)


def coarsened(
    voxels: tuple[int, int, int], voxel_mm: float, pixels: tuple[int, int], pixel_mm: float
) -> dict[str, Any]:
    """The same lengths in COARSER times fewer voxels and pixels."""
    return {
        "voxels": tuple(max(n // COARSER, 2) for n in voxels),
        "voxel_mm": voxel_mm * COARSER,
        "pixels": tuple(max(n // COARSER, 2) for n in pixels),
        "pixel_mm": pixel_mm * COARSER,
    }
