"""A series becomes one volume in the patient frame, or one line that says which file is at fault."""

import fnmatch
import re
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest
from dicom_series import GRID, VALUES, Change, enhanced, place, save, slice_of, uid, write
from pydicom import Dataset

from mammosim.core.errors import ImageError
from mammosim.io.dicom import is_series, read_series

DATA = Path(__file__).parents[3].parent / "shared/data"


def test_a_tilted_series_keeps_its_place_and_intensities(tmp_path: Path) -> None:
    series = read_series(write(tmp_path))
    assert series.image.grid.same_as(GRID)
    np.testing.assert_array_equal(series.image.values, VALUES)
    assert (series.position, series.patient_position, series.volunteer) == ("prone", "HFP", "large")
    assert series.notes == ()


def test_spacing_follows_the_positions_not_the_slice_thickness(tmp_path: Path) -> None:
    def thin(k: int, dataset: Dataset) -> None:
        dataset.SliceThickness = "1.0"

    # Positions are written to 1e-6 mm.
    assert read_series(write(tmp_path, thin)).image.grid.spacing[2] == pytest.approx(3.0, abs=1e-5)


@pytest.mark.parametrize("order", [(0, 1, 2, 3, 4, 5), (5, 3, 1, 0, 2, 4)])
def test_an_enhanced_file_is_the_same_volume(tmp_path: Path, order: tuple[int, ...]) -> None:
    file = save(enhanced(order), tmp_path / "IM0001")
    (tmp_path / "note.txt").write_text("the technician's")
    for path in (tmp_path, file):
        series = read_series(path)
        assert series.image.grid.same_as(GRID)
        np.testing.assert_array_equal(series.image.values, VALUES)


def test_each_frame_has_a_slope_of_its_own(tmp_path: Path) -> None:
    dataset = enhanced()
    for k, group in enumerate(dataset.PerFrameFunctionalGroupsSequence):
        scale = Dataset()
        scale.RescaleSlope, scale.RescaleIntercept = k + 1, -k
        group.PixelValueTransformationSequence = [scale]
    series = read_series(save(dataset, tmp_path / "a.dcm"))
    k = np.arange(6)[:, None, None]
    np.testing.assert_array_equal(series.image.values, VALUES * (k + 1.0) - k)


def test_stored_values_are_rescaled(tmp_path: Path) -> None:
    def rescale(k: int, dataset: Dataset) -> None:
        dataset.RescaleSlope, dataset.RescaleIntercept = "2", "-10"

    np.testing.assert_array_equal(read_series(write(tmp_path, rescale)).image.values, 2.0 * VALUES - 10)


def test_an_empty_slope_is_one(tmp_path: Path) -> None:
    def empty(k: int, dataset: Dataset) -> None:
        dataset.RescaleSlope = dataset.RescaleIntercept = None

    np.testing.assert_array_equal(read_series(write(tmp_path, empty)).image.values, VALUES)


def test_monochrome1_is_inverted(tmp_path: Path) -> None:
    def inverse(k: int, dataset: Dataset) -> None:
        dataset.PhotometricInterpretation = "MONOCHROME1"
        dataset.PixelData = (4095 - VALUES[k]).astype(np.uint16).tobytes()

    series = read_series(write(tmp_path, inverse))
    np.testing.assert_array_equal(series.image.values, VALUES - VALUES.min())
    assert series.notes == ("MONOCHROME1: dark and bright exchanged",)


def test_slices_of_philips_are_on_one_scale(tmp_path: Path) -> None:
    """Its stored values S use the range of each slice; the signal is S / scale slope + a constant."""

    def philips(k: int, dataset: Dataset) -> None:
        slope, scale = 0.5 + 0.1 * k, 2.0 + k  # of the display, and of the signal
        dataset.RescaleSlope, dataset.RescaleIntercept = f"{slope:.2f}", "0"
        dataset.PixelData = (VALUES[k] * (2 + k)).astype(np.uint16).tobytes()
        dataset.private_block(0x2005, "Philips MR Imaging DD 001", create=True).add_new(0x0E, "FL", scale)

    series = read_series(write(tmp_path, philips))
    np.testing.assert_allclose(series.image.values, VALUES, rtol=1e-6)
    assert "private scale of Philips" in series.notes[0]
    otherwise = 0.5 * 2 / (1.0 * 7)  # slope times scale of the first slice, by that of the last one
    assert f"by up to a factor of {1 / otherwise:.3g}: check" in series.notes[0]


def test_an_intercept_of_philips_is_on_the_same_scale(tmp_path: Path) -> None:
    """The display P slope + intercept over slope times scale slope: here S + 3 in all slices."""

    def philips(k: int, dataset: Dataset) -> None:
        slope, scale = 0.5 + 0.1 * k, 2.0 + k
        dataset.RescaleSlope, dataset.RescaleIntercept = f"{slope:.2f}", f"{3 * slope * scale:.6f}"
        dataset.PixelData = (VALUES[k] * (2 + k)).astype(np.uint16).tobytes()
        dataset.private_block(0x2005, "Philips MR Imaging DD 001", create=True).add_new(0x0E, "FL", scale)

    np.testing.assert_allclose(read_series(write(tmp_path, philips)).image.values, VALUES + 3.0, rtol=1e-5)


def test_philips_whose_display_is_on_the_same_scale_needs_no_look(tmp_path: Path) -> None:
    def philips(k: int, dataset: Dataset) -> None:
        scale = 2.0**k
        dataset.RescaleSlope, dataset.RescaleIntercept = str(4 / scale), "0"
        dataset.PixelData = (VALUES[k] * scale).astype(np.uint16).tobytes()
        dataset.private_block(0x2005, "Philips MR Imaging DD 001", create=True).add_new(0x0E, "FL", scale)

    series = read_series(write(tmp_path, philips))
    np.testing.assert_array_equal(series.image.values, VALUES)
    assert series.notes == ("intensities on the private scale of Philips, the same for all slices",)


@pytest.mark.parametrize(
    ("padding", "limit", "inverse"), [(-32768, None, False), (30000, 32000, False), (32000, None, True)]
)
def test_what_was_not_scanned_is_air(tmp_path: Path, padding: int, limit: int | None, inverse: bool) -> None:
    """The corners of a slice, which a correction of the gradients leaves empty, have a value of their own."""

    def padded(k: int, dataset: Dataset) -> None:
        values = (4095 - VALUES[k] if inverse else VALUES[k]).astype(np.int16)
        values[:, 0], values[0, 0] = padding, padding if limit is None else limit
        dataset.PixelRepresentation, dataset.PixelData = 1, values.tobytes()
        dataset.PhotometricInterpretation = "MONOCHROME1" if inverse else "MONOCHROME2"
        dataset.PixelPaddingValue = padding
        if limit is not None:
            dataset.PixelPaddingRangeLimit = limit

    series = read_series(write(tmp_path, padded))
    scanned = VALUES[:, :, 1:].astype(float)
    darkest = scanned.min() if inverse else 0.0
    expected = np.concatenate([np.full_like(VALUES[:, :, :1], darkest, float), scanned], axis=2)
    np.testing.assert_array_equal(series.image.values, expected - darkest)
    assert any("PixelPaddingValue" in note for note in series.notes)


def test_padding_may_be_stated_without_its_sign(tmp_path: Path) -> None:
    """-2000 of 16 bits as 63536, by writers that take all values of padding as unsigned."""

    def padded(k: int, dataset: Dataset) -> None:
        values = VALUES[k].astype(np.int16)
        values[0, 0] = -2000
        dataset.PixelRepresentation, dataset.PixelData = 1, values.tobytes()
        dataset.add_new("PixelPaddingValue", "US", 63536)

    found = read_series(write(tmp_path, padded)).image.values
    assert np.all(found[:, 0, 0] == 0)
    np.testing.assert_array_equal(found[:, 1:], VALUES[:, 1:])


def test_bits_that_are_not_stored_do_not_count(tmp_path: Path) -> None:
    """12 bits of 16: old overlays lie in the others, and the sign is that of the twelfth."""

    def overlaid(k: int, dataset: Dataset) -> None:
        dataset.BitsStored, dataset.HighBit = 12, 11
        dataset.PixelData = (VALUES[k] | 0x8000).tobytes()

    def signed(k: int, dataset: Dataset) -> None:
        dataset.BitsStored, dataset.HighBit, dataset.PixelRepresentation = 12, 11, 1
        dataset.PixelData = ((VALUES[k].astype(int) - 500) & 0xFFF).astype(np.uint16).tobytes()
        dataset.RescaleSlope, dataset.RescaleIntercept = 1, 500

    for change in (overlaid, signed):
        series = read_series(write(tmp_path / change.__name__, change))
        np.testing.assert_array_equal(series.image.values, VALUES)


def test_without_the_scale_of_every_slice_philips_is_as_others(tmp_path: Path) -> None:
    def philips(k: int, dataset: Dataset) -> None:
        dataset.RescaleSlope = str(1 + k)
        if k != 2:
            dataset.private_block(0x2005, "Philips MR Imaging DD 001", create=True).add_new(0x0E, "FL", 2.0)

    series = read_series(write(tmp_path, philips))
    np.testing.assert_allclose(series.image.values, VALUES * (np.arange(6)[:, None, None] + 1.0))
    assert series.notes == ("RescaleSlope is 1 to 6: each slice has a scale of its own",)


def test_a_slice_off_its_place_moves_the_grid_to_the_middle_of_all(tmp_path: Path) -> None:
    def off(k: int, dataset: Dataset) -> None:
        dataset.ImagePositionPatient = place(k - 0.03 * (k == 0))

    grid = read_series(write(tmp_path, off)).image.grid
    assert not np.allclose(grid.origin, place(0), atol=1e-3)
    normal = GRID.direction[:, 2]
    beyond = [
        (grid.points(np.array([[k, 0.0, 0.0]]))[0] - place(k - 0.03 * (k == 0))) @ normal for k in range(6)
    ]
    assert np.mean(beyond) == pytest.approx(0, abs=1e-5)


def test_other_slopes_that_differ_are_told(tmp_path: Path) -> None:
    def slope(k: int, dataset: Dataset) -> None:
        dataset.RescaleSlope = str(1 + k)

    assert read_series(write(tmp_path, slope)).notes == (
        "RescaleSlope is 1 to 6: each slice has a scale of its own",
    )


def test_tags_of_pixels_that_are_left_out_have_their_usual_values(tmp_path: Path) -> None:
    def bare(k: int, dataset: Dataset) -> None:
        del dataset.SamplesPerPixel, dataset.PhotometricInterpretation, dataset.BitsStored, dataset.HighBit

    np.testing.assert_array_equal(read_series(write(tmp_path, bare)).image.values, VALUES)


def _set(keyword: str, value: object, only: int | None = None) -> Change:
    def change(k: int, dataset: Dataset) -> None:
        if only is None or k == only:
            setattr(dataset, keyword, value)

    return change


def _without(keyword: str, only: int) -> Change:
    def change(k: int, dataset: Dataset) -> None:
        if k == only:
            delattr(dataset, keyword)

    return change


def _moved(k: int, dataset: Dataset) -> None:
    if k == 3:
        dataset.ImagePositionPatient = (np.array(place(3)) + 25 * GRID.direction[:, 0]).round(6).tolist()


def _sheared(k: int, dataset: Dataset) -> None:
    x, y, z = dataset.ImagePositionPatient
    dataset.ImagePositionPatient = [x, y + k * 0.5, z]


def _nan(k: int, dataset: Dataset) -> None:
    if k == 1:
        dataset.FloatPixelData = np.full(GRID.shape[1:], np.nan, np.float32).tobytes()
        del dataset.PixelData
        dataset.BitsAllocated = 32


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (_without("PatientPosition", 2), r"1 of 6 slices have no PatientPosition tag \(0018,5100\)"),
        (_without("ImagePositionPatient", 5), r"4\.dcm has no ImagePositionPatient"),
        (_without("ImagePositionPatient", 0), r"9\.dcm has no ImagePositionPatient"),
        (_without("Rows", 2), r"7\.dcm has no Rows"),
        (_set("ImagePositionPatient", place(2), 3), r"two slices in one place, .*6\.dcm.*\(1 such pairs\)"),
        (
            _set("ImageOrientationPatient", [0, 1, 0, 0, 0, -1], 5),
            r"4\.dcm: its ImageOrientationPatient is 0 1 0 0 0 -1, .*\(1 of 6 differ\)",
        ),
        (_set("ImageOrientationPatient", [1, 0, 0, 1, 0, 0]), "no pair of perpendicular unit vectors"),
        (
            _set("PixelSpacing", [2.0, 2.0], 2),
            r"7\.dcm: its PixelSpacing is 2 2, that of other slices is 1.25 1.5",
        ),
        (_set("PixelSpacing", [0, 0]), r"4\.dcm: its PixelSpacing is 0 x 0 mm"),
        (_set("PixelSpacing", None, 4), r"5\.dcm has no PixelSpacing"),
        (_set("PixelSpacing", [0.00125, 0.0015]), r"4\.dcm: its PixelSpacing .* as if it were in metres"),
        (_set("RescaleSlope", 0), r"4\.dcm: its RescaleSlope is 0"),
        (_set("PatientPosition", "DENT", 1), r"8\.dcm: its PatientPosition is something else, that of other"),
        (_set("PixelRepresentation", None, 1), r"8\.dcm has no PixelRepresentation"),
        (_set("BitsAllocated", 12, 1), r"8\.dcm: its pixels do not fit its tags"),
        (_set("SamplesPerPixel", 3), r"4\.dcm is in colour \(SamplesPerPixel 3"),
        (_set("PhotometricInterpretation", "PALETTE COLOR", 1), r"8\.dcm is in colour"),
        (
            _set("PhotometricInterpretation", "MONOCHROME1", 1),
            r"8\.dcm: its PhotometricInterpretation is MONO",
        ),
        (_set("ImageType", ["ORIGINAL", "PRIMARY", "M", "MOSAIC"]), "is a mosaic of slices"),
        (_moved, r"6\.dcm is shifted by 25 mm in its plane beside the other slices \(1 of 6"),
        (_sheared, r"each slice is shifted by 0\.500 mm in its plane"),
        (_nan, r"8\.dcm has pixels that are not finite"),
    ],
)
def test_a_series_that_is_no_volume_is_rejected(tmp_path: Path, change: Change, message: str) -> None:
    with pytest.raises(ImageError, match=message) as raised:
        read_series(write(tmp_path, change))
    assert "\n" not in str(raised.value)
    assert not re.search("Dent|Mavis", str(raised.value))


def _at(*places: float) -> Change:
    def change(k: int, dataset: Dataset) -> None:
        dataset.ImagePositionPatient = place(places[k])

    return change


# Slices are 3 mm apart: in places 0, 1, 2 .. the unit is 3 mm.
@pytest.mark.parametrize(
    ("places", "message"),
    [
        (
            (0, 1, 2, 4, 5, 6),
            r"lacks a slice: between 7\.dcm and 6\.dcm the distance is 6\.000 mm, elsewhere 3",
        ),
        (
            (0, 1, 2, 3.65, 4.65, 5.65),
            r"uneven gaps: 3\.000 to 4\.950 mm, the largest between 7\.dcm and 6\.dcm",
        ),
        ((0, 1.1, 2, 3.1, 4, 5.1), r"uneven gaps: 2\.700 to 3\.300 mm"),
        ((0, 1.02, 2.06, 3.12, 4.20, 5.30), "uneven gaps: .* mm off an even grid"),
    ],
)
def test_lost_and_uneven_slices_are_told_apart(
    tmp_path: Path, places: tuple[float, ...], message: str
) -> None:
    with pytest.raises(ImageError, match=message):
        read_series(write(tmp_path, _at(*places)))


def test_small_jitter_is_accepted_and_told(tmp_path: Path) -> None:
    series = read_series(write(tmp_path, _at(0, 1.01, 2, 3.01, 4, 5.01)))  # 0.03 mm to and fro
    assert series.image.grid.spacing[2] == pytest.approx(3.0, abs=0.01)
    assert re.fullmatch(r"slices are up to 0\.0\d\d mm off an even grid of 3\.00\d mm", series.notes[0])


def test_uneven_slices_are_interpolated_when_asked(tmp_path: Path) -> None:
    """Values linear along the normal stay so: each slice has its place as value."""
    places = (0, 1, 2, 3.6, 4.6, 5.6)

    def change(k: int, dataset: Dataset) -> None:
        dataset.ImagePositionPatient = place(places[k])
        dataset.PixelData = np.full(GRID.shape[1:], 100 * places[k]).round().astype(np.uint16).tobytes()

    image = read_series(write(tmp_path, change), gaps="resample").image
    assert image.grid.spacing[2] == pytest.approx(5.6 * 3 / (len(image.values) - 1))
    np.testing.assert_allclose(image.grid.origin, GRID.origin, atol=1e-5)
    expected = np.arange(len(image.values)) * image.grid.spacing[2] / 3 * 100
    np.testing.assert_allclose(image.values[:, 0, 0], expected, rtol=1e-5)


def test_an_even_series_is_not_touched_when_asked_to_interpolate(tmp_path: Path) -> None:
    np.testing.assert_array_equal(read_series(write(tmp_path), gaps="resample").image.values, VALUES)


def test_a_lost_slice_is_not_interpolated(tmp_path: Path) -> None:
    with pytest.raises(ImageError, match="lacks a slice"):
        read_series(write(tmp_path, _at(0, 1, 2, 4, 5, 6)), gaps="resample")


def test_another_word_for_gaps_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(ImageError, match="gaps = 'yes'; write 'resample', or nothing"):
        read_series(write(tmp_path), gaps="yes")


def test_every_second_slice_is_not_the_whole_series(tmp_path: Path) -> None:
    message = (
        r"lacks slices throughout: they are 6\.00 mm apart at a SliceThickness of 3\.00 mm.* 1, 3, 5 \.\."
    )
    with pytest.raises(ImageError, match=message):
        read_series(write(tmp_path, slices=(0, 2, 4)))


def test_a_gap_between_thin_slices_is_a_series(tmp_path: Path) -> None:
    """Slices of a 2-D sequence may be thinner than they are apart: no number is lost."""
    read_series(write(tmp_path, _set("SliceThickness", "1.2")))


def test_two_sagittal_stacks_are_told_from_lost_slices(tmp_path: Path) -> None:
    def stacks(k: int, dataset: Dataset) -> None:
        dataset.ImagePositionPatient = place(k if k < 4 else k + 3)

    folder = tmp_path / "stacks"
    folder.mkdir()
    for k in range(8):
        dataset = slice_of(0)
        dataset.SOPInstanceUID, dataset.InstanceNumber = uid("slice", k), k + 1
        stacks(k, dataset)
        save(dataset, folder / f"{k}.dcm")
    with pytest.raises(
        ImageError, match=r"two stacks, of 4 and 4 slices, with 12\.00 mm between 3\.dcm and 4\.dcm"
    ):
        read_series(folder)


def test_a_folder_without_dicom_is_rejected(tmp_path: Path) -> None:
    (tmp_path / "readme.txt").write_text("no DICOM here")
    with pytest.raises(ImageError, match=r"has 0 DICOM slices.*at least 2"):
        read_series(tmp_path)
    with pytest.raises(ImageError, match=r"no folder .*absent; give the folder"):
        read_series(tmp_path / "absent")


def test_one_slice_is_no_volume(tmp_path: Path) -> None:
    file = write(tmp_path) / "5.dcm"
    with pytest.raises(
        ImageError, match=r"5\.dcm has 1 DICOM slice .* give the folder that holds all of them"
    ):
        read_series(file)


def test_what_is_read_as_a_series(tmp_path: Path) -> None:
    file = write(tmp_path) / "5.dcm"
    bare = file.rename(tmp_path / "IM5")
    (tmp_path / "a.nii").write_bytes(struct.pack("<i", 348) + bytes(400))
    read = {path.name: is_series(path) for path in (tmp_path, bare, tmp_path / "b.zip", tmp_path / "a.nii")}
    assert read == {tmp_path.name: True, "IM5": True, "b.zip": True, "a.nii": False}


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
    """From its folder, and from the zip itself."""
    image = read_series(_unzip("haste_torso_dicom.zip", tmp_path)).image
    # The SliceThickness tag says 7 mm; the slices stand 8.75 mm apart along y.
    np.testing.assert_allclose(image.grid.spacing, [1.5625, 8.75, 1.5625], atol=1e-4)
    assert image.grid.shape == (256, 30, 256)
    zipped = read_series(DATA / "haste_torso_dicom.zip").image
    assert zipped.grid.same_as(image.grid)
    np.testing.assert_array_equal(zipped.values, image.values)


@pytest.mark.data
def test_a_real_series_without_one_slice_is_rejected(tmp_path: Path) -> None:
    folder = _unzip("haste_torso_dicom.zip", tmp_path)
    sorted(folder.rglob("*.dcm"))[12].unlink()
    with pytest.raises(ImageError, match=r"lacks a slice: between .* the distance is 17\.500 mm"):
        read_series(folder)
