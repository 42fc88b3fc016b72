"""A DICOM segmentation becomes one label array on the grid of its series, with the names of its segments."""

import shutil
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from dicom_series import GRID, enhanced, item, place, save, slice_of, uid
from pydicom import Dataset
from pydicom.pixels import pack_bits
from pydicom.uid import UID

from mammosim.core.errors import ImageError
from mammosim.core.labels import Label
from mammosim.io.dicom_files import dicom_files
from mammosim.io.dicom_segmentation import holds_seg, read_seg
from mammosim.io.label_maps import read_label_map, tissue_map

STORAGE = UID("1.2.840.10008.5.1.4.1.1.66.4")
BREAST = np.zeros(GRID.shape, bool)
BREAST[1:5, 1:4] = True
GLAND = np.zeros(GRID.shape, bool)
GLAND[2:4, 2] = True
NAMES = {1: "breast", 2: "fibroglandular"}


def _seg(masks: Mapping[int, np.ndarray], names: Mapping[int, str] = NAMES) -> Dataset:
    """Binary, without the frames that are empty."""
    dataset = enhanced()
    dataset.SOPClassUID = dataset.file_meta.MediaStorageSOPClassUID = STORAGE
    dataset.SOPInstanceUID = dataset.file_meta.MediaStorageSOPInstanceUID = uid("seg")
    del dataset.PatientPosition
    dataset.SegmentationType, dataset.Modality = "BINARY", "SEG"
    dataset.BitsAllocated = dataset.BitsStored = 1
    dataset.HighBit = 0
    dataset.SegmentSequence = [
        item(SegmentNumber=number, SegmentLabel=name) for number, name in names.items()
    ]
    frames = [(number, k) for number, mask in masks.items() for k in range(len(mask)) if mask[k].any()]
    dataset.NumberOfFrames = len(frames)
    dataset.PerFrameFunctionalGroupsSequence = [
        item(
            PlanePositionSequence=item(ImagePositionPatient=place(k)),
            SegmentIdentificationSequence=item(ReferencedSegmentNumber=number),
        )
        for number, k in frames
    ]
    bits = np.concatenate([masks[number][k].ravel() for number, k in frames]).astype(np.uint8)
    dataset.PixelData = pack_bits(bits)
    dataset["PixelData"].VR = "OB"
    return dataset


def _fractional(dataset: Dataset, masks: Mapping[int, np.ndarray]) -> Dataset:
    dataset.SegmentationType, dataset.MaximumFractionalValue = "FRACTIONAL", 100
    dataset.BitsAllocated = dataset.BitsStored = 8
    dataset.HighBit = 7
    frames = [mask[k] for mask in masks.values() for k in range(len(mask)) if mask[k].any()]
    dataset.PixelData = np.where(frames, 50, 49).astype(np.uint8).tobytes()
    return dataset


def test_segments_are_numbers_on_the_grid_of_the_slices_they_are_in(tmp_path: Path) -> None:
    apart = BREAST & ~GLAND
    grid, labels, names, overlapping = read_seg(save(_seg({1: apart, 2: GLAND}), tmp_path / "a.dcm"))
    np.testing.assert_array_equal(labels, (apart + 2 * GLAND)[1:5])
    np.testing.assert_allclose(grid.origin, place(1), atol=1e-5)
    np.testing.assert_allclose(grid.spacing, GRID.spacing, atol=1e-5)
    np.testing.assert_allclose(grid.direction, GRID.direction, atol=1e-8)
    assert (names, overlapping) == (NAMES, 0)


@pytest.mark.parametrize("order", [(1, 2), (2, 1)])
def test_a_segment_within_another_is_kept(tmp_path: Path, order: tuple[int, int]) -> None:
    """Whichever of them comes first, in the file or by number."""
    masks = {order[0]: BREAST, order[1]: GLAND}
    _, labels, _, overlapping = read_seg(save(_seg(masks), tmp_path / "a.dcm"))
    assert overlapping == GLAND.sum()
    assert np.all(labels[GLAND[1:5]] == order[1])
    assert np.all(labels[(BREAST & ~GLAND)[1:5]] == order[0])


def test_frames_may_stand_in_any_order(tmp_path: Path) -> None:
    """The first one of the file is not the first slice."""
    grid, labels, *_ = read_seg(save(_seg({2: GLAND, 1: BREAST & ~GLAND}), tmp_path / "a.dcm"))
    np.testing.assert_array_equal(labels, ((BREAST & ~GLAND) + 2 * GLAND)[1:5])
    np.testing.assert_allclose(grid.origin, place(1), atol=1e-5)


def test_slices_thinner_than_their_distance_are_not_doubled(tmp_path: Path) -> None:
    dataset = _seg({1: BREAST})
    dataset.SharedFunctionalGroupsSequence[0].PixelMeasuresSequence[0].SliceThickness = 1.5
    grid, labels, *_ = read_seg(save(dataset, tmp_path / "a.dcm"))
    np.testing.assert_array_equal(labels, BREAST[1:5])
    assert grid.spacing[2] == pytest.approx(GRID.spacing[2], abs=1e-5)


def test_names_of_segments_say_what_tissues_they_are(tmp_path: Path) -> None:
    found = tissue_map(
        read_label_map(
            save(_seg({2: BREAST & ~GLAND, 1: GLAND}, {1: "fibroglandular", 2: "fat"}), tmp_path / "a.dcm")
        )
    )
    assert np.all(found.values[GLAND[1:5]] == Label.GLANDULAR)
    assert np.all(found.values[(BREAST & ~GLAND)[1:5]] == Label.ADIPOSE)


def test_slices_that_no_segment_touches_are_empty(tmp_path: Path) -> None:
    mask = np.zeros(GRID.shape, bool)
    mask[[0, 1, 5]] = True
    _, labels, *_ = read_seg(save(_seg({1: mask}), tmp_path / "a.dcm"))
    np.testing.assert_array_equal(labels[:, 0, 0], [1, 1, 0, 0, 0, 1])


def test_fractions_are_inside_from_one_half(tmp_path: Path) -> None:
    dataset = _fractional(_seg({1: BREAST}), {1: BREAST})
    _, labels, *_ = read_seg(save(dataset, tmp_path / "a.dcm"))
    np.testing.assert_array_equal(labels, BREAST[1:5])


def _label_map(stored: np.ndarray) -> Dataset:
    dataset = enhanced()
    dataset.SOPClassUID = dataset.file_meta.MediaStorageSOPClassUID = UID("1.2.840.10008.5.1.4.1.1.66.7")
    dataset.SegmentationType = "LABELMAP"
    dataset.SegmentSequence = [item(SegmentNumber=n, SegmentLabel=name) for n, name in NAMES.items()]
    dataset.PixelData = stored.astype(np.uint16).tobytes()
    return dataset


def test_a_label_map_with_a_number_that_it_does_not_name_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(ImageError, match=r"a\.dcm has frames of segment 3, which it does not name"):
        read_seg(save(_label_map(BREAST + 2 * GLAND), tmp_path / "a.dcm"))


def test_a_label_map_of_segments_is_read(tmp_path: Path) -> None:
    stored = BREAST + GLAND.astype(np.uint16)
    grid, labels, *_ = read_seg(save(_label_map(stored), tmp_path / "a.dcm"))
    np.testing.assert_array_equal(labels, stored)
    assert grid.same_as(GRID)


def test_a_name_may_stand_in_the_code_of_a_segment(tmp_path: Path) -> None:
    dataset = _seg({1: BREAST}, {1: ""})
    dataset.SegmentSequence[0].SegmentedPropertyTypeCodeSequence = [item(CodeMeaning="Breast")]
    assert read_seg(save(dataset, tmp_path / "a.dcm"))[2] == {1: "Breast"}


def test_the_segmentation_is_found_beside_the_slices(tmp_path: Path) -> None:
    for k in range(6):
        save(slice_of(k), tmp_path / f"{k}.dcm")
    file = save(_seg({1: BREAST}), tmp_path / "seg.dcm")
    assert read_seg(tmp_path)[1].any()
    for path, there in ((file, True), (tmp_path / "0.dcm", False), (tmp_path, True)):
        with dicom_files(path) as files:
            assert holds_seg(files, str(path)) is there
    save(_seg({1: GLAND}), tmp_path / "seg2.dcm")
    with pytest.raises(
        ImageError, match=r"has 2 DICOM segmentations, seg\.dcm, seg2\.dcm; give the file of one"
    ):
        read_seg(tmp_path)


@pytest.mark.parametrize("packed", [False, True])
def test_a_folder_or_zip_of_slices_with_a_segmentation_is_a_label_map(tmp_path: Path, packed: bool) -> None:
    folder = tmp_path / "export"
    folder.mkdir()
    for k in range(3):
        save(slice_of(k), folder / f"{k}.dcm")
    file = save(_seg({1: BREAST, 2: GLAND}), folder / "seg.dcm")
    given = Path(shutil.make_archive(str(folder), "zip", folder)) if packed else folder
    found = read_label_map(given)
    np.testing.assert_array_equal(found.codes, read_label_map(file).codes)
    assert (found.path, found.names) == (str(given), NAMES)


def test_a_folder_of_slices_alone_is_no_label_map(tmp_path: Path) -> None:
    save(slice_of(0), tmp_path / "0.dcm")
    with pytest.raises(ImageError, match="holds no label map; give a DICOM segmentation, or one of"):
        read_label_map(tmp_path)


def _unnamed(dataset: Dataset) -> None:
    dataset.SegmentSequence = dataset.SegmentSequence[:1]


def _nameless(dataset: Dataset) -> None:
    del dataset.SegmentSequence


def _between(dataset: Dataset) -> None:
    group = dataset.PerFrameFunctionalGroupsSequence[1]
    group.PlanePositionSequence[0].ImagePositionPatient = place(2.4)


def _turned(dataset: Dataset) -> None:
    orientation = item(ImageOrientationPatient=[0, 1, 0, 0, 0, -1])
    dataset.PerFrameFunctionalGroupsSequence[1].PlaneOrientationSequence = [orientation]


def _without_segment(dataset: Dataset) -> None:
    del dataset.PerFrameFunctionalGroupsSequence[1].SegmentIdentificationSequence


def _short(dataset: Dataset) -> None:
    dataset.PixelData = dataset.PixelData[:4]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (_unnamed, r"a\.dcm has frames of segment 2, which it does not name"),
        (_nameless, r"a\.dcm names no segments"),
        (_between, r"a\.dcm, frame \d.* mm off slices of"),
        (_turned, r"a\.dcm, frame \d is turned against the others"),
        (_without_segment, r"a\.dcm, frame 2 has no ReferencedSegmentNumber"),
        (_short, r"a\.dcm is cut short"),
    ],
)
def test_a_segmentation_that_is_none_is_named(tmp_path: Path, change: object, message: str) -> None:
    dataset = _seg({1: BREAST, 2: GLAND})
    change(dataset)  # type: ignore[operator]
    with pytest.raises(ImageError, match=message):
        read_seg(save(dataset, tmp_path / "a.dcm"))


def test_what_holds_no_segmentation_is_named(tmp_path: Path) -> None:
    with pytest.raises(ImageError, match=r"a\.dcm has 0 DICOM segmentations; give the file of one"):
        read_seg(save(slice_of(0), tmp_path / "a.dcm"))
