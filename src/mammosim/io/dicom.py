"""Reading one DICOM series as one volume in the patient frame LPS, or saying why it is none.

Spacing and orientation follow the positions of the slices (DICOM PS3.3 C.7.6.2): SliceThickness is the
thickness of the excited slab, not the distance to the next one.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pydicom
from pydicom.errors import InvalidDicomError

from mammosim.core.errors import ImageError
from mammosim.core.positions import GRAVITY
from mammosim.core.volume import Grid, Image
from mammosim.io.images import image_of, itk_volume

# Distances between slices may differ by this part of the usual one: rounding of decimal strings.
GAP_TOLERANCE = 0.02
# Slices may be shifted within their plane by this much from one to the next.
SHEAR_TOLERANCE_MM = 0.01
NEEDED = ("SeriesInstanceUID", "ImageOrientationPatient", "ImagePositionPatient", "PixelSpacing", "PixelData")


@dataclass(frozen=True)
class Series:
    """One volume and what its headers say about it.

    position: name of core.positions found in the description of series, protocol or study; None without.
    patient_position: the PatientPosition tag, e.g. 'HFP': head or feet first, prone or supine.
    volunteer: the PatientID tag; None when empty.
    """

    image: Image
    position: str | None
    patient_position: str
    volunteer: str | None


def read_series(folder: str | Path) -> Series:
    """Read all slices of a folder; axes permuted and flipped to the order (z, y, x), not resampled.

    Raises ImageError: no DICOM; several series; slices that differ in size, spacing or orientation; no
    PatientPosition; two slices in one place; a missing slice.
    """
    slices = _slices(Path(folder))
    _require_one_series(slices, folder)
    _require_equal(slices, folder)
    first = slices[0]
    along = _positions(slices) @ _normal(first)
    order = np.argsort(along)
    _require_even(along[order], folder)
    return Series(
        _volume([slices[k] for k in order], folder),
        _described_position(first),
        str(first.PatientPosition),
        str(first.get("PatientID") or "") or None,
    )


def _slices(folder: Path) -> list[pydicom.Dataset]:
    if not folder.is_dir():
        raise ImageError(f"no folder {folder}; give the folder that holds the DICOM files of one series")
    slices = [found for path in sorted(folder.rglob("*")) if path.is_file() and (found := _slice(path))]
    if len(slices) < 2:
        raise ImageError(
            f"{folder} has {len(slices)} DICOM slices with pixels and position; a volume needs at least 2"
        )
    return slices


def _slice(path: Path) -> pydicom.Dataset | None:
    try:
        dataset = pydicom.dcmread(path)
    except InvalidDicomError:
        return None
    return dataset if all(key in dataset for key in NEEDED) else None


def _require_one_series(slices: Sequence[pydicom.Dataset], folder: str | Path) -> None:
    count = Counter(str(s.SeriesInstanceUID) for s in slices)
    if len(count) > 1:
        text = {str(s.SeriesInstanceUID): str(s.get("SeriesDescription", "")) for s in slices}
        listed = "; ".join(f"{n} slices of {text[uid]!r} {uid}" for uid, n in count.items())
        raise ImageError(
            f"{folder} mixes {len(count)} series: {listed}; give each series a folder of its own"
        )


def _require_equal(slices: Sequence[pydicom.Dataset], folder: str | Path) -> None:
    without = sum(not s.get("PatientPosition") for s in slices)
    if without:
        raise ImageError(
            f"{folder}: {without} of {len(slices)} slices have no PatientPosition tag (0018,5100), so that "
            "the position cannot be checked against gravity; add HFP, HFS, FFP or FFS as scanned"
        )
    for key in ("Rows", "Columns", "PatientPosition", "PixelSpacing", "ImageOrientationPatient"):
        values = [s.get(key) for s in slices]
        odd = next((value for value in values if not _equal(value, values[0])), None)
        if odd is not None:
            raise ImageError(
                f"{folder}: {key} is {values[0]} in one slice and {odd} in another; a volume needs equal "
                "slices: take out localizers and other views"
            )


def _equal(a: Any, b: Any) -> bool:
    return (
        a == b if isinstance(a, str) else bool(np.allclose(np.array(a, float), np.array(b, float), atol=1e-4))
    )


def _positions(slices: Sequence[pydicom.Dataset]) -> np.ndarray:
    return np.array([s.ImagePositionPatient for s in slices], float)


def _axes(dataset: pydicom.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors along a row (rising column index) and along a column (rising row index)."""
    orientation = np.array(dataset.ImageOrientationPatient, float)
    return orientation[:3], orientation[3:]


def _normal(dataset: pydicom.Dataset) -> np.ndarray:
    return np.cross(*_axes(dataset))


def _require_even(along: np.ndarray, folder: str | Path) -> None:
    """along (n,) mm: sorted distances of the slices along their normal."""
    gaps = np.diff(along)
    usual = np.median(gaps)
    if np.any(gaps < 1e-3):
        where = along[np.argmin(gaps)]
        raise ImageError(
            f"{folder} has two slices at {where:.2f} mm along the slice normal ({np.sum(gaps < 1e-3)} such "
            "pairs); keep one phase or one repetition"
        )
    if np.any(np.abs(gaps - usual) > GAP_TOLERANCE * usual):
        k = int(np.argmax(np.abs(gaps - usual)))
        raise ImageError(
            f"{folder} lacks a slice: between {along[k]:.2f} and {along[k + 1]:.2f} mm along the normal "
            f"the distance is {gaps[k]:.3f} mm, elsewhere {usual:.3f} mm (limit {GAP_TOLERANCE:.0%}); "
            "export the series again"
        )


def _volume(slices: Sequence[pydicom.Dataset], folder: str | Path) -> Image:
    """The volume of slices sorted along their normal."""
    row, column = _axes(slices[0])
    normal = np.cross(row, column)
    origins = _positions(slices)
    step = (origins[-1] - origins[0]) / (len(slices) - 1)
    shift = np.linalg.norm(step - (step @ normal) * normal)
    if shift > SHEAR_TOLERANCE_MM:
        raise ImageError(
            f"{folder}: each slice is shifted by {shift:.3f} mm in its plane, the limit is "
            f"{SHEAR_TOLERANCE_MM:g} mm; resample the series onto a rectangular grid"
        )
    between_rows, between_columns = map(float, slices[0].PixelSpacing)
    values = np.stack([_intensities(s) for s in slices])
    spacing = np.array([between_columns, between_rows, step @ normal])
    grid = Grid(values.shape, spacing, origins[0], np.column_stack([row, column, normal]))
    return image_of(itk_volume(grid, values))


def _intensities(dataset: pydicom.Dataset) -> np.ndarray:
    """Stored values (n_row, n_column) times RescaleSlope plus RescaleIntercept."""
    slope, intercept = float(dataset.get("RescaleSlope", 1)), float(dataset.get("RescaleIntercept", 0))
    return (dataset.pixel_array * slope + intercept).astype(np.float32)


def _described_position(dataset: pydicom.Dataset) -> str | None:
    keys = ("SeriesDescription", "ProtocolName", "StudyDescription")
    words = " ".join(str(dataset.get(key, "")) for key in keys).lower().replace("-", "_").split()
    return next((word for word in words if word in GRAVITY), None)
