"""Volumes keep their place in the patient, whatever way their axes run."""

import gzip
from pathlib import Path

import numpy as np
import pytest
import SimpleITK as sitk

from mammosim.core.errors import ImageError
from mammosim.core.rigid import rotation
from mammosim.core.volume import Grid, Image, LabelMap
from mammosim.io.images import image_of, itk_volume, read_image, read_labels, write_image, write_labels

OBLIQUE = Grid(
    (3, 4, 5), np.array([1.0, 2.0, 3.5]), np.array([-10.0, 5.0, 7.0]), rotation(np.array([2.0, -3, 5]))
)


def _intensities() -> np.ndarray:
    return np.random.default_rng(1).normal(size=OBLIQUE.shape).astype(np.float32)


def test_an_oblique_image_reads_back_in_the_same_place(tmp_path: Path) -> None:
    image = Image(OBLIQUE, _intensities())
    write_image(image, tmp_path / "prone.nii.gz")
    back = read_image(tmp_path / "prone.nii.gz")
    assert back.grid.same_as(OBLIQUE)
    # NIfTI keeps the orientation in 32-bit numbers: 1e-5 mm over a few voxels.
    np.testing.assert_allclose(back.grid.centres(), OBLIQUE.centres(), atol=1e-5)
    np.testing.assert_array_equal(back.values, image.values)


def test_labels_read_back_as_labels(tmp_path: Path) -> None:
    labels = LabelMap(OBLIQUE, np.arange(60, dtype=np.uint8).reshape(OBLIQUE.shape) % 6)
    write_labels(labels, tmp_path / "labels.nii.gz")
    back = read_labels(tmp_path / "labels.nii.gz")
    assert back.values.dtype == np.uint8
    np.testing.assert_array_equal(back.values, labels.values)


def test_the_same_image_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a.nii.gz", "b.nii.gz"):
        write_image(Image(OBLIQUE, _intensities()), tmp_path / name)
    assert (tmp_path / "a.nii.gz").read_bytes() == (tmp_path / "b.nii.gz").read_bytes()


def test_turning_the_axes_moves_no_voxel() -> None:
    image = Image(Grid((3, 4, 5), np.array([1.0, 2.0, 3.5]), np.zeros(3)), _intensities())
    coronal = sitk.PermuteAxes(itk_volume(image.grid, image.values)[:, :, ::-1], [0, 2, 1])
    back = image_of(coronal)
    assert back.grid.same_as(image.grid)
    np.testing.assert_array_equal(back.values, image.values)


def test_intensities_are_no_labels(tmp_path: Path) -> None:
    write_image(Image(OBLIQUE, _intensities()), tmp_path / "image.nii.gz")
    with pytest.raises(ImageError, match="not all whole numbers"):
        read_labels(tmp_path / "image.nii.gz")


def test_an_absent_or_broken_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(ImageError, match=r"absent\.nii\.gz; run the stage"):
        read_image(tmp_path / "absent.nii.gz")
    (tmp_path / "empty.nii.gz").touch()
    with pytest.raises(ImageError, match=r"empty\.nii\.gz is empty; copy it again"):
        read_image(tmp_path / "empty.nii.gz")
    (tmp_path / "broken.nii.gz").write_text("no image")
    with pytest.raises(ImageError, match=r"broken\.nii\.gz is not a readable image"):
        read_image(tmp_path / "broken.nii.gz")


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("scan.tar.gz", b"\x1f\x8b", "scan.tar.gz is an archive; unpack it"),
        ("scan.tgz", b"abcdefgh", "scan.tgz is an archive; unpack it"),
        ("scan", b"PK\3\4 and more", "scan is an archive; unpack it"),
        ("scan.nii.gz", b"version https://git-lfs.github.com/spec/v1\n", "is a pointer of git-lfs"),
    ],
)
def test_what_is_no_image_is_told_what_it_is(tmp_path, name, data, message):
    (tmp_path / name).write_bytes(gzip.compress(b"ada/1.dcm") if data == b"\x1f\x8b" else data)
    with pytest.raises(ImageError, match=message):
        read_image(tmp_path / name)
