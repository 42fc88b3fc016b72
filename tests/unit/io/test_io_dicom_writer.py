"""A written series is read back with the same geometry and intensities, and is written the same each time."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pydicom
import pytest
import SimpleITK as sitk

from mammosim.core.errors import ConfigurationError, ImageError
from mammosim.core.rigid import rotation
from mammosim.core.volume import Grid, Image
from mammosim.io.dicom import read_series
from mammosim.io.dicom_writer import write_series

GRID = Grid(
    (5, 7, 9),
    np.array([0.5, 0.7, 0.6]),
    np.array([-17.123, 3.0, -8.0]),
    rotation(np.array([2.0, -1.0, 3.0])),
)
IMAGE = Image(GRID, np.random.default_rng(0).uniform(0, 3000, GRID.shape).astype(np.float32))


def write(folder: Path, image: Image = IMAGE, position: str = "prone", volunteer: str = "small") -> Path:
    write_series(
        folder, image, position=position, volunteer=volunteer, echo_time_ms=70.0, repetition_time_ms=4500.0
    )
    return folder


def test_geometry_and_intensities_survive(tmp_path):
    series = read_series(write(tmp_path / "series"))
    assert series.position == "prone"
    assert series.image.grid.same_as(GRID)
    np.testing.assert_allclose(series.image.values, IMAGE.values, atol=0.5001)  # rounded to whole numbers


def test_another_reader_finds_the_same_geometry(tmp_path):
    folder = write(tmp_path / "series")
    reader = sitk.ImageSeriesReader()
    reader.SetFileNames(reader.GetGDCMSeriesFileNames(str(folder)))
    read = reader.Execute()
    np.testing.assert_allclose(read.GetOrigin(), GRID.origin, atol=1e-3)
    np.testing.assert_allclose(read.GetSpacing(), GRID.spacing, atol=1e-3)
    np.testing.assert_allclose(np.reshape(read.GetDirection(), (3, 3)), GRID.direction, atol=1e-6)


def test_the_same_image_gives_the_same_bytes(tmp_path):
    one, two = (write(tmp_path / name) for name in "ab")
    names = sorted(path.name for path in one.iterdir())
    assert names == sorted(path.name for path in two.iterdir())
    assert all((one / name).read_bytes() == (two / name).read_bytes() for name in names)


def test_identifiers_separate_slices_positions_and_women(tmp_path):
    def identifiers(position: str, volunteer: str) -> tuple[set, set, set]:
        folder = write(tmp_path / f"{volunteer}_{position}", position=position, volunteer=volunteer)
        read = [pydicom.dcmread(path) for path in folder.iterdir()]
        return tuple(
            {d[key].value for d in read}
            for key in ("SOPInstanceUID", "SeriesInstanceUID", "StudyInstanceUID")
        )

    one, two, other = (
        identifiers("prone", "small"),
        identifiers("supine", "small"),
        identifiers("prone", "large"),
    )
    assert (len(one[0]), len(one[1]), len(one[2])) == (5, 1, 1)
    assert one[0].isdisjoint(two[0] | other[0])
    assert one[1] != two[1]
    assert one[2] == two[2] != other[2]


@pytest.mark.parametrize(
    ("position", "code"), [("prone", "HFP"), ("supine", "HFS"), ("supine_tilted", "HFS")]
)
def test_the_position_is_in_the_tags(tmp_path, position, code):
    dataset = pydicom.dcmread(write(tmp_path / position, position=position) / "slice_001.dcm")
    assert dataset.PatientPosition == code
    assert dataset.SeriesDescription.endswith(position)
    assert (dataset.EchoTime, dataset.RepetitionTime, dataset.SpacingBetweenSlices) == (70, 4500, 0.6)


def test_a_position_that_no_scanner_takes_is_rejected(tmp_path):
    with pytest.raises(ConfigurationError, match="upright"):
        write(tmp_path / "series", position="upright")


def test_intensities_beyond_16_bits_are_rejected_and_the_earlier_series_stays(tmp_path):
    folder = write(tmp_path / "series")
    with pytest.raises(ImageError, match="65535"):
        write(folder, replace(IMAGE, values=IMAGE.values * 100))
    assert len(list(folder.iterdir())) == 5
