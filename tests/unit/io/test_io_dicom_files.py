"""Series in folders and zips, and files of them that are damaged."""

import io
import os
import re
import shutil
import zipfile
from pathlib import Path

import numpy as np
import pytest
from dicom_series import VALUES, enhanced, save, uid, write
from pydicom.uid import EnhancedSRStorage

from mammosim.core.errors import ImageError
from mammosim.io.dicom import read_series


def _zip(folder: Path, path: Path, *, inside: str = "") -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(folder.iterdir()):
            archive.write(file, f"{inside}{file.name}")
    return path


def test_what_a_system_leaves_in_a_folder_is_not_read(tmp_path: Path) -> None:
    folder = write(tmp_path / "a")
    for name in (".DS_Store", "._9.dcm", "Thumbs.db", "Desktop.ini", "@eaDir/9.dcm"):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(b"\0\5\26\7")
    np.testing.assert_array_equal(read_series(folder).image.values, VALUES)


@pytest.mark.parametrize("inside", ["", "study/series 3/"])
def test_a_zip_is_read_as_its_folder(tmp_path: Path, inside: str) -> None:
    path = _zip(write(tmp_path / "a"), tmp_path / "a.zip", inside=inside)
    with zipfile.ZipFile(path, "a") as archive:  # as a Mac packs it
        archive.writestr(f"__MACOSX/{inside}._9.dcm", b"\0\5\26\7")
        archive.writestr(f"{inside}.DS_Store", b"Bud1")
        archive.writestr("README", "from the clinic")
    zipped, folder = read_series(path).image, read_series(tmp_path / "a").image
    assert zipped.grid.same_as(folder.grid)
    np.testing.assert_array_equal(zipped.values, folder.values)


def test_a_zip_in_a_folder_and_in_a_zip_is_read(tmp_path: Path) -> None:
    inner = _zip(write(tmp_path / "a"), tmp_path / "inner.zip")
    outer = tmp_path / "b"
    outer.mkdir()
    _zip_one(inner, outer / "outer.zip")
    np.testing.assert_array_equal(read_series(outer).image.values, VALUES)


def _zip_one(file: Path, path: Path) -> None:
    with zipfile.ZipFile(path, "w") as archive:
        archive.write(file, file.name)


def test_names_in_another_encoding_are_read_and_can_be_written(tmp_path: Path) -> None:
    folder = write(tmp_path / "a")
    for file in sorted(folder.iterdir()):
        os.rename(file, os.path.join(os.fsencode(folder), b"br\xfcst" + os.fsencode(file.name)))
    np.testing.assert_array_equal(read_series(folder).image.values, VALUES)
    cut = os.path.join(os.fsencode(folder), b"br\xfcst6.dcm")
    os.truncate(cut, 600)
    with pytest.raises(ImageError, match=r"br.st6\.dcm is cut short") as caught:
        read_series(folder)
    str(caught.value).encode("utf-8")


@pytest.mark.parametrize("packed", [False, True])
def test_an_image_file_in_the_place_of_a_series_is_named(tmp_path: Path, packed: bool) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a/scan.nii.gz").write_bytes(b"x")
    path = _zip(tmp_path / "a", tmp_path / "a.zip") if packed else tmp_path / "a"
    with pytest.raises(ImageError, match=r"has 0 DICOM slices .* of a series, or scan\.nii\.gz itself$"):
        read_series(path)


def test_a_file_in_a_zip_is_named(tmp_path: Path) -> None:
    folder = write(tmp_path / "a")
    (folder / "6.dcm").write_bytes((folder / "6.dcm").read_bytes()[:-20])
    path = _zip(folder, tmp_path / "a.zip", inside="x/")
    with pytest.raises(ImageError, match=r"a\.zip: x/6\.dcm is cut short"):
        read_series(path)


def test_half_a_zip_is_rejected(tmp_path: Path) -> None:
    path = _zip(write(tmp_path / "a"), tmp_path / "a.zip")
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.raises(ImageError, match=r"a\.zip is no whole zip archive"):
        read_series(path)


def test_a_flipped_byte_in_a_zip_is_found(tmp_path: Path) -> None:
    path = tmp_path / "a.zip"
    with zipfile.ZipFile(path, "w") as archive:  # stored: only the check sum tells
        for file in sorted(write(tmp_path / "a").iterdir()):
            archive.write(file, file.name)
        at = archive.getinfo("7.dcm").header_offset
    data = bytearray(path.read_bytes())
    data[at + 700] ^= 255
    path.write_bytes(data)
    with pytest.raises(ImageError, match=r"7\.dcm does not unpack: it is damaged"):
        read_series(path)


@pytest.mark.parametrize("kept", [0, 60, 120, 300, 800, -300, -20])
@pytest.mark.parametrize("number", [9, 6, 4])
def test_a_file_that_is_cut_short_is_named(tmp_path: Path, kept: int, number: int) -> None:
    """At whatever byte, the ends of the series included."""
    file = write(tmp_path) / f"{number}.dcm"
    file.write_bytes(file.read_bytes()[:kept])
    with pytest.raises(ImageError, match=rf"{number}\.dcm.*(cut short|damaged)") as raised:
        read_series(tmp_path)
    assert "Dent" not in str(raised.value)


def test_a_cut_file_without_a_suffix_is_known_by_its_neighbours(tmp_path: Path) -> None:
    for file in write(tmp_path / "a").iterdir():
        file.rename(tmp_path / "a" / f"IM{file.stem}")
    (tmp_path / "a" / "README").write_text("slices")
    read_series(tmp_path / "a")
    (tmp_path / "a" / "IM5").write_bytes(b"\0" * 40)
    with pytest.raises(ImageError, match="IM5 is no DICOM file any more, or cut short"):
        read_series(tmp_path / "a")


def test_a_link_to_nothing_is_a_lost_slice(tmp_path: Path) -> None:
    file = write(tmp_path) / "5.dcm"
    file.unlink()
    file.symlink_to("annex/5")
    with pytest.raises(ImageError, match=r"5\.dcm is a link to nothing"):
        read_series(tmp_path)


def test_an_enhanced_file_that_is_cut_short_is_named(tmp_path: Path) -> None:
    file = save(enhanced(), tmp_path / "a.dcm")
    file.write_bytes(file.read_bytes()[:-30])
    with pytest.raises(ImageError, match=r"a\.dcm is cut short"):
        read_series(tmp_path)


def test_an_enhanced_file_with_fewer_places_than_frames_is_named(tmp_path: Path) -> None:
    dataset = enhanced()
    del dataset.PerFrameFunctionalGroupsSequence[4]
    save(dataset, tmp_path / "a.dcm")
    with pytest.raises(ImageError, match=r"a\.dcm has 6 frames and places of 5"):
        read_series(tmp_path)


def test_a_frame_without_a_place_is_named(tmp_path: Path) -> None:
    dataset = enhanced()
    del dataset.PerFrameFunctionalGroupsSequence[4].PlanePositionSequence
    save(dataset, tmp_path / "a.dcm")
    with pytest.raises(ImageError, match=r"a\.dcm, frame 5 has no ImagePositionPatient"):
        read_series(tmp_path)


def test_files_without_a_preamble_are_read(tmp_path: Path) -> None:
    for file in write(tmp_path).iterdir():
        data = io.BytesIO(file.read_bytes()[132:])
        file.write_bytes(data.getvalue())
    np.testing.assert_array_equal(read_series(tmp_path).image.values, VALUES)


def test_an_index_and_a_report_beside_the_slices_are_left_out(tmp_path: Path) -> None:
    def report(k: int, dataset: object) -> None:
        dataset.SOPClassUID = dataset.file_meta.MediaStorageSOPClassUID = EnhancedSRStorage  # type: ignore[attr-defined]
        del dataset.PixelData  # type: ignore[attr-defined]

    write(tmp_path / "a")
    write(tmp_path / "b", report, slices=[0])
    shutil.move(tmp_path / "b" / "9.dcm", tmp_path / "a" / "DICOMDIR")
    np.testing.assert_array_equal(read_series(tmp_path).image.values, VALUES)


def test_what_pydicom_says_of_odd_tags_is_not_passed_on(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, recwarn: pytest.WarningsRecorder
) -> None:
    """It quotes them, and they may hold a name: in the log of a job nobody looks for one."""
    for file in write(tmp_path).iterdir():
        number = uid("series").encode()  # its tag allows no letters
        file.write_bytes(file.read_bytes().replace(number, b"Dent^Mavis".ljust(len(number), b"x")))
    with caplog.at_level(0):
        read_series(tmp_path)
    assert not caplog.messages
    assert not recwarn.list


def _message(path: Path) -> str:
    """Why a path is rejected; '' where it is read."""
    try:
        read_series(path)
    except ImageError as error:
        return str(error)
    return ""


def test_a_wrong_byte_anywhere_gives_a_volume_or_one_line(tmp_path: Path) -> None:
    """Of a slice and of an enhanced file; every 31st byte becomes another one."""
    file, whole = write(tmp_path / "a") / "6.dcm", save(enhanced(), tmp_path / "whole.dcm")
    messages = []
    for path, given in ((file, file.parent), (whole, whole)):
        data = path.read_bytes()
        for at in range(128, len(data), 31):
            path.write_bytes(data[:at] + bytes([data[at] ^ 0x55]) + data[at + 1 :])
            messages.append(_message(given))
        path.write_bytes(data)
    assert 0 < sum(map(bool, messages)) < len(messages)
    assert not re.search(r"\n|Dent|Mavis", "".join(messages))
