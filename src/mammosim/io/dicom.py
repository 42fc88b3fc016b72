"""Reading one DICOM series as one volume in the patient frame LPS, or saying why it is none.

A series is a folder, a zip, or one file of several frames: `dicom_files` finds its slices, `dicom_choice` the
series and phase that is meant, `dicom_stack` judges their places, `dicom_pixels` reads the intensities.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mammosim.core.errors import ImageError
from mammosim.core.positions import GRAVITY
from mammosim.core.volume import Grid, Image
from mammosim.io.dicom_choice import choose
from mammosim.io.dicom_files import File, dicom_files
from mammosim.io.dicom_pixels import PADDING, intensities
from mammosim.io.dicom_planes import PHILIPS_SCALE, PREAMBLE, SUFFIXES, planes_of, quietly
from mammosim.io.dicom_stack import RESAMPLE, Stack, stacked
from mammosim.io.dicom_tags import is_inverse
from mammosim.io.images import ENDINGS
from mammosim.io.orientation import rising

DESCRIBING = ("SeriesDescription", "ProtocolName", "StudyDescription")
NOTED_MM = 0.005  # deviations from an even grid below this are rounding
LIKE_SCALES = 1.01  # two scales whose ratio varies by less than this between slices are alike


@dataclass(frozen=True)
class Series:
    """One volume and what its headers say about it.

    position: name of core.positions found in the description of series, protocol or study; None without.
    patient_position: the PatientPosition tag, e.g. 'HFP': head or feet first, prone or supine; None of a file
    that is no series.
    volunteer: the PatientID tag; None when empty.
    notes: what was done beside reading it, a line each, without anything that could be a patient's name.
    chosen: which of all series it is, as free of names; '' of a file that is no series.
    """

    image: Image
    position: str | None
    patient_position: str | None
    volunteer: str | None
    notes: tuple[str, ...] = ()
    chosen: str = ""


def is_series(path: str | Path) -> bool:
    """Whether a path is read by `read_series`: a folder, a zip or a DICOM file."""
    path = Path(path)
    if path.is_dir() or path.suffix.lower() in (".zip", *SUFFIXES):
        return True
    if not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(PREAMBLE + 4)[PREAMBLE:] == b"DICM"


def read_series(path: str | Path, *, series: str = "", gaps: str = "") -> Series:
    """Read one series of a folder, a zip or a file; axes permuted and flipped to the order (z, y, x).

    series: which one, where there are several: its number, its UID or a part of its description, and
    ' phase N' where it has several volumes; gaps: 'resample' to interpolate unevenly spaced slices linearly
    onto an even grid; nothing else is resampled. Raises ImageError, which names the file: no DICOM; several
    series or phases and none named; slices that are damaged, differ or are lost; no PatientPosition.
    """
    if gaps not in ("", RESAMPLE):
        raise ImageError(f"{path}: gaps = {gaps!r}; write {RESAMPLE!r}, or nothing")
    with dicom_files(path) as files, quietly():
        planes = planes_of(files, path)
        if not planes:
            raise ImageError(
                f"{path} has 0 DICOM slices with pixels; a volume needs at least 2; give the folder or zip "
                f"of a series{_or_image(files)}"
            )
        chosen = choose(planes, series, str(path))
        stack = stacked(chosen.planes, str(path), whole=chosen.whole, resampled=gaps == RESAMPLE)
        values = intensities(stack)
    notes = (*chosen.notes, *_notes(stack))
    tags = stack.planes[0].tags
    if is_inverse(stack.planes):
        np.subtract(values.max(), values, out=values)  # the brightest becomes 0
    if gaps == RESAMPLE and not stack.is_even:
        stack, values = _resampled(stack, values)
    return Series(
        _image(stack, values),
        _described_position(" ".join(str(tags.get(key, "")) for key in DESCRIBING)),
        str(tags["PatientPosition"]),
        str(tags.get("PatientID", "")) or None,
        notes,
        chosen.told,
    )


def _or_image(files: Sequence[File]) -> str:
    """Words on an image file that is there in the place of a series."""
    image = next((file.name for file in files if file.name.lower().endswith(ENDINGS)), "")
    return f", or {image} itself" if image else ""


def _notes(stack: Stack) -> Iterator[str]:
    """What was done, or stands out, of slices that are one volume."""
    off = float(np.abs(stack.off_mm).max())
    if not stack.is_even:
        gaps = np.diff(stack.along)
        yield f"slices {gaps.min():.3f} to {gaps.max():.3f} mm apart, interpolated onto an even grid"
    elif off > NOTED_MM:
        yield f"slices are up to {off:.3f} mm off an even grid of {stack.step_mm:.3f} mm"
    if is_inverse(stack.planes):
        yield "MONOCHROME1: dark and bright exchanged"
    if any(plane.tags.get(PADDING) for plane in stack.planes):
        yield f"pixels of the {PADDING}, where nothing was scanned, are taken as air"
    slopes = {plane.number("RescaleSlope", otherwise=1) for plane in stack.planes}
    if stack.all_have(PHILIPS_SCALE):
        yield f"intensities on the private scale of Philips, the same for all slices{_beside_display(stack)}"
    elif len(slopes) > 1:
        yield f"RescaleSlope is {min(slopes):g} to {max(slopes):g}: each slice has a scale of its own"


def _beside_display(stack: Stack) -> str:
    """What to look at where RescaleSlope and the private scale weigh slices differently.

    Of stored values P with slope RS and scale slope SS the intensity is P / SS, and the scanner shows P RS
    (Chenevert et al. 2014, doi 10.1593/tlo.13811): both are alike where RS SS is one number for all slices.
    """
    shown = [
        abs(plane.number("RescaleSlope", otherwise=1) * plane.number(PHILIPS_SCALE)) for plane in stack.planes
    ]
    apart = max(shown) / min(shown)
    return (
        f"; RescaleSlope would scale slices differently, by up to a factor of {apart:.3g}: check that "
        "all are equally bright"
        if apart > LIKE_SCALES
        else ""
    )


def _image(stack: Stack, values: np.ndarray) -> Image:
    spacing = np.array([*stack.pixel_mm, stack.step_mm])
    return Image(*rising(Grid(values.shape, spacing, stack.origin, stack.axes), values))


def _resampled(stack: Stack, values: np.ndarray) -> tuple[Stack, np.ndarray]:
    """The slices interpolated linearly along their normal, evenly from the first to the last one."""
    along = stack.along
    even = np.linspace(0, along[-1], round(along[-1] / np.median(np.diff(along))) + 1)
    below = np.clip(np.searchsorted(along, even, side="right") - 1, 0, len(along) - 2)
    share = (even - along[below]) / (along[below + 1] - along[below])
    found = np.empty((len(even), *values.shape[1:]), np.float32)
    for k, (at, part) in enumerate(zip(below, share)):
        found[k] = (1 - part) * values[at] + part * values[at + 1]
    return replace(stack, along=even), found


def _described_position(text: str) -> str | None:
    words = text.lower().replace("-", "_").split()
    return next((word for word in words if word in GRAVITY), None)
