"""Detectors with rows or columns along an axis of the phantom's grid, as rows of rays."""

from dataclasses import dataclass

import numpy as np

from mammosim.xray.geometry import Geometry
from mammosim.xray.rows import Rows

PARALLEL = 1e-12  # largest other component of a unit vector along an axis


@dataclass(frozen=True)
class Aligned:
    """Which pixels of a geometry's detector are a row: along `axis` of the grid (0, 1, 2 for x, y, z).

    transposed: the columns of the image are the rows of rays; flipped: they run to lower coordinates.
    """

    geometry: Geometry
    axis: int
    transposed: bool
    flipped: bool

    def rows(self, samples: int) -> Rows:
        """The rows of rays, `samples` rays per pixel, in the axes of xray.lines."""
        d = self.geometry.detector
        along, across = (d.v, d.u) if self.transposed else (d.u, d.v)
        n_row, n = d.shape[::-1] if self.transposed else d.shape
        corner = d.corner + (n * d.pixel_mm * along if self.flipped else 0.0)
        order = [self.axis, *(a for a in range(3) if a != self.axis)]
        source = np.asarray(self.geometry.source, float)
        return Rows(
            source[order],
            corner[order],
            d.pixel_mm * np.asarray(across, float)[order],
            d.pixel_mm / samples,
            self.geometry.source_height_mm,
            n_row,
            n * samples,
        )

    def as_image(self, found: np.ndarray) -> np.ndarray:
        """Values (n, n_row, n_ray) as images (n, nv, nu)."""
        found = found[..., ::-1] if self.flipped else found
        return np.ascontiguousarray(found.swapaxes(1, 2) if self.transposed else found)


def aligned_rows(geometry: Geometry) -> Aligned | None:
    """How the detector's pixels form rows along an axis of the grid; None when neither u nor v does."""
    for transposed, along in ((False, geometry.detector.u), (True, geometry.detector.v)):
        axis = int(np.argmax(np.abs(along)))
        if np.abs(np.delete(along, axis)).max() <= PARALLEL:
            return Aligned(geometry, axis, transposed, bool(along[axis] < 0))
    return None
