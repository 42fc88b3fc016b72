"""What a label map tells by itself: where the nipples and the chest are, as far as nobody marked them.

Frame of the labels: LPS, mm, x to the left, y to posterior, z to superior.
"""

import numpy as np
from scipy import ndimage

from mammosim.chain.label_geometry import MIDLINE_MM, middle_of
from mammosim.core.errors import FiducialError
from mammosim.core.fiducials import Fiducials
from mammosim.core.labels import Label
from mammosim.core.volume import Image, LabelMap

# Voxels of no body: balls on the skin are none of it.
OUTSIDE = (Label.AIR, Label.MARKER)
# ASSUME: the nipple of a hanging breast is in the middle of the tissue farthest from the rib cage, to 3 mm.
# In labels of a digital volunteer, of 4 mm, that was 7 and 11 mm off; her lowest tissue was 2 and 15 mm off.
TIP_MM = 3.0
# ASSUME: nipples of two breasts are farther apart than that; nearer ones are two places of one breast.
APART_MM = 60.0
# ASSUME: the frame of a scan begins near the midline of the body; a nipple is farther from it than 20 mm.
SIDE_MM = 20.0
# ASSUME: a slice belongs to the breasts where they stand out 10 mm in front of the midline's skin;
# 20 mm above and below are modelled, too, where fat and muscle are held.
STANDS_OUT_MM, BEYOND_MM = 10.0, 20.0
# A tissue's brightness in the image that stands for labels; air is dark.
BRIGHT = 1000.0


def outline_image(labels: LabelMap) -> Image:
    """The body bright and the air dark: by its outline labels are judged as an image is."""
    body = ~np.isin(labels.values, OUTSIDE)
    return Image(labels.grid, np.where(body, np.float32(BRIGHT), np.float32(0)))


def nipples(labels: LabelMap) -> Fiducials:
    """The nipples of a body that was scanned prone, where its halves reach farthest from the rib cage.

    One, where that is one place, or one half has nothing in front of the ribs. Raises FiducialError where no
    rib cage is labelled, nothing is in front of it, or a lone breast may be either.
    """
    thorax = labels.values == Label.THORAX
    if not thorax.any():
        raise FiducialError(
            f"no voxel is labelled as thorax ({Label.THORAX:d}), which the nipples are farthest from; label "
            "the rib cage, or list nipple_left and nipple_right"
        )
    depth = ndimage.distance_transform_edt(~thorax, sampling=labels.grid.spacing[::-1])
    points, depth = _body(labels), depth[~np.isin(labels.values, OUTSIDE)]
    left = points[:, 0] > middle_of(points[:, 0])
    front = points[:, 1] < points[:, 1][depth == 0].min()  # what lies beside the rib cage is no breast
    halves = {"left": left & front, "right": ~left & front}
    found = {side: _tip(points[half], depth[half]) for side, half in halves.items() if half.any()}
    if not found:
        raise FiducialError("nothing is in front of the rib cage; list nipple_left and nipple_right by hand")
    if len(found) == 2 and np.linalg.norm(found["left"] - found["right"]) < APART_MM:
        tip = _tip(points[front], depth[front])
        found = {_side(tip): tip}
    return Fiducials(
        tuple(f"nipple_{side}" for side in found), ("nipple",) * len(found), np.array(list(found.values()))
    )


def _side(tip: np.ndarray) -> str:
    """Which breast a lone one is. Raises FiducialError where its place (3,) does not tell."""
    if abs(tip[0]) < SIDE_MM:
        raise FiducialError(
            f"the labels hold one breast, and at x = {tip[0]:.0f} mm it may be either; list nipple_left or "
            "nipple_right"
        )
    return "left" if tip[0] > 0 else "right"


def chest_limits(labels: LabelMap, fiducials: Fiducials) -> np.ndarray:
    """In the place of chest markers: two points (2, 3) on the midline's skin, below and above the breasts.

    Raises FiducialError where nothing stands out in front of the midline.
    """
    points = _body(labels)
    listed = fiducials.of_kind("nipple")
    middle = float(listed[:, 0].mean()) if len(listed) == 2 else _medial_mm(points, fiducials)
    slices = np.rint(points[:, 2] / labels.grid.spacing[2]).astype(int)
    rows = np.unique(slices)
    front, chest = (
        _front(points[which], slices[which], rows) for which in (slice(None), _near(points, middle))
    )
    out = np.flatnonzero(chest - front > STANDS_OUT_MM)
    if not len(out):
        raise FiducialError("no breast stands out in front of the midline; list chest_1 to chest_4 by hand")
    ends = rows[[out[0], out[-1]]] * labels.grid.spacing[2] + [-BEYOND_MM, BEYOND_MM]
    return np.array([[middle, np.nanmin(chest[out]), z] for z in ends])


def between_breasts_mm(labels: LabelMap, nipple: np.ndarray) -> float:
    """x of the middle of a body with two breasts, by the nipple (3,) of one of them; NaN of a lone breast."""
    middle = middle_of(_body(labels)[:, 0])
    return middle if abs(nipple[0] - middle) > APART_MM / 2 else float("nan")


def _body(labels: LabelMap) -> np.ndarray:
    """Centres (n, 3) of the voxels of the body."""
    return labels.grid.points(np.argwhere(~np.isin(labels.values, OUTSIDE)).astype(float))


def _medial_mm(points: np.ndarray, fiducials: Fiducials) -> float:
    """x in the middle of a body with two breasts; of one alone, just inside its edge on the other side."""
    middle, listed = middle_of(points[:, 0]), fiducials.of_kind("nipple")
    if len(listed) != 1 or abs(listed[0, 0] - middle) > APART_MM / 2:
        return middle
    left = "nipple_left" in fiducials.names
    return float(points[:, 0].min() + MIDLINE_MM if left else points[:, 0].max() - MIDLINE_MM)


def _near(points: np.ndarray, middle_mm: float) -> np.ndarray:
    near: np.ndarray = np.abs(points[:, 0] - middle_mm) < MIDLINE_MM
    return near


def _tip(points: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """The middle (3,) of those points (n, 3) that have almost the largest depth (n,) mm."""
    tip: np.ndarray = points[depth >= depth.max() - TIP_MM].mean(axis=0)
    return tip


def _front(points: np.ndarray, slices: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Least y (n_row,) mm of the points in each slice, NaN where a slice has none."""
    found = np.full(len(rows), np.inf)
    np.minimum.at(found, np.searchsorted(rows, slices), points[:, 1])
    return np.where(np.isfinite(found), found, np.nan)
