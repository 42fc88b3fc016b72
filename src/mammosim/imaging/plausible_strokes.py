"""Whether strokes can be meant: tissue is painted in the body of the image that they go with."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from mammosim.core.errors import SegmentationError
from mammosim.core.labels import Label
from mammosim.core.volume import Image
from mammosim.imaging.outline import bright_level, coarsened
from mammosim.imaging.plausible_points import VOXEL_MM, Skin, mistake
from mammosim.imaging.segmentation import LEAST_POINTS, NEEDED

AXES = ["x_mm", "y_mm", "z_mm"]
# ASSUME: whoever paints crosses the skin by less than 3 mm, beside half a voxel.
BEYOND_MM = 3.0
MOST_IN_AIR = 0.25
# ASSUME: a mistake in the frame or unit of all strokes puts at least a tenth of them into the air.
WELL_PLACED = 0.9
# ASSUME: strokes of all tissues, from the breast to the thorax, span at least 50 mm.
LEAST_SPAN_MM = 50.0
# ASSUME: tissue is brighter than 3.5 times the median of the air, which noise exceeds in 1 voxel of 5000
# (Rayleigh), and than 2 % of fat. What is dark in the body, as lungs, may look like air: the outline tells.
DARK, DARK_SHARE = 3.5, 0.02
OUTSIDE = (Label.AIR.tissue, Label.MARKER.tissue)  # of these nothing is asked: air is in lungs, too


def require_painted(strokes: pd.DataFrame, image: Image) -> None:
    """Raise SegmentationError, a line without the file, where strokes cannot be meant in their image.

    strokes: x_mm, y_mm, z_mm, tissue; rows are counted from 1. That is: too few points of a tissue that must
    be painted; one outside the image; all at one place, or in the body only in another frame or unit; those
    of a tissue in the air round the body.
    """
    counts = strokes["tissue"].value_counts()
    if few := [tissue for tissue in NEEDED if counts.get(tissue, 0) < LEAST_POINTS]:
        raise SegmentationError(f"fewer than {LEAST_POINTS} points of {', '.join(few)}; paint some")
    air, points = Air.of(image), strokes[AXES].to_numpy(float)
    tissue = ~strokes["tissue"].isin(OUTSIDE).to_numpy()
    outside, in_air = ~air.skin.holds(points), tissue & air.holds(points)
    span = float(np.ptp(points, axis=0).max())
    if np.count_nonzero(outside | in_air) > 1 or span < LEAST_SPAN_MM:
        _require_no_mistake(points, tissue, air)
    if span < LEAST_SPAN_MM:
        raise SegmentationError(
            f"all {len(points)} points lie within {span:.2g} mm: were they given in metres? give mm"
        )
    if outside.any():
        raise SegmentationError(
            f"{_row(strokes, outside)} lies outside the image, which ends at {air.skin.ends()}"
            f"{_others(outside)}; were they painted in another position's image?"
        )
    for name in strokes["tissue"][in_air].unique():
        there = in_air & (strokes["tissue"] == name).to_numpy()
        if np.count_nonzero(there) > MOST_IN_AIR * counts[name]:
            raise SegmentationError(
                f"{np.count_nonzero(there)} of {counts[name]} points of {name} are as dark as air, and up to "
                f"{np.nanmax(air.skin.at(points[there])):.0f} mm outside the body, first "
                f"{_row(strokes, there)}; paint them anew"
            )


@dataclass(frozen=True)
class Air:
    """The air round a body: what is beyond its skin, and dark (nz, ny, nx) bool on the skin's grid."""

    skin: Skin
    dark: np.ndarray

    @classmethod
    def of(cls, image: Image) -> "Air":
        """Of an image. Raises ImageError when no body is in it."""
        skin, values = Skin.of(image), coarsened(image, VOXEL_MM).values
        level = DARK * np.median(values[skin.distance > 0]) if np.any(skin.distance > 0) else 0.0
        return cls(skin, values <= max(level, DARK_SHARE * bright_level(image)))

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Whether points (n, 3) lie in it (n,); those outside the image do not."""
        within = self.skin.holds(points)
        nearest = np.rint(self.skin.grid.indices(points[within])).astype(int)
        nearest = np.clip(nearest, 0, np.array(self.dark.shape) - 1)
        limit = BEYOND_MM + float(self.skin.grid.spacing.mean()) / 2
        found: np.ndarray = within.copy()
        found[within] = self.dark[tuple(nearest.T)] & (self.skin.at(points[within]) > limit)
        return found


def _require_no_mistake(points: np.ndarray, tissue: np.ndarray, air: Air) -> None:
    """Raise SegmentationError where tissue lies in the body after one correction of all points."""

    def fits(moved: np.ndarray) -> int:
        there = air.skin.holds(moved) & ~(tissue & air.holds(moved))
        return int(np.count_nonzero(there)) if np.ptp(moved, axis=0).max() >= LEAST_SPAN_MM else 0

    n, as_given = len(points), fits(points)
    if as_given > WELL_PLACED * n:
        return
    if found := mistake(points, air.skin.grid, fits, at_least=max(as_given + 2, n - n // 20)):
        words, step, count = found
        raise SegmentationError(
            f"of {n} points, which span {np.ptp(points, axis=0).max():.3g} mm, {as_given} can lie where they "
            f"are painted; {words}, {count} can: {step}"
        )


def _row(strokes: pd.DataFrame, which: np.ndarray) -> str:
    """The first of these rows: its number, place and tissue."""
    row = int(np.argmax(which))
    place = ", ".join(f"{value:.1f}" for value in strokes[AXES].iloc[row])
    return f"row {row + 1} ({strokes['tissue'].iloc[row]} at {place} mm)"


def _others(which: np.ndarray) -> str:
    more = np.count_nonzero(which) - 1
    return f", and so do {more} more" if more else ""
