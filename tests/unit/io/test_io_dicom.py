"""A series becomes one volume in the patient frame, or one error that says which slice is at fault."""

import fnmatch
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pydicom
import pytest
from pydicom.uid import ExplicitVRLittleEndian, MRImageStorage, generate_uid

from mammosim.core.errors import ImageError
from mammosim.core.rigid import rotation
from mammosim.core.volume import Grid
from mammosim.io.dicom import read_series

DATA = Path(__file__).parents[3].parent / "shared/data"
GRID = Grid(
    (6, 5, 4), np.array([1.5, 1.25, 3.0]), np.array([-20.0, -30.0, 40.0]), rotation(np.array([0, 2.0, 0]))
)
VALUES = np.random.default_rng(1).integers(0, 1000, GRID.shape).astype(np.uint16)
Change = Callable[[int, pydicom.Dataset], None]


def _slice(k: int) -> pydicom.Dataset:
    dataset = pydicom.Dataset()
    dataset.file_meta = pydicom.dataset.FileMetaDataset()
    dataset.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
    dataset.SOPClassUID = dataset.file_meta.MediaStorageSOPClassUID = MRImageStorage
    dataset.SOPInstanceUID = dataset.file_meta.MediaStorageSOPInstanceUID = generate_uid(
        entropy_srcs=[str(k)]
    )
    dataset.SeriesInstanceUID = generate_uid(entropy_srcs=["series"])
    dataset.PatientID, dataset.PatientPosition = "large", "HFP"
    dataset.SeriesDescription = "T2 prone"
    dataset.SliceThickness = "1.0"
    dataset.ImagePositionPatient = GRID.points(np.array([[k, 0, 0]]))[0].round(6).tolist()
    dataset.ImageOrientationPatient = [*GRID.direction[:, 0].round(9), *GRID.direction[:, 1].round(9)]
    dataset.PixelSpacing = [GRID.spacing[1], GRID.spacing[0]]
    dataset.Rows, dataset.Columns = GRID.shape[1:]
    dataset.BitsAllocated = dataset.BitsStored = 16
    dataset.HighBit, dataset.PixelRepresentation = 15, 0
    dataset.SamplesPerPixel, dataset.PhotometricInterpretation = 1, "MONOCHROME2"
    dataset.PixelData = VALUES[k].tobytes()
    return dataset


def _write(
    folder: Path, change: Change = lambda k, dataset: None, *, slices: tuple[int, ...] = tuple(range(6))
) -> Path:
    for k in slices:
        dataset = _slice(k)
        change(k, dataset)
        # File names run against the slice order: only the position may decide.
        dataset.save_as(folder / f"{9 - k}.dcm", enforce_file_format=True)
    return folder


def test_a_tilted_series_keeps_its_place_and_intensities(tmp_path: Path) -> None:
    series = read_series(_write(tmp_path))
    assert series.image.grid.same_as(GRID)
    np.testing.assert_array_equal(series.image.values, VALUES)
    assert (series.position, series.patient_position, series.volunteer) == ("prone", "HFP", "large")


def test_spacing_follows_the_positions_not_the_slice_thickness(tmp_path: Path) -> None:
    # Positions are written to 1e-6 mm.
    assert read_series(_write(tmp_path)).image.grid.spacing[2] == pytest.approx(3.0, abs=1e-5)


def test_stored_values_are_rescaled(tmp_path: Path) -> None:
    def rescale(k: int, dataset: pydicom.Dataset) -> None:
        dataset.RescaleSlope, dataset.RescaleIntercept = "2", "-10"

    np.testing.assert_array_equal(read_series(_write(tmp_path, rescale)).image.values, 2.0 * VALUES - 10)


def _no_position(k: int, dataset: pydicom.Dataset) -> None:
    if k == 2:
        del dataset.PatientPosition


def _two_series(k: int, dataset: pydicom.Dataset) -> None:
    if k > 3:
        dataset.SeriesInstanceUID = generate_uid(entropy_srcs=["another"])


def _twice(k: int, dataset: pydicom.Dataset) -> None:
    if k == 3:
        dataset.ImagePositionPatient = GRID.points(np.array([[2, 0, 0]]))[0].round(6).tolist()


def _turned(k: int, dataset: pydicom.Dataset) -> None:
    if k == 5:
        dataset.ImageOrientationPatient = [0, 1, 0, 0, 0, -1]


def _other_spacing(k: int, dataset: pydicom.Dataset) -> None:
    if k == 5:
        dataset.PixelSpacing = [2.0, 2.0]


def _sheared(k: int, dataset: pydicom.Dataset) -> None:
    x, y, z = dataset.ImagePositionPatient
    dataset.ImagePositionPatient = [x, y + k * 0.5, z]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (_no_position, r"1 of 6 slices have no PatientPosition tag \(0018,5100\)"),
        (_two_series, "mixes 2 series: 2 slices of 'T2 prone'.*; 4 slices.*folder of its own"),
        (_twice, "two slices at .* mm along the slice normal"),
        (_turned, "ImageOrientationPatient is .* in one slice and .* in another"),
        (_other_spacing, "PixelSpacing is"),
        (_sheared, r"shifted by 0\.500 mm in its plane, the limit is 0\.01 mm"),
    ],
)
def test_a_series_that_is_no_volume_is_rejected(tmp_path: Path, change: Change, message: str) -> None:
    with pytest.raises(ImageError, match=message):
        read_series(_write(tmp_path, change))


def test_a_missing_slice_is_rejected_with_its_place(tmp_path: Path) -> None:
    normal = GRID.direction[:, 2]
    below, above = (GRID.points(np.array([[k, 0, 0]]))[0] @ normal for k in (2, 4))
    message = (
        f"lacks a slice: between {below:.2f} and {above:.2f} mm along the normal the distance is 6.000 mm"
    )
    with pytest.raises(ImageError, match=message):
        read_series(_write(tmp_path, slices=(0, 1, 2, 4, 5)))


def test_a_folder_without_dicom_is_rejected(tmp_path: Path) -> None:
    (tmp_path / "readme.txt").write_text("no DICOM here")
    with pytest.raises(ImageError, match=r"has 0 DICOM slices.*at least 2"):
        read_series(tmp_path)
    with pytest.raises(ImageError, match=r"no folder .*absent; give the folder"):
        read_series(tmp_path / "absent")


def _unzip(name: str, folder: Path, *, pattern: str = "*.dcm") -> Path:
    if not (DATA / name).is_file():
        pytest.skip(f"the real series {name} is not beside the checkout (shared/data)")
    with zipfile.ZipFile(DATA / name) as archive:
        archive.extractall(folder, fnmatch.filter(archive.namelist(), pattern))
    return folder


@pytest.mark.data
def test_a_real_tilted_prone_series_keeps_its_tilt(tmp_path: Path) -> None:
    series = read_series(_unzip("duke_breast_mri_001_dicom.zip", tmp_path, pattern="1-03?.dcm"))
    grid = series.image.grid
    assert (grid.shape, series.patient_position) == ((10, 448, 448), "FFP")
    # PixelSpacing and tilt as printed in the headers.
    np.testing.assert_allclose(grid.spacing, [0.80357, 0.80357, 1.1], atol=1e-4)
    np.testing.assert_allclose(grid.direction[:, 0], [0.99933, 0, 0.03664], atol=1e-4)


@pytest.mark.data
def test_a_real_coronal_series_has_the_spacing_of_its_positions(tmp_path: Path) -> None:
    series = read_series(_unzip("haste_torso_dicom.zip", tmp_path))
    # The SliceThickness tag says 7 mm; the slices stand 8.75 mm apart along y.
    np.testing.assert_allclose(series.image.grid.spacing, [1.5625, 8.75, 1.5625], atol=1e-4)
    assert series.image.grid.shape == (256, 30, 256)


@pytest.mark.data
def test_a_real_series_without_one_slice_is_rejected(tmp_path: Path) -> None:
    folder = _unzip("haste_torso_dicom.zip", tmp_path)
    sorted(folder.rglob("*.dcm"))[12].unlink()
    with pytest.raises(ImageError, match=r"lacks a slice: between .* the distance is 17\.500 mm"):
        read_series(folder)
