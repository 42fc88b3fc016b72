"""Closed surfaces of triangles from STL files, in mm."""

import hashlib
from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np

from mammosim.core.errors import MeshError

# Widths of what is pressed on a breast, mm; a file in metres, centimetres or micrometres is outside.
SMALLEST_MM, LARGEST_MM = 30.0, 600.0
# Larger files would take longer to check than a person waits; 20 MB are 400,000 triangles.
LARGEST_BYTES = 20_000_000
# Corners nearer than this are one: programs round them to the digits that they write.
_ONE_CORNER_MM = 1e-3
DIGITS = 16


@dataclass(frozen=True)
class ClosedSurface:
    """Corners (n, 3, 3) mm of triangles that are seen counter-clockwise from outside."""

    corners: np.ndarray

    @property
    def low(self) -> np.ndarray:
        """The least coordinates (3,), mm."""
        low: np.ndarray = self.corners.min(axis=(0, 1))
        return low

    @property
    def high(self) -> np.ndarray:
        """The greatest coordinates (3,), mm."""
        high: np.ndarray = self.corners.max(axis=(0, 1))
        return high


def digest_of(path: str | Path) -> str:
    """The first DIGITS of the SHA-256 of a file. Raises MeshError where it cannot be read."""
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()[:DIGITS]
    except OSError as error:
        raise MeshError(f"no surface {path} ({error.strerror}); correct the path") from None


def read_closed_surface(path: str | Path) -> ClosedSurface:
    """The surface of a binary or an ASCII `.stl` file.

    Raises MeshError for a file that is no STL, is not in mm, or whose surface is open: each edge must be of
    two triangles, which pass it in opposite directions.
    """
    points, triangles = _read(path)
    _require_mm(points, path)
    points, triangles = _merged(points, triangles)
    _require_closed(points, triangles, path)
    corners = points[triangles]
    outside = np.einsum("ni,ni->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) > 0
    return ClosedSurface(corners if outside else corners[:, ::-1])


def _read(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) and triangles (m, 3) as the file has them."""
    if not Path(path).is_file():
        raise MeshError(f"no surface {path}; correct the path, which begins where the study is run")
    if (size := Path(path).stat().st_size) > LARGEST_BYTES:
        raise MeshError(
            f"{path} has {size / 1e6:.0f} MB, more than {LARGEST_BYTES / 1e6:.0f}; reduce its triangles"
        )
    try:
        with np.errstate(over="ignore"):  # meshio takes any four bytes for the number of triangles
            stored = meshio.stl.read(path)
        points, triangles = np.asarray(stored.points, dtype=float), stored.cells_dict["triangle"]
    except Exception as error:  # meshio's own, and of numpy for numbers that do not fit
        raise MeshError(f"{path} is no STL file, or is cut short ({type(error).__name__} {error})") from None
    if len(triangles) == 0 or not np.all(np.isfinite(points)):
        raise MeshError(f"{path} has {len(triangles)} triangles, all of which must have finite corners")
    return points, triangles


def _merged(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles with near corners made one, and without triangles that are then flat."""
    steps = np.round((points - points.min(axis=0)) / _ONE_CORNER_MM).astype(np.int64)
    size = int(steps.max()) + 1
    _, first, number = np.unique(
        (steps[:, 0] * size + steps[:, 1]) * size + steps[:, 2], return_index=True, return_inverse=True
    )
    triangles = number[triangles]
    flat = np.any(triangles == np.roll(triangles, 1, axis=1), axis=1)
    return points[first], triangles[~flat]


def _require_mm(points: np.ndarray, path: str | Path) -> None:
    width = np.ptp(points, axis=0)[:2].max()
    if not SMALLEST_MM <= width <= LARGEST_MM or not np.ptp(points[:, 2]) <= LARGEST_MM:
        units = {1e3: "metres", 10.0: "centimetres", 25.4: "inches", 1e-3: "micrometres"}
        likely = [name for factor, name in units.items() if 50 <= width * factor <= 400]
        advice = f"in {likely[0]}? Write it in mm" if likely else "write it in mm"
        raise MeshError(
            f"{path} is {width:.3g} mm wide, outside {SMALLEST_MM:g} to {LARGEST_MM:g} mm; {advice}"
        )


def _require_closed(points: np.ndarray, triangles: np.ndarray, path: str | Path) -> None:
    """Raise MeshError unless each edge is passed once in each direction."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    n = len(points)
    there, back = np.sort(edges[:, 0] * n + edges[:, 1]), np.sort(edges[:, 1] * n + edges[:, 0])
    if np.array_equal(there, back) and np.all(there[1:] > there[:-1]):
        return
    known, counts = np.unique(there, return_counts=True)
    alone = known[(counts > 1) | ~np.isin(known, back)]
    x, y, z = points[alone[0] // n]
    raise MeshError(
        f"the surface of {path} is open: {len(alone)} edges are not between two triangles, as at "
        f"({x:.1f}, {y:.1f}, {z:.1f}) mm; close its holes where it was drawn"
    )
