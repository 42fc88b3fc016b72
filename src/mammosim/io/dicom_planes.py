"""The slices of DICOM files: each frame with the tags that place it, and what files are cut short.

Enhanced files keep the place of a frame in functional groups (DICOM PS3.3 C.7.6.16): those of the frame, then
those that all frames share, then the tags of the file. A slice of a classic file has the last only.
"""

import logging
import re
import struct
import warnings
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pydicom
from pydicom.config import disable_value_validation
from pydicom.dataset import FileDataset
from pydicom.errors import BytesLengthException, InvalidDicomError
from pydicom.filereader import read_partial
from pydicom.uid import UID

from mammosim.core.errors import ImageError
from mammosim.io.dicom_files import File

SUFFIXES = (".dcm", ".ima", ".dicom")
PREAMBLE = 128  # bytes before the four letters DICM
# How a file without these begins: with an element of group 2 or 8, little endian or big.
GROUPS = (b"\x02\x00", b"\x08\x00", b"\x00\x08")
PIXELS = {0x7FE00010, 0x7FE00009, 0x7FE00008}
# What pydicom and its decoders raise for tags and pixels that are damaged, or of a kind that they lack.
UNREADABLE = (
    BytesLengthException,
    AttributeError,
    EOFError,
    InvalidDicomError,
    LookupError,
    OSError,
    OverflowError,
    RuntimeError,
    TypeError,
    ValueError,
    struct.error,
)
PHILIPS = "Philips MR Imaging DD 001"
PHILIPS_SCALE = "scale slope of Philips"  # element 0E of that block of group 2005
NAMES = """
SOPClassUID SOPInstanceUID SeriesInstanceUID SeriesNumber InstanceNumber Modality ImageType FrameType
ImagePositionPatient ImageOrientationPatient PixelSpacing SliceThickness SpacingBetweenSlices
PatientPosition PatientID PatientName SeriesDescription ProtocolName StudyDescription
Rows Columns BitsAllocated PixelRepresentation SamplesPerPixel PhotometricInterpretation
RescaleSlope RescaleIntercept PixelPaddingValue PixelPaddingRangeLimit
AcquisitionNumber TemporalPositionIdentifier TemporalPositionIndex TemporalPositionTimeOffset
EchoNumbers EchoTime EffectiveEchoTime InversionTime FlipAngle DiffusionBValue ComplexImageComponent
TriggerTime NominalCardiacTriggerDelayTime StackID AcquisitionTime FrameAcquisitionDateTime ContentTime
ReferencedSegmentNumber NumberOfFrames
"""
KEPT = tuple(NAMES.split())


@dataclass(frozen=True, eq=False)
class Plane:
    """A slice: a file, or a frame of one. tags: values by keyword, without those that are empty."""

    file: File
    frame: int
    tags: Mapping[str, Any]
    where: str

    def __str__(self) -> str:
        return f"{self.where}: {self.label}"

    @property
    def label(self) -> str:
        """What to call it: its file, and the frame of several, from 1."""
        return self.file.name + (f", frame {self.frame + 1}" if self.several else "")

    @property
    def several(self) -> bool:
        """Whether its file has frames."""
        return "NumberOfFrames" in self.tags

    def numbers(self, keyword: str, count: int, *, otherwise: float | None = None) -> np.ndarray:
        """The value (count,) of a tag. Raises ImageError: absent or empty without `otherwise`, no numbers."""
        if keyword not in self.tags:
            if otherwise is None:
                raise ImageError(f"{self} has no {keyword}, which every slice needs; export the series again")
            return np.full(count, float(otherwise))
        try:
            values = np.array(self.tags[keyword], float).reshape(-1)
        except (TypeError, ValueError):
            values = np.array([np.nan])
        if values.shape != (count,) or not np.all(np.isfinite(values)):
            raise ImageError(f"{self}: its {keyword} is not {count} finite numbers; export the series again")
        return values

    def number(self, keyword: str, *, otherwise: float | None = None) -> float:
        """The value of a tag of one number, as `numbers`."""
        return float(self.numbers(keyword, 1, otherwise=otherwise)[0])


def planes_of(files: Sequence[File], where: str | Path) -> list[Plane]:
    """All slices with pixels. Raises ImageError: a file that is cut short, or no DICOM though named so."""
    found: list[Plane] = []
    others: list[str] = []
    for file in files:
        with readable(file, str(where)):
            dataset = _image_header(file, str(where))
            if dataset is None:
                others.append(file.name)
            elif len(dataset):
                found += planes_in(dataset, file, str(where))
    _require_all_read(others, {_pattern(plane.file.name) for plane in found}, where)
    return found


@contextmanager
def quietly() -> Iterator[None]:
    """Without what pydicom says of odd tags and failed decoders, which may quote free text.

    What matters of it is an ImageError.
    """
    logger = logging.getLogger("pydicom")
    level = logger.level
    with disable_value_validation(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", module="pydicom")
        logger.setLevel(logging.CRITICAL + 1)
        try:
            yield
        finally:
            logger.setLevel(level)


@contextmanager
def readable(file: File, where: str) -> Iterator[None]:
    """Raise ImageError, which names the file, for what pydicom raises within where tags are damaged."""
    try:
        yield
    except UNREADABLE:
        raise ImageError(f"{where}: {file.name} is damaged: its tags cannot be read; copy it again") from None


def header(file: File, where: str) -> tuple[FileDataset, bool] | None:
    """All tags before the pixels, and whether there are pixels; None for what is no DICOM file."""
    reached = False

    def at_pixels(tag: int, vr: str | None, length: int) -> bool:
        nonlocal reached
        reached = tag in PIXELS
        return reached

    with file.open() as opened, readable(file, where):
        head = opened.read(PREAMBLE + 4)
        bare = head[PREAMBLE:] != b"DICM"
        if bare and head[:2] not in GROUPS:
            return None
        opened.seek(0)
        return read_partial(opened, at_pixels, force=bare), reached


def _image_header(file: File, where: str) -> FileDataset | None:
    """The header of an image; an empty one of any other object, as of a report; None of no DICOM file."""
    read = header(file, where)
    if read is None:
        return None
    dataset, pixels = read
    meta = dataset.file_meta
    kind = UID(str(dataset.get("SOPClassUID") or meta.get("MediaStorageSOPClassUID") or ""))
    if kind.name != kind and "Image Storage" not in kind.name:
        return FileDataset("", {})
    if pixels:
        return dataset
    if not kind and not len(meta):
        return None
    raise ImageError(f"{where}: {file.name} is cut short: it ends before its pixels; copy it again")


def _require_all_read(others: Sequence[str], patterns: Collection[str], where: str | Path) -> None:
    """Raise ImageError where a file that is no DICOM file is named as one."""
    for name in others:
        if name.lower().endswith(SUFFIXES) or _pattern(name) in patterns:
            raise ImageError(
                f"{where}: {name} is no DICOM file any more, or cut short, though it is named as one; copy "
                "it again, or take it out"
            )


def _pattern(name: str) -> str:
    """A name without its numbers: the same for all slices of an export."""
    return re.sub(r"\d+", "#", Path(name).name.lower())


def planes_in(dataset: pydicom.Dataset, file: File, where: str) -> list[Plane]:
    """The slices of one file, by its header."""
    own = _tags(dataset)
    frames = dataset.get("PerFrameFunctionalGroupsSequence") or []
    count = int(own.pop("NumberOfFrames", len(frames) or 1))
    if not frames and count == 1:
        return [Plane(file, 0, own, where)]
    groups = [_grouped(item) for item in frames] or [{}] * count
    if len(groups) != count:
        raise ImageError(
            f"{where}: {file.name} has {count} frames and places of {len(groups)}; export it again"
        )
    common = own | {"NumberOfFrames": count}
    for item in dataset.get("SharedFunctionalGroupsSequence") or []:
        common |= _grouped(item)
    return [Plane(file, k, common | group, where) for k, group in enumerate(groups)]


def _grouped(item: pydicom.Dataset) -> dict[str, Any]:
    """The tags of all functional groups of a frame."""
    found: dict[str, Any] = {}
    for element in item:
        if element.VR == "SQ" and element.value:
            found |= _tags(element.value[0])
    return found


def _tags(dataset: pydicom.Dataset) -> dict[str, Any]:
    """Those of KEPT that have a value that can be read, and the scale of Philips."""
    found: dict[str, Any] = {}
    for keyword in KEPT:
        try:
            value = dataset.get(keyword)
        except UNREADABLE:
            continue
        if value is not None and (isinstance(value, int | float) or len(value) > 0):
            found[keyword] = value
    try:
        block = dataset.private_block(0x2005, PHILIPS)
        scale = float(block[0x0E].value) if 0x0E in block else 0.0
    except UNREADABLE:
        return found
    return found | ({PHILIPS_SCALE: scale} if scale else {})
