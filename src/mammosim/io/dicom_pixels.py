"""The pixels of DICOM slices as intensities, whatever they are compressed by."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from pydicom import Dataset, dcmread
from pydicom.pixels import get_decoder, iter_pixels
from pydicom.uid import UID, ExplicitVRBigEndian, ExplicitVRLittleEndian, ImplicitVRLittleEndian

from mammosim.core.errors import ImageError
from mammosim.io.dicom_decoder import register_decoder
from mammosim.io.dicom_files import File
from mammosim.io.dicom_planes import PHILIPS_SCALE, UNREADABLE, Plane, readable
from mammosim.io.dicom_stack import Stack
from mammosim.io.dicom_tags import is_inverse

# How a file that does not name its encoding is encoded: implicit, little endian.
NATIVE: Mapping[tuple[bool | None, bool | None], UID] = {
    (True, True): ImplicitVRLittleEndian,
    (False, True): ExplicitVRLittleEndian,
    (False, False): ExplicitVRBigEndian,
}
PADDING = "PixelPaddingValue"
# What tags of the pixels mean where they are left out.
USUAL = {"SamplesPerPixel": 1, "PhotometricInterpretation": "MONOCHROME2"}


def intensities(stack: Stack) -> np.ndarray:
    """(n_slice, n_row, n_column) float32: stored values times slope plus intercept.

    Pixels of the PixelPaddingValue, which were not scanned, are as dark as the darkest of the others, or 0.
    Raises ImageError, naming the file: cut short, damaged, of an encoding that is not read, or not finite.
    """
    shape = tuple(int(stack.planes[0].number(keyword)) for keyword in ("Rows", "Columns"))
    private = stack.all_have(PHILIPS_SCALE)
    values = np.empty((len(stack.planes), *shape), np.float32)
    padded: dict[int, np.ndarray] = {}
    by_file: dict[File, list[int]] = {}
    for k in sorted(range(len(stack.planes)), key=lambda k: stack.planes[k].frame):
        by_file.setdefault(stack.planes[k].file, []).append(k)
    for slices in by_file.values():
        for k, stored in zip(slices, _stored([stack.planes[k] for k in slices], shape)):
            slope, intercept = _scale(stack.planes[k], private=private)
            values[k] = stored * slope + intercept
            if not np.isfinite(values[k]).all():
                raise ImageError(f"{stack.planes[k]} has pixels that are not finite; export the series again")
            if (outside := _padded(stored, stack.planes[k])).any():
                padded[k] = outside
    _darken(values, padded, inverse=is_inverse(stack.planes))
    return values


def _padded(stored: np.ndarray, plane: Plane) -> np.ndarray:
    """Whether a pixel (n_row, n_column) was not scanned: it has a value of padding."""
    one = plane.tags.get(PADDING)
    if not isinstance(one, int):
        return np.zeros(stored.shape, bool)
    limit = plane.tags.get("PixelPaddingRangeLimit")
    low, high = sorted(
        _as_stored(each, stored.dtype) for each in (one, limit if isinstance(limit, int) else one)
    )
    found: np.ndarray = (stored >= low) & (stored <= high)
    return found


def _as_stored(value: int, dtype: np.dtype) -> int:
    """A value of padding by the sign of the pixels: writers state -2000 as 63536, of 16 bits without sign."""
    if dtype.kind != "i" or value <= np.iinfo(dtype).max:
        return value
    return value - (1 << 8 * dtype.itemsize)


def _darken(values: np.ndarray, padded: Mapping[int, np.ndarray], *, inverse: bool) -> None:
    """What was not scanned becomes as dark as the darkest of the rest, or 0; inverse: the lowest is white."""
    sign = -1 if inverse else 1
    kept = [values[k][~padded[k]] if k in padded else values[k] for k in range(len(values))] if padded else []
    darkest = min((float((sign * each).min()) for each in kept if each.size), default=0.0)
    for k, outside in padded.items():
        values[k][outside] = sign * (darkest if inverse else min(darkest, 0.0))


def _scale(plane: Plane, *, private: bool) -> tuple[float, float]:
    """Slope and intercept from stored values to intensities.

    Philips scales each slice for display by itself: P slope + intercept. On one scale for all slices are
    (P slope + intercept) / (slope scale), with its private scale slope.
    """
    slope = plane.number("RescaleSlope", otherwise=1)
    intercept = plane.number("RescaleIntercept", otherwise=0)
    by = slope * plane.number(PHILIPS_SCALE) if private else 1.0
    return slope / by, intercept / by


def _stored(planes: Sequence[Plane], shape: tuple[int, ...]) -> Iterator[np.ndarray]:
    """The stored values (n_row, n_column) of frames of one file, in their order."""
    frames = [plane.frame for plane in planes] if planes[0].several else None
    dataset = with_pixels(planes[0].file, planes[0].where)
    if "PixelData" in dataset and "PixelRepresentation" not in planes[0].tags:
        raise ImageError(f"{planes[0]} has no PixelRepresentation, which says the sign; export it again")
    try:
        for plane, stored in zip(planes, iter_pixels(dataset, indices=frames, raw=True), strict=True):
            if stored.shape != shape:
                raise ImageError(f"{plane} has pixels of {stored.shape}, not {shape}; export it again")
            yield stored
    except UNREADABLE:
        raise ImageError(undecoded(planes[0], dataset)) from None


def with_pixels(file: File, where: str) -> Dataset:
    """A whole file, whose pixels can be decoded. Raises ImageError where its tags are damaged."""
    register_decoder()
    with file.open() as opened, readable(file, where):
        dataset = dcmread(opened, force=True)
        if not dataset.file_meta.get("TransferSyntaxUID"):
            dataset.file_meta.TransferSyntaxUID = NATIVE[dataset.original_encoding]
        for keyword, value in (USUAL | {"BitsStored": dataset.BitsAllocated}).items():
            if dataset.get(keyword) is None:
                setattr(dataset, keyword, value)
    return dataset


def undecoded(plane: Plane, dataset: Dataset) -> str:
    """What is wrong where the pixels of a plane's file do not decode. Raises ImageError: its tags are."""
    with readable(plane.file, plane.where):
        return _undecoded(plane, dataset)


def _undecoded(plane: Plane, dataset: Dataset) -> str:
    file, syntax = f"{plane.where}: {plane.file.name}", dataset.file_meta.TransferSyntaxUID
    try:
        known = get_decoder(syntax).is_available
    except NotImplementedError:
        known = False
    if not known:
        return f"{file} is compressed by {syntax.name}, which is not read; export it uncompressed"
    if syntax.is_compressed:
        return f"{file} is cut short or damaged: its pixels ({syntax.name}) do not decode; copy it again"
    stored = len(dataset.get("PixelData") or b"")
    bits = dataset.Rows * dataset.Columns * dataset.BitsAllocated * int(dataset.get("NumberOfFrames") or 1)
    if 8 * stored < bits:
        return f"{file} is cut short: it has {stored} of {-(-bits // 8)} bytes of pixels; copy it again"
    return f"{file}: its pixels do not fit its tags, as BitsAllocated or BitsStored; export it again"
