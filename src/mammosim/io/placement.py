"""How far two placements of the same voxels are apart, and whether axes are at right angles."""

from collections.abc import Sequence
from itertools import product
from pathlib import Path

import numpy as np

from mammosim.core.errors import ImageError

# ASSUME: headers keep numbers of 32 bits or of six digits, by which corners move less than 1 mm.
LARGEST_DIFFERENCE_MM = 1.0


def corners(counts: Sequence[int]) -> np.ndarray:
    """Indices (8, 3) in order (i, j, k) of the outermost voxels of a volume of counts (nx, ny, nz)."""
    return np.array(list(product(*((0, n - 1) for n in counts))), float)


def apart_mm(A: np.ndarray, B: np.ndarray, counts: Sequence[int]) -> float:
    """Largest distance between the places that two affine maps (3, 4) of indices give to one voxel."""
    C = np.column_stack([corners(counts), np.ones(8)])
    return float(np.linalg.norm(C @ (A - B).T, axis=1).max())


def require_rigid(axes: np.ndarray, counts: Sequence[int], path: str | Path) -> np.ndarray:
    """Unit vectors (3, 3) of axes, whose columns are the steps (mm) from voxel to voxel along i, j, k.

    Raises ImageError where axes at right angles place a corner elsewhere: the volume is sheared.
    """
    spacing = np.linalg.norm(axes, axis=0)
    if not (np.isfinite(spacing).all() and spacing.min() > 0):
        raise ImageError(f"{path}: axes {axes.tolist()} are no directions; export the image again")
    U, _, Vt = np.linalg.svd(axes / spacing)
    C = corners(counts) - (np.array(counts) - 1) / 2
    off = float(np.linalg.norm(C @ (axes - U @ Vt * spacing).T, axis=1).max())
    if off > LARGEST_DIFFERENCE_MM:
        raise ImageError(
            f"{path}: its axes are sheared, not at right angles: a corner is {off:.1f} mm off, the limit is "
            f"{LARGEST_DIFFERENCE_MM:g} mm; resample it to a rectangular grid (3D Slicer: Resample Scalar "
            "Volume)"
        )
    unit: np.ndarray = axes / spacing
    return unit
