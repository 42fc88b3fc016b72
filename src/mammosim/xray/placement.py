"""Where a breast is placed on a detector: centred for all views, and how much room its shadow leaves."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.core.volume import Grid
from mammosim.xray.geometry import Geometry
from mammosim.xray.phantom import AIR, Phantom

# A technologist moves the breast until both sides have the same room; each step leaves a fifth at most.
CENTRING_STEPS = 6
# ASSUME: the breast is placed to a tenth of a millimetre.
PLACED_MM = 0.1


@dataclass(frozen=True)
class Outline:
    """A pressed breast before the chest wall: corners (n, 3) mm of the tops and bottoms of its columns."""

    tops: np.ndarray
    bottoms: np.ndarray

    @classmethod
    def of(cls, phantom: Phantom, chest_wall_y_mm: float) -> "Outline":
        """Of the voxels with y < chest_wall_y_mm. Raises XrayError where none holds tissue."""
        grid, tissue = phantom.grid, phantom.index != AIR
        y = grid.origin[1] + grid.spacing[1] * np.arange(grid.shape[1])
        tissue = tissue & (y < chest_wall_y_mm)[None, :, None]
        if not tissue.any():
            raise XrayError(
                f"no tissue at y < chest_wall_y_mm = {chest_wall_y_mm:g} mm; the breast points to -y"
            )
        j, i = np.nonzero(tissue.any(axis=0))
        lowest = np.argmax(tissue[:, j, i], axis=0)
        highest = grid.shape[0] - 1 - np.argmax(tissue[::-1, j, i], axis=0)
        return cls(*(_corners(grid, k, j, i) for k in (highest + 0.5, lowest - 0.5)))

    @property
    def points(self) -> np.ndarray:
        """All of them."""
        return np.vstack([self.tops, self.bottoms])

    @property
    def bottom_mm(self) -> float:
        """z of the lowest point, which lies on the support."""
        return float(self.bottoms[:, 2].min())

    @property
    def middle_mm(self) -> float:
        """x half way between the sides."""
        return float(self.tops[:, 0].min() + self.tops[:, 0].max()) / 2


def _corners(grid: Grid, k: np.ndarray, j: np.ndarray, i: np.ndarray) -> np.ndarray:
    """Corners (4 n, 3) of the horizontal faces at array indices k, j, i (n,) of a grid."""
    quarters = [np.stack([k, j + dj, i + di], axis=1) for dj in (-0.5, 0.5) for di in (-0.5, 0.5)]
    return grid.points(np.concatenate(quarters))


@dataclass(frozen=True)
class Room:
    """How far the shadow stays inside the detector, mm, over all views; negative where it leaves it.

    low_mm, high_mm: at the beginning and the end of u; front_mm: at the end of v, before the nipple.
    view: number of the view with the least room, from 0; needs_mm: width and depth that all views cover.
    """

    low_mm: float
    high_mm: float
    front_mm: float
    view: int
    needs_mm: tuple[float, float]

    @classmethod
    def around(cls, points: np.ndarray, geometries: Sequence[Geometry]) -> "Room":
        """Around the shadow of points (n, 3); one at or above the source has no shadow, and no room."""
        size = np.array(geometries[0].detector.size_mm)
        shadows = [view.project(points) for view in geometries]
        low = np.array([uv.min(axis=0) for uv in shadows])
        high = np.array([uv.max(axis=0) for uv in shadows])
        left = np.stack([low[:, 0], size[0] - high[:, 0], size[1] - high[:, 1]], axis=1)
        left = np.where(np.isnan(left), -np.inf, left)
        most = (high[:, 0].max() - low[:, 0].min(), high[:, 1].max())
        begins, ends, front = left.min(axis=0).tolist()
        needs = (float(most[0]), float(most[1]))
        return cls(begins, ends, front, int(left.min(axis=1).argmin()), needs)

    @property
    def least_mm(self) -> float:
        """On the side where it is least."""
        return min(self.low_mm, self.high_mm, self.front_mm)


def centred(
    views: Callable[[float], tuple[Geometry, ...]], points: np.ndarray, *, start_mm: float
) -> tuple[Geometry, ...]:
    """The views, their detector and arc moved along x until the shadow of points (n, 3) has equal room.

    views: of the x in mm of the middle of the detector's chest edge; u points to -x.
    """
    x = start_mm
    for _ in range(CENTRING_STEPS):
        room = Room.around(points, views(x))
        if not np.isfinite(room.least_mm):
            break
        x += (room.high_mm - room.low_mm) / 2
    return views(round(x / PLACED_MM) * PLACED_MM)
