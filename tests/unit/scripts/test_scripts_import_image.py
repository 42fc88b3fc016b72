"""The series that is meant becomes the image of a position, and what was done beside reading it is logged."""

import numpy as np
from dicom_series import VALUES, place, write
from pydicom import Dataset

from mammosim.io.images import read_image


def test_the_named_series_is_read_as_asked_and_its_notes_are_logged(script, tmp_path, caplog):
    def uneven(k: int, dataset: Dataset) -> None:
        dataset.ImagePositionPatient = place(k + 0.3 * (k == 2))

    def other(k: int, dataset: Dataset) -> None:
        dataset.SeriesInstanceUID, dataset.SOPInstanceUID, dataset.SeriesNumber = "1.2.3", f"1.2.3.{k}", 7

    folder = write(tmp_path / "both" / "a", uneven).parent
    write(folder / "b", other)
    with caplog.at_level("INFO"):
        script("import_image").main(
            str(folder), {"series": "5", "gaps": "resample"}, str(tmp_path / "prone.nii.gz")
        )
    (line,) = caplog.messages
    assert line.startswith(f"{folder}: slices ")
    assert "interpolated onto an even grid" in line
    np.testing.assert_array_equal(read_image(tmp_path / "prone.nii.gz").values[0], VALUES[0])
