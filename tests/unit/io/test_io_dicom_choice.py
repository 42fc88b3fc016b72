"""Of several series, phases and copies in a folder the one that is meant, or a list without a name in it."""

import re
from pathlib import Path

import numpy as np
import pytest
from dicom_series import GRID, VALUES, Change, enhanced, place, save, slice_of, uid, write
from pydicom import Dataset
from pydicom.uid import EnhancedSRStorage, SecondaryCaptureImageStorage

from mammosim.core.errors import ImageError
from mammosim.io.dicom import read_series


def _series(number: int | None, description: str, scale: int = 1) -> Change:
    def change(k: int, dataset: Dataset) -> None:
        dataset.SeriesInstanceUID, dataset.SOPInstanceUID = uid("series", number), uid(number, k)
        dataset.SeriesNumber, dataset.SeriesDescription = number, description
        dataset.PixelData = (VALUES[k] * scale).tobytes()

    return change


def _scale(folder: Path, series: str) -> float:
    """The series of a scale that was read."""
    return float(np.median(read_series(folder, series=series).image.values[VALUES > 0] / VALUES[VALUES > 0]))


def _two(folder: Path) -> Path:
    write(folder / "t1", _series(3, "T1 fs Dent Mavis 1961", 2))
    return write(folder / "t2", _series(12, "T2 TSE prone", 3)).parent


def test_one_of_several_series_is_named_by_number_uid_or_words(tmp_path: Path) -> None:
    folder = _two(tmp_path)
    assert [_scale(folder, name) for name in ("3", "12", "t2 tse", "mavis", uid("series", 12))] == [
        2,
        3,
        3,
        2,
        3,
    ]


@pytest.mark.parametrize("series", ["", "4", "t", "phase 2"])
def test_several_series_are_offered_without_a_name(tmp_path: Path, series: str) -> None:
    with pytest.raises(ImageError) as raised:
        read_series(_two(tmp_path), series=series)
    text = str(raised.value)
    assert "3: MR, 6 slices of 5 x 4, 1.25 x 1.50 mm, T1, FS; 12: MR, 6 slices of 5 x 4" in text
    assert "column `series`" in text
    assert not any(word in text for word in ("Dent", "DENT", "Mavis", "1961", "\n"))


def test_series_of_one_number_are_offered_by_uid(tmp_path: Path) -> None:
    write(tmp_path / "a", _series(3, "one"))
    write(tmp_path / "b", lambda k, d: (_series(4, "two")(k, d), setattr(d, "SeriesNumber", 3)))  # type: ignore[func-returns-value]
    with pytest.raises(ImageError, match=f"{uid('series', 3)}: MR.*; {uid('series', 4)}: MR"):
        read_series(tmp_path)


def _localiser(k: int, dataset: Dataset) -> None:
    _series(1, "loc 3 planes")(k, dataset)
    turned = ([1, 0, 0, 0, 0, -1], [0, 1, 0, 0, 0, -1], [1, 0, 0, 0, 1, 0])
    dataset.ImageOrientationPatient = turned[k % 3]


def _capture(k: int, dataset: Dataset) -> None:
    _series(99, "screen of Dent")(k, dataset)
    dataset.SOPClassUID = dataset.file_meta.MediaStorageSOPClassUID = SecondaryCaptureImageStorage
    del dataset.ImagePositionPatient


def _report(k: int, dataset: Dataset) -> None:
    _series(98, "report")(k, dataset)
    dataset.SOPClassUID = dataset.file_meta.MediaStorageSOPClassUID = EnhancedSRStorage
    del dataset.PixelData, dataset.Rows


def test_what_is_no_volume_is_left_out(tmp_path: Path) -> None:
    write(tmp_path / "b")
    write(tmp_path / "a", _localiser)
    write(tmp_path / "c", _capture, slices=[2])
    write(tmp_path / "d", _report, slices=[2])
    series = read_series(tmp_path)
    np.testing.assert_array_equal(series.image.values, VALUES)
    first, second = series.notes
    assert first.startswith("localiser left out (1: MR, 6 slices of 5 x 4")
    assert second.startswith("pictures without a place left out (99: MR, 1 slice")


def test_one_slice_that_may_belong_to_the_series_is_not_left_out(tmp_path: Path) -> None:
    write(tmp_path / "a", slices=range(5))
    write(tmp_path / "b", _series(6, "T2 prone"), slices=[5])
    with pytest.raises(ImageError, match="mixes 2 series"):
        read_series(tmp_path)


def _phase(n: int, **tags: object) -> Change:
    def change(k: int, dataset: Dataset) -> None:
        dataset.SOPInstanceUID, dataset.InstanceNumber = uid(n, k), 6 * n + k + 1
        dataset.PixelData = (VALUES[k] * n).tobytes()
        for keyword, value in tags.items():
            setattr(dataset, keyword, value(k) if callable(value) else value)

    return change


@pytest.mark.parametrize(
    ("keyword", "values", "told"),
    [
        ("AcquisitionNumber", (2, 10), " (1: 2, 2: 10)"),
        ("TemporalPositionIdentifier", (1, 2), " (1: 1, 2: 2)"),
        ("EchoNumbers", (1, 2), " (1: 1, 2: 2)"),
        ("EchoTime", (9.5, 102), " (1: 9.5, 2: 102)"),
        ("TriggerTime", (0, 900), " (1: 0, 2: 900)"),
        ("ImageType", (["ORIGINAL", "PRIMARY", "M"], ["ORIGINAL", "PRIMARY", "P"]), " (1: M, 2: P)"),
        ("ImageType", (["ORIGINAL", "PRIMARY", "DENT"], ["ORIGINAL", "PRIMARY", "MAVIS"]), ""),
        ("ContentTime", (lambda k: f"1015{k:02d}", lambda k: f"1016{k:02d}"), ""),
    ],
)
def test_phases_are_told_apart_by(
    tmp_path: Path, keyword: str, values: tuple[object, object], told: str
) -> None:
    for n, value in enumerate(values, 1):
        write(tmp_path / str(9 - n), _phase(n, **{keyword: value}))
    with pytest.raises(
        ImageError,
        match=re.escape(f"holds 2 volumes of 6 slices, told apart by {keyword}{told}; write 'phase N'"),
    ):
        read_series(tmp_path)
    assert [_scale(tmp_path, f"phase {n}") for n in (1, 2)] == [1, 2]
    assert _scale(tmp_path, "5 phase 2") == 2
    with pytest.raises(ImageError, match="with N from 1 to 2"):
        read_series(tmp_path, series="phase 3")


def test_echoes_of_phases_are_told_apart(tmp_path: Path) -> None:
    for n in range(1, 5):
        write(tmp_path / str(n), _phase(n, AcquisitionNumber=(n + 1) // 2, EchoTime=(n + 1) % 2 + 1))
    assert [_scale(tmp_path, f"phase {n}") for n in (1, 2, 3, 4)] == [1, 2, 3, 4]


def test_phases_of_an_enhanced_file_are_told_apart(tmp_path: Path) -> None:
    dataset = enhanced([0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5])
    for k, group in enumerate(dataset.PerFrameFunctionalGroupsSequence):
        content = Dataset()
        content.TemporalPositionIndex = k % 2 + 1
        group.FrameContentSequence = [content]
    dataset.PixelData = np.stack([VALUES[k // 2] * (k % 2 + 1) for k in range(12)]).tobytes()
    save(dataset, tmp_path / "all.dcm")
    assert [_scale(tmp_path, f"phase {n}") for n in (1, 2)] == [1, 2]


def test_a_phase_that_lost_a_slice_is_rejected_when_it_is_named(tmp_path: Path) -> None:
    write(tmp_path / "1", _phase(1, AcquisitionNumber=1))
    write(tmp_path / "2", _phase(2, AcquisitionNumber=2), slices=(0, 1, 2, 4, 5))
    assert _scale(tmp_path, "phase 1") == 1
    told = read_series(tmp_path, series="phase 1").chosen
    assert re.fullmatch(r".*: MR, 11 slices of .*, phase 1 of 2; 1 of 1 series of the folder or file", told)
    with pytest.raises(ImageError, match=r"lacks a slice: between 2/7\.dcm and 2/5\.dcm"):
        read_series(tmp_path, series="phase 2")


def test_repetitions_that_nothing_tells_apart_are_rejected(tmp_path: Path) -> None:
    for n in (1, 2):
        write(tmp_path / str(n), _phase(n))
    with pytest.raises(ImageError, match=r"two slices in one place, .* \(6 such pairs\), and no tag tells"):
        read_series(tmp_path)


def test_a_copy_of_a_slice_is_left_out(tmp_path: Path) -> None:
    write(tmp_path)
    save(slice_of(2), tmp_path / "copy.dcm")
    series = read_series(tmp_path)
    np.testing.assert_array_equal(series.image.values, VALUES)
    assert series.notes == ("copy.dcm left out, a copy of 7.dcm",)


def test_a_copy_that_differs_is_rejected(tmp_path: Path) -> None:
    write(tmp_path)
    other = slice_of(2)
    other.PixelData = VALUES[3].tobytes()
    save(other, tmp_path / "copy.dcm")
    with pytest.raises(ImageError, match=r"7\.dcm and copy\.dcm have one SOPInstanceUID and differ"):
        read_series(tmp_path)


def test_slices_of_one_identifier_are_told_apart_by_their_places(tmp_path: Path) -> None:
    """As some programs that take names out leave them."""

    def one(k: int, dataset: Dataset) -> None:
        dataset.SOPInstanceUID = uid("one")

    np.testing.assert_array_equal(read_series(write(tmp_path, one)).image.values, VALUES)


def test_a_localiser_of_the_same_series_is_named(tmp_path: Path) -> None:
    write(tmp_path)
    other = slice_of(0)
    other.SOPInstanceUID, other.ImageOrientationPatient = uid("other"), [0, 1, 0, 0, 0, -1]
    other.ImagePositionPatient = (np.array(place(0)) + GRID.spacing).tolist()
    save(other, tmp_path / "scout.dcm")
    with pytest.raises(ImageError, match=r"scout\.dcm: its ImageOrientationPatient .*take out localizers"):
        read_series(tmp_path)


def test_a_phase_whose_slices_are_numbered_between_those_of_another_is_whole(tmp_path: Path) -> None:
    for n in (1, 2):
        write(
            tmp_path / str(n),
            _phase(n, EchoTime=n, InstanceNumber=lambda k, n=n: 2 * k + n, SliceThickness=1.0),
        )
    assert [_scale(tmp_path, f"phase {n}") for n in (1, 2)] == [1, 2]


def test_a_name_that_is_a_word_of_the_technique_is_not_shown(tmp_path: Path) -> None:
    folder = _two(tmp_path)
    write(
        folder / "t3", lambda k, d: (_series(4, "T1 sag prone")(k, d), setattr(d, "PatientName", "Sag^Mavis"))
    )  # type: ignore[func-returns-value]
    with pytest.raises(ImageError, match=r"mm, T1, PRONE; 12: MR"):
        read_series(folder)


def test_a_description_may_end_as_a_phase_does(tmp_path: Path) -> None:
    for n in (1, 2):
        write(tmp_path / str(n), _series(n, f"dyn phase {n}", n))
    assert [_scale(tmp_path, f"dyn phase {n}") for n in (1, 2)] == [1, 2]


def _colour(k: int, dataset: Dataset) -> None:
    _series(97, "fused")(k, dataset)
    dataset.SamplesPerPixel, dataset.PhotometricInterpretation, dataset.PlanarConfiguration = 3, "RGB", 0
    dataset.PixelData = np.repeat(VALUES[k], 3).tobytes()


def test_colour_pictures_beside_a_series_are_left_out(tmp_path: Path) -> None:
    write(tmp_path / "a")
    write(tmp_path / "b", _colour)
    series = read_series(tmp_path)
    np.testing.assert_array_equal(series.image.values, VALUES)
    assert series.notes[0].startswith("colour pictures left out (97: MR, 6 slices")


def _clock(n: int) -> Change:
    return _phase(n, ContentTime=lambda k: f"10{14 + n}{k:02d}")


def test_times_tell_no_phases_apart_where_a_slice_is_lost(tmp_path: Path) -> None:
    """A later slice would take the place of the lost one."""
    write(tmp_path / "1", _clock(1), slices=(0, 1, 2, 4, 5))
    write(tmp_path / "2", _clock(2))
    for name in ("", "phase 1", "phase 2"):
        with pytest.raises(ImageError):
            read_series(tmp_path, series=name)


def test_a_tag_that_differs_from_slice_to_slice_tells_no_phases_apart(tmp_path: Path) -> None:
    for n in (1, 2):
        write(tmp_path / str(n), _phase(n, AcquisitionNumber=lambda k: k + 1, EchoTime=n))
    with pytest.raises(ImageError, match="holds 2 volumes of 6 slices, told apart by EchoTime"):
        read_series(tmp_path)
    assert [_scale(tmp_path, f"phase {n}") for n in (1, 2)] == [1, 2]
