"""A compressed breast by tomosynthesis: its views with noise, and how a lesion shows in its own slice."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from mammosim.core.errors import XrayError
from mammosim.core.labels import Label
from mammosim.core.volume import Grid, LabelMap, grid_around
from mammosim.study.mammogram import RING_MM, xray_phantom
from mammosim.xray.detector import Scatter, expose
from mammosim.xray.effects import Effect, QuantumNoise
from mammosim.xray.geometry import Geometry
from mammosim.xray.observer import Contrast, cnr
from mammosim.xray.projector import primary
from mammosim.xray.reconstruction import Slices, line_integrals
from mammosim.xray.response import Response
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.systems import System, tomosynthesis_geometries

LEAST_SHARE = 1e-6  # of the unobstructed signal: what a pixel shows at least, for its logarithm


@dataclass(frozen=True)
class Scan:
    """How views are taken: system, beam, the detector's response and effects, mAs of all views together."""

    system: System
    spectrum: Spectrum
    response: Response | None
    mas: float
    pixel_mm: float
    effects: tuple[Effect, ...] = (QuantumNoise(),)


@dataclass(frozen=True)
class Views:
    """Line integrals (nv, nu) of each view, in its geometry."""

    integrals: tuple[np.ndarray, ...]
    geometries: tuple[Geometry, ...]


def views(
    labels: LabelMap,
    scan: Scan,
    *,
    chest_y_mm: float,
    rng: np.random.Generator,
    scatter: Sequence[Scatter] | None = None,
) -> Views:
    """The views of a breast between plates along z; scatter on the pixels of each view, or none.

    Raises XrayError when the breast leaves the field of a view, or scatter is not given for all of them.
    """
    # ASSUME: mAs are shared equally by the views.
    phantom, pixel = xray_phantom(labels), scan.pixel_mm
    geometries = tomosynthesis_geometries(phantom, scan.system, chest_wall_y_mm=chest_y_mm, pixel_mm=pixel)
    if scatter is not None and len(scatter) != len(geometries):
        raise XrayError(f"scatter of {len(scatter)} views for {len(geometries)}; give it for each, or none")
    mas = scan.mas / len(geometries)
    found = []
    for n, geometry in enumerate(geometries):
        image = primary(phantom, geometry, scan.spectrum, response=scan.response)
        scattered = None if scatter is None else scatter[n]
        shot = expose(image, scattered, mas=mas, pixel_mm=pixel, rng=rng, effects=scan.effects)
        unobstructed = image.unobstructed * pixel**2 * mas
        found.append(line_integrals(np.maximum(shot.image, LEAST_SHARE * unobstructed), unobstructed))
    return Views(tuple(found), geometries)


def slices_grid(labels: LabelMap, *, chest_y_mm: float, voxel_mm: float, slice_mm: float) -> Grid:
    """Where slices are wanted: around all that is not air before the chest wall, and RING_MM beside it."""
    tissue = labels.grid.points(np.argwhere(labels.values != Label.AIR).astype(float))
    tissue = tissue[tissue[:, 1] < chest_y_mm]
    half, beside = labels.grid.spacing / 2, np.array([RING_MM[1], RING_MM[1], 0.0])
    low, high = tissue.min(axis=0) - half - beside, tissue.max(axis=0) + half + beside
    high[1] = min(high[1], chest_y_mm)
    return grid_around(low, high, np.array([voxel_mm, voxel_mm, slice_mm]))


def lesion_contrast(slices: Slices, labels: LabelMap) -> Contrast:
    """How the lesion stands out of the tissue around it in the slice through its middle.

    Raises XrayError when there is no lesion, or the slices do not show it.
    """
    found = np.argwhere(labels.values == Label.LESION)
    if not found.size:
        raise XrayError("there is no lesion; insert one that lies in the X-ray field")
    grid = slices.image.grid
    k = round(float(grid.indices(labels.grid.points(found.mean(axis=0)[None]))[0, 0]))
    if not 0 <= k < grid.shape[0]:
        raise XrayError(
            f"the lesion's slice {k} is not among {grid.shape[0]}; make slices of the whole breast"
        )
    rows, columns = np.indices(grid.shape[1:]).reshape(2, -1)
    points = grid.points(np.stack([np.full(rows.size, k), rows, columns], axis=1).astype(float))
    at = labels.grid.indices(points).T
    here = ndimage.map_coordinates(labels.values, at, order=0, mode="constant").reshape(grid.shape[1:])
    lesion = here == Label.LESION
    distance = ndimage.distance_transform_edt(~lesion) * grid.spacing[0]
    ring = (distance >= RING_MM[0]) & (distance <= RING_MM[1]) & (here != Label.AIR)
    return cnr(slices.image.values[k], lesion, ring)
