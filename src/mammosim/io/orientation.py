"""Voxel arrays turned so that their axes rise towards left, posterior and superior; nothing is resampled."""

import numpy as np
import SimpleITK as sitk

from mammosim.core.volume import Grid

# Of each letter of an orientation the axis of the patient, and whether it rises towards L, P or S.
# ITK names the side that an axis points to.
AXES = {"R": (0, False), "L": (0, True), "A": (1, False), "P": (1, True), "I": (2, False), "S": (2, True)}


def rising(grid: Grid, values: np.ndarray) -> tuple[Grid, np.ndarray]:
    """The same voxels with array axes (z, y, x) nearest to superior, posterior, left, as DICOMOrient of ITK.

    values (nk, nj, ni) on the grid, whose columns of `direction` are those of i, j and k; copied only where
    they must be. The direction is made orthonormal to machine precision.
    """
    code = sitk.DICOMOrientImageFilter.GetOrientationFromDirectionCosines(grid.direction.ravel().tolist())
    towards = [AXES[letter] for letter in code]  # of i, j, k
    order = np.argsort([axis for axis, _ in towards])  # i, j, k that become x, y, z
    rises = np.array([towards[k][1] for k in order])
    size = np.array(grid.shape[::-1])[order]
    direction = grid.direction[:, order] * np.where(rises, 1, -1)
    spacing = grid.spacing[order]
    back = np.where(rises, 0, (size - 1) * spacing)  # along the turned axes
    origin = grid.origin - direction @ back
    turned = values.transpose((2 - order)[::-1])
    turned = turned[tuple(slice(None, None, 1 if up else -1) for up in rises[::-1])]
    U, _, Vt = np.linalg.svd(direction)
    return Grid(turned.shape, spacing, origin, U @ Vt), np.ascontiguousarray(turned)
