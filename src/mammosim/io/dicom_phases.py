"""Phases, echoes and other volumes of one series, told apart by the tags in which their slices differ."""

from collections.abc import Mapping, Sequence

import numpy as np
from pydicom import dcmread

from mammosim.core.errors import ImageError
from mammosim.io.dicom_planes import Plane

# Tags that tell phases, echoes, contrasts or stacks of one series apart, the likeliest first.
NAMES = """
AcquisitionNumber TemporalPositionIdentifier TemporalPositionIndex TemporalPositionTimeOffset EchoNumbers
EffectiveEchoTime EchoTime InversionTime FlipAngle DiffusionBValue ComplexImageComponent FrameType ImageType
TriggerTime NominalCardiacTriggerDelayTime StackID
"""
TELLING = tuple(NAMES.split())
# Times differ from slice to slice: of each place, the first slice is of the first phase.
RANKED = ("TriggerTime", "FrameAcquisitionDateTime", "AcquisitionTime", "ContentTime")
# ASSUME: a phase has at least three quarters of the places of all of them; what has less is none.
LEAST_PLACES = 0.75
SAME_PLACE_MM, SAME_DIRECTION = 0.01, 0.01
Value = tuple[float, str]
Place = tuple[int, ...]


def each_once(group: Sequence[Plane]) -> tuple[list[Plane], tuple[str, ...]]:
    """Without copies of a slice, and words on them.

    Some programs that take names out give all slices one SOPInstanceUID: what stands elsewhere is no copy.
    Raises ImageError where two of one SOPInstanceUID and place differ.
    """
    first: dict[tuple[str, int, Place], Plane] = {}
    place = _places(group)
    equal: dict[tuple[str, str], bool] = {}
    for plane in group:
        uid = str(plane.tags.get("SOPInstanceUID") or plane.file.name)
        other = first.setdefault((uid, plane.frame, place[plane]), plane)
        if other is plane:
            continue
        pair = other.file.name, plane.file.name
        if pair not in equal:
            equal[pair] = _equal(other, plane)
        if not equal[pair]:
            raise ImageError(
                f"{plane.where}: {other.label} and {plane.label} have one SOPInstanceUID and differ; keep one"
            )
    return list(first.values()), tuple(f"{copy} left out, a copy of {file}" for file, copy in equal)


def _equal(one: Plane, other: Plane) -> bool:
    """Whether two files have the same tags that matter here, and the same pixels."""
    if dict(one.tags) != dict(other.tags):
        return False
    with one.file.open() as a, other.file.open() as b:
        return bool(dcmread(a, force=True).get("PixelData") == dcmread(b, force=True).get("PixelData"))


def phases_of(group: Sequence[Plane]) -> tuple[list[list[Plane]], str]:
    """Volumes of a series in the order of the tag that tells them apart, and the tag; [group], '' for one."""
    place = _places(group)
    if len(set(place.values())) == len(group):
        return [list(group)], ""
    for tag in TELLING:
        if parts := _parts({plane: _sortable(plane.tags.get(tag)) for plane in group}, place):
            return [phase for part in parts for phase in phases_of(part)[0]], tag
    for tag in RANKED:
        if parts := _parts(_ranks(place, tag), place):
            return parts, tag
    return [list(group)], ""


def _places(group: Sequence[Plane]) -> dict[Plane, Place]:
    """Of each slice where it stands, and how, on a fine grid; of its own for one that says no place."""
    place: dict[Plane, Place] = {}
    for n, plane in enumerate(group):
        if {"ImagePositionPatient", "ImageOrientationPatient"} - set(plane.tags):
            place[plane] = (n,)
            continue
        at = plane.numbers("ImagePositionPatient", 3) / SAME_PLACE_MM
        direction = plane.numbers("ImageOrientationPatient", 6) / SAME_DIRECTION
        place[plane] = tuple(np.round([*at, *direction]).astype(int).tolist())
    return place


def _parts(values: Mapping[Plane, Value], place: Mapping[Plane, Place]) -> list[list[Plane]]:
    """The slices by value, where each part has nearly all places; [] where that tells no volumes apart."""
    parts: dict[Value, list[Plane]] = {}
    for plane, value in values.items():
        parts.setdefault(value, []).append(plane)
    least = LEAST_PLACES * len(set(place.values()))
    whole = all(len({place[plane] for plane in part}) >= least for part in parts.values())
    return [parts[value] for value in sorted(parts)] if whole and len(parts) > 1 else []


def _ranks(place: Mapping[Plane, Place], tag: str) -> dict[Plane, Value]:
    """Of each slice how many of its place were earlier.

    {} where places have different numbers of slices, or slices of one place the same time.
    """
    there: dict[Place, list[Plane]] = {}
    for plane, at in place.items():
        there.setdefault(at, []).append(plane)
    ranks: dict[Plane, Value] = {}
    for planes in there.values():
        times = sorted({_sortable(plane.tags.get(tag)) for plane in planes})
        if len(times) != len(place) / len(there):
            return {}
        ranks |= {plane: (float(times.index(_sortable(plane.tags.get(tag)))), "") for plane in planes}
    return ranks


def _sortable(value: object) -> Value:
    """Numbers by size, text by letters."""
    try:
        return float(str(value)), ""
    except ValueError:
        return 0.0, str(value)
