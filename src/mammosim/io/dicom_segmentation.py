"""Reading a DICOM segmentation object as one label array: segments by number, with their names.

Frames of a segmentation may leave out what is empty (DICOM PS3.3 A.51): the grid spans the frames there are.
"""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pydicom import Dataset
from pydicom.pixels import pixel_array

from mammosim.core.errors import ImageError
from mammosim.core.volume import Grid
from mammosim.io.dicom_files import File, dicom_files
from mammosim.io.dicom_pixels import undecoded, with_pixels
from mammosim.io.dicom_planes import UNREADABLE, Plane, header, planes_in, quietly, readable
from mammosim.io.dicom_stack import PLACE_TOLERANCE_MM, axes_of, require_straight
from mammosim.io.dicom_tags import SAME, require_place
from mammosim.io.orientation import rising

SEGMENTATIONS = ("1.2.840.10008.5.1.4.1.1.66.4", "1.2.840.10008.5.1.4.1.1.66.7")  # of segments, of labels


class Segments(NamedTuple):
    """labels (nz, ny, nx) uint16 of segment numbers, 0 for none, and the name of each number.

    overlapping: voxels that lie in several segments; there the smallest segment is kept.
    """

    grid: Grid
    labels: np.ndarray
    names: dict[int, str]
    overlapping: int


def read_seg(path: str | Path) -> Segments:
    """The segments of a file, or of the only segmentation in a folder or zip.

    Axes as `read_series` turns them. Names are free text of whoever segmented. Raises ImageError, naming the
    file: none or several segmentations; damaged; frames without a place or segment, or between the slices of
    the others.
    """
    with dicom_files(path) as files, quietly():
        found = [file for file in files if _is_seg(file, str(path))]
        if len(found) != 1:
            listed = "".join(f", {file.name}" for file in found)
            raise ImageError(f"{path} has {len(found)} DICOM segmentations{listed}; give the file of one")
        dataset = with_pixels(found[0], str(path))
        with readable(found[0], str(path)):
            planes = planes_in(dataset, found[0], str(path))
            names_of = _names(dataset, planes[0])
        frames = _frames(dataset, planes)
    grid, at = _grid(planes)
    labels, overlapping = _labels(dataset, planes, frames, names_of, (at, grid.shape))
    return Segments(*rising(grid, labels), names_of, overlapping)


def holds_seg(files: Iterable[File], where: str) -> bool:
    """Whether one of these files is a DICOM segmentation. Raises ImageError for tags that are damaged."""
    with quietly():
        return any(_is_seg(file, where) for file in files)


def _is_seg(file: File, where: str) -> bool:
    read = header(file, where)
    return read is not None and str(read[0].get("SOPClassUID", "")) in SEGMENTATIONS


def _names(dataset: Dataset, plane: Plane) -> dict[int, str]:
    """Segment number -> its label, else the meaning of its type."""
    found: dict[int, str] = {}
    for segment in dataset.get("SegmentSequence") or []:
        kinds = segment.get("SegmentedPropertyTypeCodeSequence") or [Dataset()]
        number = segment.get("SegmentNumber")
        if number is not None:
            found[int(number)] = str(segment.get("SegmentLabel") or kinds[0].get("CodeMeaning") or "")
    if not found:
        raise ImageError(f"{plane.where}: {plane.file.name} names no segments; export the segmentation again")
    return found


def _frames(dataset: Dataset, planes: Sequence[Plane]) -> np.ndarray:
    """The stored frames (n_frame, n_row, n_column). Raises ImageError: fewer or damaged."""
    try:
        stored = pixel_array(dataset, raw=True)
        return stored.reshape(len(planes), *stored.shape[-2:])
    except UNREADABLE:
        raise ImageError(undecoded(planes[0], dataset)) from None


def _require_named(numbers: np.ndarray, names: Mapping[int, str], plane: Plane) -> None:
    """Raise ImageError for a segment that is not described."""
    if unknown := sorted(set(np.unique(numbers).tolist()) - {0, *names}):
        raise ImageError(
            f"{plane.where}: {plane.file.name} has frames of segment {unknown[0]}, which it does not name; "
            "export it again"
        )


def _grid(planes: Sequence[Plane]) -> tuple[Grid, np.ndarray]:
    """The grid that the frames are slices of, and which slice (n_frame,) each is."""
    for plane in planes:
        require_place(plane)
    axes = axes_of(planes)
    turned = [
        np.abs(plane.numbers("ImageOrientationPatient", 6) - axes.T[:2].ravel()).max() for plane in planes
    ]
    if max(turned) > SAME:
        raise ImageError(f"{planes[int(np.argmax(turned))]} is turned against the others; export it again")
    at = np.array([plane.numbers("ImagePositionPatient", 3) for plane in planes])
    require_straight(planes, at @ axes[:, :2], planes[0].where)
    along = (at - at[np.argmin(at @ axes[:, 2])]) @ axes[:, 2]
    step = _step(planes[0], along)
    number = np.round(along / step).astype(int)
    off = np.abs(along - number * step)
    if off.max() > PLACE_TOLERANCE_MM:
        raise ImageError(
            f"{planes[int(np.argmax(off))]} is {off.max():.2f} mm off slices of {step:.3f} mm (limit "
            f"{PLACE_TOLERANCE_MM:g} mm); segment an evenly spaced series"
        )
    first = at[int(np.argmin(along))]
    rows, columns = (int(planes[0].number(keyword)) for keyword in ("Rows", "Columns"))
    shape = (int(number.max()) + 1, rows, columns)
    spacing = np.array([*planes[0].numbers("PixelSpacing", 2)[::-1], step])
    return Grid(shape, spacing, first, axes), number


def _step(plane: Plane, along: np.ndarray) -> float:
    """Distance of slices: as written, or the smallest between frames where that is less."""
    gaps = np.diff(np.unique(np.round(along, 3)))
    written = [plane.number(key, otherwise=0) for key in ("SpacingBetweenSlices", "SliceThickness")]
    given = next((value for value in written[: 1 if len(gaps) else 2] if value > 0), np.inf)
    step = min(given, gaps.min() if len(gaps) else np.inf)
    if not np.isfinite(step):
        raise ImageError(f"{plane} has one slice, and no SpacingBetweenSlices; export the segmentation again")
    # A written distance is rounded; all frames together say it better.
    count = np.round(along.max() / step)
    return float(along.max() / count) if count else float(step)


def _labels(
    dataset: Dataset,
    planes: Sequence[Plane],
    frames: np.ndarray,
    names: dict[int, str],
    place: tuple[np.ndarray, tuple[int, ...]],
) -> tuple[np.ndarray, int]:
    """(nk, nj, ni) uint16, and how many voxels lie in several segments.

    place: the slice of each frame, and the shape.
    """
    at, shape = place
    labels, several = np.zeros(shape, np.uint16), np.zeros(shape, bool)
    kind = str(dataset.get("SegmentationType", "BINARY"))
    if kind == "LABELMAP":
        labels[at] = frames
        _require_named(labels, names, planes[0])
        return labels, 0
    half = float(dataset.get("MaximumFractionalValue") or 255) / 2 if kind == "FRACTIONAL" else 0.5
    inside = frames >= half
    owner = np.array([int(plane.number("ReferencedSegmentNumber")) for plane in planes])
    _require_named(owner, names, planes[0])
    size = {number: int(inside[owner == number].sum()) for number in names}
    # ASSUME: of segments that overlap, the smaller one is a part of the larger one.
    for number in sorted(names, key=lambda number: size[number], reverse=True):
        for k in np.flatnonzero(owner == number):
            several[at[k]] |= inside[k] & (labels[at[k]] > 0)
            labels[at[k]][inside[k]] = number
    return labels, int(np.count_nonzero(several))
