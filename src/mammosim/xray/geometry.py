"""Where the source and the flat detector stand, in the patient frame, mm."""

from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import XrayError


@dataclass(frozen=True)
class Detector:
    """A flat detector of square pixels.

    origin: (3,) centre of pixel [0, 0]; u, v: (3,) unit vectors along columns and rows.
    shape: (nv, nu); the image is (nv, nu) with pixel [row, column] at origin + pixel_mm (column u + row v).

    Raises XrayError when u and v are not orthonormal, or shape or pixel are not positive.
    """

    origin: np.ndarray
    u: np.ndarray
    v: np.ndarray
    shape: tuple[int, int]
    pixel_mm: float

    def __post_init__(self) -> None:
        axes = np.array([self.u, self.v], float)
        if axes.shape != (2, 3) or not np.allclose(axes @ axes.T, np.eye(2), atol=1e-9):
            raise XrayError(f"detector axes u = {self.u} and v = {self.v} must be orthonormal (3,) vectors")
        if min(self.shape) < 1 or not 0 < self.pixel_mm < np.inf:
            raise XrayError(
                f"detector of {self.shape} pixels of {self.pixel_mm} mm must have a positive size"
            )
        if not np.all(np.isfinite(self.origin)):
            raise XrayError(f"detector origin {self.origin} must be finite")

    @property
    def normal(self) -> np.ndarray:
        """Unit normal (3,) n = u x v."""
        return np.cross(self.u, self.v)

    @property
    def corner(self) -> np.ndarray:
        """Outer corner (3,) of pixel [0, 0]."""
        corner: np.ndarray = self.origin - self.pixel_mm / 2 * (self.u + self.v)
        return corner

    @property
    def size_mm(self) -> tuple[float, float]:
        """Lengths along u and v."""
        return self.shape[1] * self.pixel_mm, self.shape[0] * self.pixel_mm

    @property
    def middle(self) -> np.ndarray:
        """Its middle (3,)."""
        along_u, along_v = self.size_mm
        return self.corner + along_u / 2 * self.u + along_v / 2 * self.v

    def along(self, point: np.ndarray) -> tuple[float, float]:
        """How far a point (3,) lies from the corner along u and v, mm."""
        from_corner = point - self.corner
        return float(from_corner @ self.u), float(from_corner @ self.v)

    def binned(self, cell_mm: float) -> "Detector":
        """A coarser detector on the same area, whose cells are about `cell_mm` and of whole pixels.

        Raises XrayError when no such cell divides the detector.
        """
        step = max(round(cell_mm / self.pixel_mm), 1)
        if self.shape[0] % step or self.shape[1] % step:
            raise XrayError(f"cells of {step} pixels do not divide a detector of {self.shape} pixels")
        shape = (self.shape[0] // step, self.shape[1] // step)
        origin = self.origin + (step - 1) / 2 * self.pixel_mm * (self.u + self.v)
        return Detector(origin, self.u, self.v, shape, step * self.pixel_mm)


@dataclass(frozen=True)
class Geometry:
    """A point source (3,) and a detector whose side with u x v pointing to the source is exposed.

    Raises XrayError when the source is in or behind the detector's plane.
    """

    source: np.ndarray
    detector: Detector

    def __post_init__(self) -> None:
        if not np.all(np.isfinite(self.source)):
            raise XrayError(f"source {self.source} must be finite")
        if not self.source_height_mm > 0:
            raise XrayError(
                f"the source is {-self.source_height_mm:g} mm behind the detector; "
                "swap its axes u and v, or move the source to where u x v points"
            )

    @property
    def source_height_mm(self) -> float:
        """Distance of the source from the detector's plane."""
        return float((self.source - self.detector.origin) @ self.detector.normal)

    def project(self, points: np.ndarray) -> np.ndarray:
        """Where rays through points (n, 3) meet the detector: (n, 2) mm along u and v from its corner.

        Points at or above the source project to NaN.
        """
        d, s = self.detector, self.source
        height = (s - points) @ d.normal
        t = np.where(height > 0, self.source_height_mm / np.where(height > 0, height, 1), np.nan)
        st: np.ndarray = (s + (points - s) * t[:, None] - d.corner) @ np.array([d.u, d.v]).T
        return st

    def solid_angle(self) -> float:
        """Solid angle in sr of the detector seen from the source (Van Oosterom & Strackee 1983)."""
        d = self.detector
        (a, b), c = d.size_mm, d.corner - self.source
        corners = (c, c + a * d.u, c + a * d.u + b * d.v, c + b * d.v)
        return _triangle(corners[0], corners[1], corners[2]) + _triangle(corners[0], corners[2], corners[3])


def _triangle(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> float:
    """tan(Omega/2) = |a . b x c| / (abc + (a.b) c + (a.c) b + (b.c) a)."""
    la, lb, lc = (float(np.linalg.norm(r)) for r in (a, b, c))
    return 2 * float(np.arctan2(abs(a @ np.cross(b, c)), la * lb * lc + a @ b * lc + a @ c * lb + b @ c * la))
