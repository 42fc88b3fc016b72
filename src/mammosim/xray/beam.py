"""Body, source and detector as the compiled tracking reads them."""

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.xray.cover import cover
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.interactions import Matter
from mammosim.xray.phantom import AIR, Phantom
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.tracking import Body, Field


def body_of(phantom: Phantom, tables: Matter, regions: np.ndarray) -> Body:
    """The phantom as the kernel reads it: a few boxes around its tissue, each with its largest mu."""
    voxels = cover(phantom.index != AIR)  # (n_box, 3, 2) along (z, y, x)
    corners = phantom.low + voxels.transpose(0, 2, 1)[:, :, ::-1] * phantom.grid.spacing
    majorants = []
    for box in voxels:
        here = np.unique(phantom.index[tuple(slice(*span) for span in box)])
        majorants.append(tables.total[:, here].max(axis=1))
    return Body(
        np.ascontiguousarray(phantom.index),
        phantom.low,
        1 / phantom.grid.spacing,
        np.ascontiguousarray(corners.reshape(-1, 6)),
        np.stack(majorants, axis=1),
        np.ascontiguousarray(regions.reshape(-1, 6)),
    )


def field_of(source: np.ndarray, detector: Detector, spectrum: Spectrum) -> Field:
    """Source, detector and spectrum as the kernel reads them."""
    kept, alias = _alias_table(spectrum.fluence / spectrum.fluence.sum())
    (a, b), c = detector.size_mm, np.asarray(source, float) - detector.corner
    foot = np.array([np.clip(c @ detector.u, 0, a), np.clip(c @ detector.v, 0, b)])
    nearest = float(np.linalg.norm(c - foot[0] * detector.u - foot[1] * detector.v))
    return Field(
        np.asarray(source, float),
        detector.corner,
        np.asarray(detector.u, float),
        np.asarray(detector.v, float),
        detector.normal,
        np.array([a, b]),
        1 / detector.pixel_mm,
        spectrum.energies_kev,
        kept,
        alias,
        nearest,
    )


def _alias_table(p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Walker's alias table of probabilities (n,): the share that each column keeps, and who gets the rest."""
    n = len(p)
    kept, alias = p * n, np.arange(n)
    small, large = [i for i in range(n) if kept[i] < 1], [i for i in range(n) if kept[i] >= 1]
    scaled = kept.copy()
    while small and large:
        i, j = small.pop(), large[-1]
        alias[i] = j
        scaled[j] -= 1 - scaled[i]
        if scaled[j] < 1:
            small.append(large.pop())
    for i in small + large:  # full columns, but for rounding
        scaled[i] = 1.0
    return scaled, alias


def require_outside(phantom: Phantom, geometry: Geometry, detector: Detector) -> None:
    """Raises XrayError when the source, or the centre of a detector cell, is in a voxel that is not air."""
    rows, columns = np.indices(detector.shape).reshape(2, -1, 1)
    centres = detector.origin + detector.pixel_mm * (columns * detector.u + rows * detector.v)
    for name, points in (("source", geometry.source[None]), ("detector", centres)):
        at = np.round(phantom.grid.indices(points)).astype(int)
        held = np.all((at >= 0) & (at < phantom.grid.shape), axis=1)
        if np.any(phantom.index[tuple(at[held].T)] != AIR):
            raise XrayError(f"the {name} is inside the body; move it out, or cut the phantom smaller")
