"""How far slices smear a small bright ball: full widths at half maximum across, and in depth.

The depth profile (S(z) - B(z)) / (S(z0) - B(z0)) is the artefact spread function (Wu et al. 2004, Med Phys
31:2636): S at the ball's place in each slice, B in the background of the same slice.
"""

from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.core.volume import Image


@dataclass(frozen=True)
class PointSpreadWidths:
    """Widths in mm along x, the motion of the source, along y, and in depth z; where it is seen (3,) mm."""

    x_mm: float
    y_mm: float
    z_mm: float
    place: np.ndarray


def point_spread_widths(image: Image, place: np.ndarray, *, radius_mm: float) -> PointSpreadWidths:
    """Widths of a ball near place (3,) mm.

    Profiles run through the brightest voxel within radius_mm of it in x and y. Their background is the median
    of the slice within 4 radii.
    Raises XrayError when place is not inside, or a profile does not fall to its half on both sides.
    """
    grid, V = image.grid, image.values
    k, j, i = np.round(grid.indices(np.asarray(place, float)[None])[0]).astype(int)
    if not all(0 <= n < size for n, size in zip((k, j, i), V.shape)):
        raise XrayError(f"place {place} mm is outside the slices")
    near = max(int(np.ceil(radius_mm / grid.spacing[:2].min())), 1)
    low_j, low_i = max(j - near, 0), max(i - near, 0)
    window = V[:, low_j : j + near + 1, low_i : i + near + 1]
    k, dj, di = np.unravel_index(int(np.argmax(window)), window.shape)
    j, i = low_j + int(dj), low_i + int(di)
    far = 4 * near
    around = V[:, max(j - far, 0) : j + far + 1, max(i - far, 0) : i + far + 1].astype(float)
    background = np.median(around, axis=(1, 2))
    profiles = (V[k, j] - background[k], V[k, :, i] - background[k], V[:, j, i] - background)
    x, y, z = (_width(p, n) * h for p, n, h in zip(profiles, (i, j, k), grid.spacing))
    return PointSpreadWidths(x, y, z, grid.points(np.array([[k, j, i]], float))[0])


def _width(profile: np.ndarray, peak: int) -> float:
    """Full width at half of the value at the peak, in samples, linear between them."""
    half, sides = profile[peak] / 2, []
    for side in (profile[peak::-1], profile[peak:]):
        below = np.nonzero(side < half)[0]
        if not below.size:
            raise XrayError("a profile does not fall to its half inside the slices; make them larger")
        n = int(below[0])
        sides.append(n - 1 + (side[n - 1] - half) / (side[n - 1] - side[n]))
    return float(sum(sides))
