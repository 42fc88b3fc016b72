"""A scan is a series or an image file, whichever its path is."""

from pathlib import Path

import numpy as np
import pytest
from dicom_series import GRID, VALUES, place, write
from pydicom import Dataset

from mammosim.core.errors import ImageError
from mammosim.core.volume import Image
from mammosim.io.images import write_image
from mammosim.io.scans import read_scan


def test_a_folder_is_a_series(tmp_path: Path) -> None:
    scan = read_scan(write(tmp_path), series="5")
    np.testing.assert_array_equal(scan.image.values, VALUES)
    assert scan.patient_position == "HFP"


def test_a_file_is_an_image_without_a_tag(tmp_path: Path) -> None:
    path = tmp_path / "a.nii.gz"
    write_image(Image(GRID, VALUES.astype(np.float32)), path)
    scan = read_scan(path)
    np.testing.assert_array_equal(scan.image.values, VALUES)
    assert scan.patient_position is None
    with pytest.raises(ImageError, match=r"a\.nii\.gz is an image file: series and gaps"):
        read_scan(path, series="5")
    with pytest.raises(ImageError, match=r"a\.nii\.gz is an image file: series and gaps"):
        read_scan(path, gaps="resample")


def test_a_file_that_may_not_be_opened_is_named_in_one_line(tmp_path: Path, monkeypatch) -> None:
    path = tmp_path / "a.nii.gz"
    path.touch()

    def denied(self: Path, *about: object) -> None:
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr(Path, "open", denied)
    with pytest.raises(ImageError, match=r"a\.nii\.gz cannot be read: Permission denied; see to its perm"):
        read_scan(path)


def test_what_is_told_of_a_folder_reaches_its_series(tmp_path: Path) -> None:
    def uneven(k: int, dataset: Dataset) -> None:
        dataset.ImagePositionPatient = place(k + 0.3 * (k == 2))

    folder = write(tmp_path, uneven)
    with pytest.raises(ImageError, match="no series matches"):
        read_scan(folder, series="6")
    with pytest.raises(ImageError, match="uneven gaps"):
        read_scan(folder)
    assert "interpolated" in read_scan(folder, gaps="resample").notes[0]
