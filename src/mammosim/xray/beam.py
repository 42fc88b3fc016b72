"""Body, source and detector as the compiled tracking reads them."""

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.xray.bounding_boxes import bounding_boxes
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.interactions import Matter
from mammosim.xray.phantom import AIR, Phantom
from mammosim.xray.source_sampling import Field, Triple
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.transport_step import MIXED, Body

BLOCK_MM = 10.0
PLACES = 100  # along each axis of the detector


def body_of(phantom: Phantom, tables: Matter) -> Body:
    """The phantom as the kernel reads it: blocks of voxels by kind, and a few boxes around its tissue."""
    size = np.maximum(np.round(BLOCK_MM / phantom.grid.spacing[::-1]), 1).astype(int)  # voxels along z, y, x
    voxels = _gathered(phantom.index, size)
    held = np.stack([np.any(voxels == m, axis=(3, 4, 5)) for m in range(len(phantom.materials))], axis=-1)
    kinds, kind = np.unique(held.reshape(-1, held.shape[-1]), axis=0, return_inverse=True)
    blocks = kind.reshape(held.shape[:3])
    single = np.where(kinds.sum(axis=1) == 1, kinds.argmax(axis=1), MIXED)
    mixed = (single == MIXED)[blocks]
    different, which = np.unique(voxels[mixed].reshape(-1, size.prod()), axis=0, return_inverse=True)
    tiles = np.zeros(mixed.shape, np.int32)
    tiles[mixed] = which.ravel()
    boxes = bounding_boxes((single != AIR)[blocks])  # (n_box, 3, 2) blocks along (z, y, x)
    block_mm = (size * phantom.grid.spacing[::-1])[::-1]
    corners = phantom.low + boxes.transpose(0, 2, 1)[:, :, ::-1] * block_mm
    return Body(
        _triple(phantom.low),
        _triple(block_mm),
        _triple(1 / phantom.grid.spacing),
        blocks.astype(np.uint16),
        np.stack([tables.mu[:, kind, 0].max(axis=1) for kind in kinds], axis=1),
        single,
        tiles,
        different.reshape(-1, *size),
        np.ascontiguousarray(corners.reshape(-1, 6)),
    )


def _gathered(index: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Voxels in blocks of `size`: (bz, by, bx, sz, sy, sx), with air beyond the grid."""
    padded = np.pad(index, [(0, -n % k) for n, k in zip(index.shape, size)], constant_values=AIR)
    n = np.array(padded.shape) // size
    return padded.reshape(n[0], size[0], n[1], size[1], n[2], size[2]).transpose(0, 2, 4, 1, 3, 5)


def field_of(source: np.ndarray, detector: Detector, spectrum: Spectrum) -> Field:
    """Source, detector and spectrum as the kernel reads them."""
    kept, alias = _alias_table(spectrum.fluence / spectrum.fluence.sum())
    (a, b), c = detector.size_mm, np.asarray(source, float) - detector.corner
    foot = np.array([np.clip(c @ detector.u, 0, a), np.clip(c @ detector.v, 0, b)])
    nearest = float(np.linalg.norm(c - foot[0] * detector.u - foot[1] * detector.v))
    return Field(
        _triple(source),
        _triple(detector.corner),
        _triple(detector.u),
        _triple(detector.v),
        _triple(detector.normal),
        (a, b),
        1 / detector.pixel_mm,
        spectrum.energies_kev,
        kept,
        alias,
        nearest,
    )


def _triple(vector: np.ndarray) -> Triple:
    x, y, z = map(float, vector)
    return x, y, z


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


def require_outside(phantom: Phantom, geometry: Geometry) -> None:
    """Raises XrayError when the source, or one of a grid of places on the detector, is not in air."""
    detector = geometry.detector
    rows, columns = (np.linspace(0, n - 1, min(n, PLACES)).round() for n in detector.shape)
    centres = detector.origin + detector.pixel_mm * (
        columns[None, :, None] * detector.u + rows[:, None, None] * detector.v
    )
    for name, points in (("source", geometry.source[None]), ("detector", centres.reshape(-1, 3))):
        at = np.round(phantom.grid.indices(points)).astype(int)
        held = np.all((at >= 0) & (at < phantom.grid.shape), axis=1)
        if np.any(phantom.index[tuple(at[held].T)] != AIR):
            raise XrayError(f"the {name} is inside the body; move it out, or cut the phantom smaller")
