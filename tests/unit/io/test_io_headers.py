"""NRRD and MetaImage files are read as ITK and 3D Slicer write them; those cut short are rejected."""

from pathlib import Path

import numpy as np
import pytest
import SimpleITK as sitk

from mammosim.core.errors import ImageError
from mammosim.core.rigid import rotation
from mammosim.core.volume import Grid
from mammosim.io.images import itk_volume, read_image, read_labels, whole_volume

GRID = Grid(
    (20, 24, 28), np.array([1.0, 1.5, 2.0]), np.array([-5.0, 6.0, 7.0]), rotation(np.array([2.0, -3, 5]))
)
VALUES = np.random.default_rng(1).normal(100, 30, GRID.shape).astype(np.int16)
FORMATS = [
    ("a.nrrd", True),
    ("a.nrrd", False),
    ("a.mha", True),
    ("a.mha", False),
    ("a.nhdr", True),
    ("a.mhd", False),
]


def written(folder: Path, name: str, packed: bool) -> Path:
    sitk.WriteImage(itk_volume(GRID, VALUES), str(folder / name), useCompression=packed)
    return folder / name


def data_of(path: Path) -> Path:
    """The file that holds the voxels: the largest."""
    return max(path.parent.iterdir(), key=lambda file: file.stat().st_size)


@pytest.mark.parametrize(("name", "packed"), FORMATS)
def test_a_whole_file_is_read(tmp_path, name, packed):
    image = read_image(written(tmp_path, name, packed))
    np.testing.assert_array_equal(image.values, VALUES)
    np.testing.assert_allclose(image.grid.centres(), GRID.centres(), atol=1e-5)


@pytest.mark.parametrize("name", ["a.nhdr", "a.mhd"])
def test_the_file_of_the_voxels_may_have_a_name_with_blanks(tmp_path, name):
    path = written(tmp_path, name, False)
    data_of(path).rename(tmp_path / "my scan.raw")
    path.write_text(path.read_text().replace("a.raw", "my scan.raw"))
    np.testing.assert_array_equal(read_image(path).values, VALUES)


def test_without_the_size_of_what_is_packed_a_file_is_not_read(tmp_path):
    """MetaIO leaves such voxels as the memory was, and says nothing."""
    path = written(tmp_path, "a.mha", True)
    data = path.read_bytes()
    start, end = data.index(b"CompressedDataSize"), data.index(b"\n", data.index(b"CompressedDataSize")) + 1
    for line, words in ((b"", "states none"), (b"CompressedDataSize = 100\n", "states 100")):
        path.write_bytes(data[:start] + line + data[end:])
        with pytest.raises(ImageError, match=rf"a\.mha: \d+ packed bytes .* its CompressedDataSize {words}"):
            read_image(path)


@pytest.mark.parametrize("true", [b"T", b"1", b"true"])
def test_true_may_be_written_shortly(tmp_path, true):
    path = written(tmp_path, "a.mha", True)
    path.write_bytes(path.read_bytes().replace(b"CompressedData = True", b"CompressedData = " + true))
    np.testing.assert_array_equal(read_image(path).values, VALUES)


def test_directions_may_have_blanks_between_their_numbers(tmp_path):
    path = written(tmp_path, "a.nrrd", False)
    head, voxels = path.read_bytes().split(b"\n\n", 1)
    lines = [
        line.replace(b",", b",  ") if line.startswith(b"space directions") else line
        for line in head.split(b"\n")
    ]
    path.write_bytes(b"\n".join(lines) + b"\n\n" + voxels)
    np.testing.assert_allclose(read_image(path).grid.centres(), GRID.centres(), atol=1e-5)


def test_no_axis_with_a_direction_is_no_orientation(tmp_path):
    """ITK takes voxels of 1 mm along the axes of the patient then."""
    path = written(tmp_path, "a.nrrd", False)
    data = path.read_bytes()
    start, end = data.index(b"space directions"), data.index(b"\n", data.index(b"space directions"))
    path.write_bytes(data[:start] + b"space directions: none none none" + data[end:])
    with pytest.raises(ImageError, match=r"a\.nrrd states no orientation: its space directions are not 3"):
        read_image(path)


@pytest.mark.parametrize("names", ["a%d.raw 1 20 1", "LIST"])
def test_voxels_in_several_files_are_rejected(tmp_path, names):
    path = written(tmp_path, "a.nhdr", False)
    path.write_text(path.read_text().replace("a.raw", names))
    with pytest.raises(ImageError, match=r"a\.nhdr: encoding 'raw' or voxels in several files"):
        read_image(path)


@pytest.mark.parametrize("left", [0.3, 0.6, -1])
@pytest.mark.parametrize(("name", "packed"), FORMATS)
def test_a_file_that_is_cut_short_is_rejected(tmp_path, name, packed, left):
    path = written(tmp_path, name, packed)
    data = data_of(path).read_bytes()
    data_of(path).write_bytes(data[: left if left < 0 else int(left * len(data))])
    with pytest.raises(ImageError, match=r"a\.\w+(\.\w+)? ends early") as error:
        read_image(path)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("name", ["a.nrrd", "a.mha"])
def test_a_packed_file_with_one_wrong_bit_is_rejected(tmp_path, name):
    path = written(tmp_path, name, True)
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0x10
    path.write_bytes(data)
    with pytest.raises(ImageError, match=r"is damaged, its checksum is wrong|ends early"):
        read_labels(path)


@pytest.mark.parametrize("name", ["a.nhdr", "a.mhd"])
def test_a_header_without_its_voxels_is_named(tmp_path, name):
    path = written(tmp_path, name, False)
    data_of(path).unlink()
    with pytest.raises(ImageError, match=rf"{name} keeps its voxels in a\.raw, which is not there"):
        read_image(path)


def test_a_list_of_slices_is_named_as_what_it_is(tmp_path):
    path = written(tmp_path, "a.mhd", False)
    path.write_text(path.read_text().replace("a.raw", "LIST 2\na.raw"))
    with pytest.raises(ImageError, match=r"a\.mhd: voxels as text, in several files"):
        read_image(path)


def test_what_itk_says_has_no_place_in_its_code(tmp_path):
    path = written(tmp_path, "a.nrrd", False)
    path.write_bytes(path.read_bytes().replace(b"endian: little\n", b""))
    with pytest.raises(ImageError, match=r"a\.nrrd is not a readable image; .*endian") as caught:
        read_image(path)
    assert not any(word in str(caught.value) for word in (".cxx", "0x", "SimpleITK"))


@pytest.mark.parametrize(
    ("name", "old", "new", "message"),
    [
        ("a.nrrd", b"space: left-posterior-superior\n", b"space dimension: 3\n", "states no orientation"),
        ("a.nrrd", b"left-posterior-superior", b"scanner-xyz", "no orientation: space is 'scanner-xyz'"),
        ("a.nrrd", b"space origin", b'space units: "cm" "cm" "cm"\nspace origin', "not mm; save it in mm"),
        ("a.nrrd", b"encoding: raw", b"encoding: bz2", "encoding 'bz2' .* cannot be checked"),
        ("a.nrrd", b"type: short", b"type: block", "no number has the type 'block'"),
        ("a.nrrd", b"sizes: 28 24 20", b"sizes: 28 24 x", r"a\.nrrd is not a readable image"),
        ("a.mha", b"NDims", b"DistanceUnits = cm\nNDims", "DistanceUnits is cm, not mm"),
        ("a.mha", b"ElementSpacing = 1 ", b"ElementSpacing = -1 ", "must be positive"),
        ("a.mha", b"Offset = -5 6 7", b"Offset = nan 6 7", "Offset must be 3 finite numbers"),
        ("a.mha", b"Offset = -5 6 7", b"Offset = -5,0 6 7", "Offset must be 3 finite numbers"),
        ("a.mha", b"Offset = -5 6 7", b"Position = -5 6", "Position must be 3 finite numbers"),
        ("a.mha", b"TransformMatrix", b"Comment", "states no orientation: it has no TransformMatrix"),
        ("a.mha", b"ElementType = MET_SHORT\n", b"", "its header has no 'ElementType'"),
        ("a.mha", b"BinaryData = True", b"BinaryData = False", "voxels as text"),
        ("a.mha", b"ElementSpacing =", b"elementspacing =", "no voxel size: it has no ElementSpacing"),
        ("a.mha", b"TransformMatrix", b"transformmatrix", "states no orientation: it has no TransformMatrix"),
        ("a.nrrd", b"space directions: ", b"spacings: 1 1.5 2\n# ", "its space directions are not 3 vectors"),
        ("a.nrrd", b"space origin: (", b"space origin: (nan,", "space origin must be 3 finite numbers"),
        ("a.nrrd", b"space origin: (-5", b"space origin: (inf", "space origin must be 3 finite numbers"),
    ],
)  # fmt: skip
def test_a_header_that_cannot_be_believed_is_rejected(tmp_path, name, old, new, message):
    path = written(tmp_path, name, False)
    data = path.read_bytes()
    assert data.count(old) == 1
    path.write_bytes(data.replace(old, new))
    with pytest.raises(ImageError, match=message):
        read_image(path)


def test_sheared_axes_are_named(tmp_path):
    path = written(tmp_path, "a.nrrd", False)
    data = path.read_bytes()
    start, stop = data.index(b"space directions"), data.index(b"\n", data.index(b"space directions"))
    path.write_bytes(data[:start] + b"space directions: (1,0,0) (0.3,1.5,0) (0,0,2)" + data[stop:])
    # Axes at right angles differ from both by half of the angle, 0.1 rad, over 13.5 and 17.6 mm: 2.2 mm.
    with pytest.raises(ImageError, match=r"axes are sheared.*a corner is 2\.\d mm off, the limit is 1 mm"):
        read_image(path)


def test_segments_that_overlap_are_checked_as_one_volume_is(tmp_path):
    """As 3D Slicer writes them: a first axis of segments, which has no direction."""
    segments = sitk.Compose(itk_volume(GRID, VALUES), itk_volume(GRID, VALUES))
    sitk.WriteImage(segments, str(tmp_path / "a.seg.nrrd"), useCompression=True)
    assert whole_volume(tmp_path / "a.seg.nrrd").GetNumberOfComponentsPerPixel() == 2
    with pytest.raises(ImageError, match="has 3 dimensions and 2 components per voxel; give one volume"):
        read_image(tmp_path / "a.seg.nrrd")
    data = (tmp_path / "a.seg.nrrd").read_bytes()
    (tmp_path / "a.seg.nrrd").write_bytes(data[:-20])
    with pytest.raises(ImageError, match="ends early"):
        whole_volume(tmp_path / "a.seg.nrrd")
