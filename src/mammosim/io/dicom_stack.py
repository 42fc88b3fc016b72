"""Slices as one rectangular stack: order, spacing and orientation from the place of every slice.

Spacing follows the positions (DICOM PS3.3 C.7.6.2): SliceThickness is the thickness of the excited slab, not
the distance to the next one. A slice k of n belongs at p0 + k d n, n normal to its rows and columns; how far
each one is from there decides, not the ends of the stack alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import ImageError
from mammosim.io.dicom_planes import Plane
from mammosim.io.dicom_tags import EXPORT, require_equal, require_tags

# ASSUME: decimal strings round places by less than 0.1 mm, which is far below a voxel.
PLACE_TOLERANCE_MM = 0.1
# ASSUME: gaps differ by less than a half of the usual one, unless a slice is lost.
LARGE_GAP = 1.5
MULTIPLE = 0.1  # a gap that is a multiple of the usual one to this part of it: lost slices
# ASSUME: such a gap between so many slices on both sides, whose numbers tell of no loss, parts two stacks.
STACK_GAP, LEAST_IN_STACK = 2.5, 4
# ASSUME: slices this many thicknesses apart, whose numbers have this many times as many places, are not all.
SPARSE = 1.5
SAME_PLACE_MM = 1e-3
RESAMPLE = "resample"


@dataclass(frozen=True)
class Stack:
    """Slices (n) sorted along their normal.

    first (3,) mm: the first pixel of the first one; axes (3, 3): columns are the unit vectors along a row,
    along a column, and the normal; pixel_mm (2,): between columns, between rows; along (n,) mm: where the
    slices are along the normal, from the first one.
    """

    planes: tuple[Plane, ...]
    first: np.ndarray
    axes: np.ndarray
    pixel_mm: np.ndarray
    along: np.ndarray

    @property
    def step_mm(self) -> float:
        """Between slices of the even grid that is nearest to all of them."""
        return _even(self.along)[0]

    @property
    def off_mm(self) -> np.ndarray:
        """(n,) how far each slice is beyond its place on that grid."""
        step, start = _even(self.along)
        off: np.ndarray = self.along - start - step * np.arange(len(self.along))
        return off

    @property
    def origin(self) -> np.ndarray:
        """(3,) mm of the grid's first voxel."""
        origin: np.ndarray = self.first + _even(self.along)[1] * self.axes[:, 2]
        return origin

    @property
    def is_even(self) -> bool:
        """Whether all slices are where an even grid has them."""
        return bool(np.all(np.abs(self.off_mm) <= PLACE_TOLERANCE_MM))

    def all_have(self, keyword: str) -> bool:
        """Whether every slice has a tag."""
        return all(keyword in plane.tags for plane in self.planes)


def _even(along: np.ndarray) -> tuple[float, float]:
    """Step and start of the even places that are nearest to these (n,), by least squares."""
    step, start = np.polyfit(np.arange(len(along)), along, 1)
    return float(step), float(start)


def stacked(planes: Sequence[Plane], where: str, *, whole: bool = True, resampled: bool = False) -> Stack:
    """The stack of slices of one volume, in whatever order.

    whole: whether they are all slices of their series, so that their numbers tell of lost ones; resampled:
    whether uneven gaps are accepted, since the caller interpolates. Raises ImageError, naming the file: tags
    that are absent or cannot be; slices that differ, are shifted in plane, lost, or unevenly spaced.
    """
    for plane in planes:
        require_tags(plane)
    require_equal(planes, where)
    if len(planes) < 2:
        raise ImageError(
            f"{where} has {len(planes)} DICOM slice of a volume, which needs at least 2; give the folder "
            "that holds all of them"
        )
    axes = axes_of(planes)
    at = np.array([plane.numbers("ImagePositionPatient", 3) for plane in planes])
    order = np.argsort(at @ axes[:, 2], kind="stable")
    planes, at = tuple(planes[k] for k in order), at[order]
    along = (at - at[0]) @ axes[:, 2]
    stack = Stack(planes, at[0], axes, planes[0].numbers("PixelSpacing", 2)[::-1], along)
    _require_apart(planes, along, where)
    require_straight(planes, at @ axes[:, :2], where)
    _require_all(planes, along, where, whole=whole)
    if not resampled:
        _require_even(stack, where)
    return stack


def axes_of(planes: Sequence[Plane]) -> np.ndarray:
    """Columns (3, 3): the nearest orthonormal ones to rows, columns and normals of all slices."""
    mean = np.mean([plane.numbers("ImageOrientationPatient", 6) for plane in planes], axis=0)
    row, column = mean.reshape(2, 3)
    U, _, Vt = np.linalg.svd(np.column_stack([row, column, np.cross(row, column)]))
    axes: np.ndarray = U @ Vt
    return axes


def _require_apart(planes: Sequence[Plane], along: np.ndarray, where: str) -> None:
    gaps = np.diff(along)
    if np.all(gaps > SAME_PLACE_MM):
        return
    k, pairs = int(np.argmin(gaps)), np.sum(gaps <= SAME_PLACE_MM)
    raise ImageError(
        f"{where} has two slices in one place, {planes[k].label} and {planes[k + 1].label} ({pairs} such "
        "pairs), and no tag tells their phases or repetitions apart; keep one"
    )


def require_straight(planes: Sequence[Plane], inside: np.ndarray, where: str) -> None:
    """Raise ImageError where slices are shifted. inside (n, 2) mm: their places within their plane."""
    shift = np.linalg.norm(inside - np.median(inside, axis=0), axis=1)
    odd = shift > PLACE_TOLERANCE_MM
    if not odd.any():
        return
    k, limit = int(np.argmax(shift)), f"limit {PLACE_TOLERANCE_MM:g} mm"
    if odd.mean() < 0.5:
        raise ImageError(
            f"{planes[k]} is shifted by {shift[k]:.3g} mm in its plane beside the other slices "
            f"({odd.sum()} of {len(planes)} are, {limit}); {EXPORT}"
        )
    each = float(np.median(np.linalg.norm(np.diff(inside, axis=0), axis=1)))
    raise ImageError(
        f"{where}: each slice is shifted by {each:.3f} mm in its plane, {planes[k].label} by {shift[k]:.3g} "
        f"mm ({limit}); resample the series onto a rectangular grid"
    )


def _require_all(planes: Sequence[Plane], along: np.ndarray, where: str, *, whole: bool) -> None:
    """Raise ImageError where slices are lost, or stand in two stacks."""
    gaps, numbers = np.diff(along), _numbers(planes) if whole else None
    usual = float(np.median(gaps))
    for k in np.flatnonzero(gaps > LARGE_GAP * usual).tolist():
        ratio, sides = gaps[k] / usual, (k + 1, len(planes) - k - 1)
        lost = numbers is not None and abs(numbers[k + 1] - numbers[k]) == round(ratio)
        between = f"between {planes[k].label} and {planes[k + 1].label}"
        if ratio > STACK_GAP and min(sides) >= LEAST_IN_STACK and not lost:
            raise ImageError(
                f"{where} holds two stacks, of {sides[0]} and {sides[1]} slices, with {gaps[k]:.2f} mm "
                f"{between}, elsewhere {usual:.2f} mm; give each breast a folder of its own"
            )
        if ratio > STACK_GAP or abs(ratio - round(ratio)) <= MULTIPLE:
            raise ImageError(
                f"{where} lacks a slice: {between} the distance is {gaps[k]:.3f} mm, elsewhere {usual:.3f} "
                f"mm; {EXPORT}"
            )
    thickness = np.median([_thickness(plane, usual) for plane in planes])
    if numbers is not None and np.ptp(numbers) + 1 > SPARSE * len(planes) and usual > SPARSE * thickness:
        raise ImageError(
            f"{where} lacks slices throughout: they are {usual:.2f} mm apart at a SliceThickness of "
            f"{thickness:.2f} mm, and their numbers are {_first(numbers)}; {EXPORT}"
        )


def _first(numbers: np.ndarray) -> str:
    return ", ".join(f"{number:.0f}" for number in np.sort(numbers)[:3]) + " .."


def _thickness(plane: Plane, otherwise: float) -> float:
    """SliceThickness in mm, where it can be."""
    try:
        return plane.number("SliceThickness") or otherwise
    except ImageError:
        return otherwise


def _numbers(planes: Sequence[Plane]) -> np.ndarray | None:
    """InstanceNumber of each slice (n,), or its frame; None where some slice has none."""
    if all(plane.several for plane in planes):
        return np.array([plane.frame for plane in planes], float)
    try:
        return np.array([plane.number("InstanceNumber") for plane in planes])
    except ImageError:
        return None


def _require_even(stack: Stack, where: str) -> None:
    if stack.is_even:
        return
    gaps, off = np.diff(stack.along), np.abs(stack.off_mm)
    k, high = int(np.argmax(off)), int(np.argmax(gaps))
    raise ImageError(
        f"{where} has uneven gaps: {gaps.min():.3f} to {gaps.max():.3f} mm, the largest between "
        f"{stack.planes[high].label} and {stack.planes[high + 1].label}, so that {stack.planes[k].label} is "
        f"{off[k]:.2f} mm off an even grid (limit {PLACE_TOLERANCE_MM:g} mm); write {RESAMPLE!r} in the "
        "column `gaps` of its row to have it interpolated, or give an evenly spaced series"
    )
