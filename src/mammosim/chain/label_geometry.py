"""Where pieces of a label map lie, and what is next to them; arrays are (nz, ny, nx)."""

from dataclasses import replace

import numpy as np
from scipy import ndimage

from mammosim.core.volume import LabelMap

# ASSUME: where a hanging breast is wider than its base, its back lies 10 mm in front of what is 15 mm beside.
OVERHANG_MM, WITHIN_MM = 10.0, 15.0
# ASSUME: skin within 10 mm of the midline is that of the breastbone.
MIDLINE_MM = 10.0


def middle_of(x: np.ndarray) -> float:
    """In the middle between the two sides of a body whose voxels lie at x (n,), in its unit."""
    return float(x.min() + x.max()) / 2


def is_outside(mask: np.ndarray, air: np.ndarray) -> bool:
    """Whether half of a mask, or more, is in pieces that touch the air around the body, or the border."""
    volumes, _ = ndimage.label(air)
    size = np.bincount(volumes.ravel())
    around = volumes == 1 + np.argmax(size[1:]) if len(size) > 1 else air.copy()
    for axis in range(3):
        np.moveaxis(around, axis, 0)[[0, -1]] = True
    pieces, _ = ndimage.label(mask)
    return bool(2 * np.count_nonzero(touching(pieces, around)) >= np.count_nonzero(mask))


def among(values: np.ndarray, labels: tuple[int, ...]) -> np.ndarray:
    """Where values (nz, ny, nx) uint8 are among these labels."""
    chosen = np.zeros(256, bool)
    chosen[list(labels)] = True
    found: np.ndarray = chosen[values]
    return found


def touching(pieces: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Which voxels (nz, ny, nx) are of a numbered piece that touches the mask."""
    touched = np.zeros(pieces.max() + 1, bool)
    touched[pieces[ndimage.binary_dilation(mask)]] = True
    touched[0] = False
    found: np.ndarray = touched[pieces]
    return found


def overhanging(last: np.ndarray, labels: LabelMap) -> np.ndarray:
    """Columns (nz, nx) at the rim of the tissue that end in front of those near them; last: row, or -1."""
    dx, dy, dz = labels.grid.spacing
    size = tuple(2 * int(np.ceil(WITHIN_MM / step)) + 1 for step in (dz, dx))
    y = last * dy
    deepest = ndimage.maximum_filter(np.where(last < 0, -np.inf, y), size)
    base = ndimage.minimum_filter(np.where(last < 0, np.inf, deepest), size)
    pieces, _ = ndimage.label((last >= 0) & (base - y > OVERHANG_MM))
    return touching(pieces, last < 0)


def filled_in(labels: LabelMap, unknown: np.ndarray) -> LabelMap:
    """With these voxels (nz, ny, nx) as the nearest other one is, which touches their piece."""
    pieces, _ = ndimage.label(unknown)
    values, step = labels.values.copy(), labels.grid.spacing[::-1]
    for n, box in enumerate(ndimage.find_objects(pieces), 1):
        around = tuple(slice(max(0, s.start - 1), s.stop + 1) for s in box)
        mask, own = unknown[around], pieces[around] == n
        if mask.all():
            continue
        near = ndimage.distance_transform_edt(
            mask, sampling=step, return_distances=False, return_indices=True
        )
        values[around][own] = labels.values[around][tuple(axis[own] for axis in near)]
    return replace(labels, values=values)
