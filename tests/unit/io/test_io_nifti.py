"""A NIfTI file is read whole, where it says that its voxels are, or rejected in one line that names it."""

import gzip
import struct
from pathlib import Path

import numpy as np
import pytest
import SimpleITK as sitk

from mammosim.core.errors import ImageError
from mammosim.core.rigid import rotation
from mammosim.io.images import grid_of, read_image, read_labels

SHAPE, SPACING = (5, 6, 7), (1.5, 2.0, 4.0)
TURN = rotation(np.array([0.0, 0.0, 12.0]))
# Offsets and formats of version 1 and 2: https://nifti.nimh.nih.gov/pub/dist/src/niftilib/nifti1.h, nifti2.h
PLACES = {
    "dim": (("8h", 40), ("8q", 16)),
    "datatype": (("h", 70), ("h", 12)),
    "pixdim": (("8f", 76), ("8d", 104)),
    "vox_offset": (("f", 108), ("q", 168)),
    "slope": (("2f", 112), ("2d", 176)),
    "units": (("B", 123), ("i", 500)),
    "qform": (("h", 252), ("i", 344)),
    "sform": (("h", 254), ("i", 348)),
    "quaternion": (("6f", 256), ("6d", 352)),
    "srow": (("12f", 280), ("12d", 400)),
}
CODES = {"uint8": 2, "int16": 4, "float32": 16, "uint16": 512, "float64": 64}


def nifti(values: np.ndarray, *, version: int = 1, order: str = "<", **fields: object) -> bytes:
    """One file of values (nz, ny, nx); by default qform and sform are those of axes in LPS at the origin."""
    size, magic = ((348, b"n+1\0"), (540, b"n+2\0\r\n\x1a\n"))[version - 1]
    sform = np.column_stack([np.diag([-1.0, -1.0, 1.0]) * SPACING, np.zeros(3)])
    given = {
        "dim": (3, *values.shape[::-1], 1, 1, 1, 1),
        "datatype": (CODES[values.dtype.name],),
        "pixdim": (1, *SPACING, 1, 1, 1, 1),
        "vox_offset": (size + 4,),
        "slope": (0, 0),
        "units": (2,),
        "qform": (1,),
        "sform": (1,),
        "quaternion": (0, 0, 1, 0, 0, 0),
        "srow": sform.ravel(),
    } | fields
    header = bytearray(size)
    struct.pack_into(order + "i", header, 0, size)
    for name, numbers in given.items():
        form, place = PLACES[name][version - 1]
        struct.pack_into(order + form, header, place, *numbers)
    place = 344 if version == 1 else 4
    header[place : place + len(magic)] = magic
    return bytes(header) + bytes(4) + values.astype(values.dtype.newbyteorder(order)).tobytes()


def values(kind: str = "float32") -> np.ndarray:
    return np.random.default_rng(1).integers(0, 200, SHAPE).astype(kind)


def placed(matrix: np.ndarray, origin: tuple[float, float, float] = (0, 0, 0)) -> np.ndarray:
    """The 12 numbers of an sform of axes (3, 3) mm and origin in RAS."""
    return np.column_stack([matrix, origin]).ravel()


AXES = np.diag([-1.0, -1.0, 1.0]) * SPACING


def read(folder: Path, data: bytes, name: str = "woman.nii.gz"):
    (folder / name).write_bytes(gzip.compress(data) if name.endswith("gz") else data)
    return read_image(folder / name)


@pytest.mark.parametrize("name", ["a.nii", "a.nii.gz"])
@pytest.mark.parametrize("version", [1, 2])
@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("kind", CODES)
def test_every_version_byte_order_and_type_is_read(tmp_path, name, version, order, kind):
    image = read(tmp_path, nifti(values(kind), version=version, order=order), name)
    np.testing.assert_array_equal(image.values, values(kind))
    np.testing.assert_allclose(image.grid.spacing, SPACING)
    np.testing.assert_array_equal(image.grid.direction, np.eye(3))


@pytest.mark.parametrize(
    "fields",
    [
        {"quaternion": (0.1, -0.2, 0.3, 10, -20, 30), "sform": (0,)},
        {"quaternion": (0.1, -0.2, 0.3, 10, -20, 30), "sform": (0,), "pixdim": (-1, *SPACING, 1, 1, 1, 1)},
        {"quaternion": (0.6, 0.5, 0.62, 0, 0, 5), "sform": (0,)},
        {"qform": (0,), "sform": (2,), "srow": placed(TURN @ AXES, (5, 6, -7))},
        {"qform": (0,), "sform": (1,), "srow": placed(AXES[:, [1, 2, 0]] / [2, 4, 1.5] * [1.5, 2, 4])},
        {"slope": (2.5, -10)},
    ],
)
def test_voxels_are_where_and_what_itk_says(tmp_path, fields):
    """ITK reads a good file by code that is not ours."""
    image = read(tmp_path, nifti(values(), **fields))
    volume = sitk.DICOMOrient(sitk.ReadImage(str(tmp_path / "woman.nii.gz")), "LPS")
    # Both calculate with 64 bits on numbers of 32.
    np.testing.assert_allclose(image.grid.centres(), grid_of(volume).centres(), atol=1e-5)
    np.testing.assert_allclose(image.values, sitk.GetArrayFromImage(volume), rtol=1e-6)


@pytest.mark.parametrize("code", [0, 1])
@pytest.mark.parametrize(
    ("units", "mm"), [(1, 1000.0), (3, 1e-3), (1 + 8, 1000.0), (3 + 16, 1e-3), (2 + 8, 1.0)]
)
def test_metres_and_micrometres_are_turned_into_millimetres(tmp_path, units, mm, code):
    """Whatever the unit of time beside them; the origin is moved as the axes are, of qform and of sform."""
    there = {
        "pixdim": (1, *np.divide(SPACING, mm), 1, 1, 1, 1),
        "sform": (code,),
        "srow": placed(AXES / mm, tuple(np.divide([10.0, -20.0, 30.0], mm))),
        "quaternion": (0, 0, 1, *np.divide([10.0, -20.0, 30.0], mm)),
    }
    image = read(tmp_path, nifti(values(), units=(units,), **there))
    np.testing.assert_allclose(image.grid.spacing, SPACING, rtol=1e-6)
    np.testing.assert_allclose(image.grid.origin, [-10, 20, 30], rtol=1e-5)


def test_a_fourth_axis_of_one_entry_is_no_second_volume(tmp_path):
    image = read(tmp_path, nifti(values(), dim=(4, *SHAPE[::-1], 1, 1, 1, 1)))
    np.testing.assert_array_equal(image.values, values())


def test_gzip_in_two_parts_is_one_file(tmp_path):
    data = nifti(values())
    (tmp_path / "a.nii.gz").write_bytes(gzip.compress(data[:500]) + gzip.compress(data[500:]))
    np.testing.assert_array_equal(read_image(tmp_path / "a.nii.gz").values, values())


NOISE = np.random.default_rng(2).normal(size=(20, 40, 40)).astype(np.float32)


@pytest.mark.parametrize("left", [0.02, 0.3, 0.7, 0.99, -8, -4, -1])
def test_a_packed_file_that_is_cut_short_is_rejected(tmp_path, left):
    packed = gzip.compress(nifti(NOISE))
    (tmp_path / "cut.nii.gz").write_bytes(packed[: left if left < 0 else int(left * len(packed))])
    for reader in (read_image, read_labels):
        with pytest.raises(ImageError, match=r"cut\.nii\.gz ends early.*copy it again"):
            reader(tmp_path / "cut.nii.gz")


@pytest.mark.parametrize("at", np.linspace(0.05, 0.999, 12))
def test_a_packed_file_with_one_wrong_bit_is_rejected(tmp_path, at):
    packed = bytearray(gzip.compress(nifti(NOISE)))
    packed[int(at * len(packed))] ^= 0x10
    (tmp_path / "wrong.nii.gz").write_bytes(packed)
    with pytest.raises(ImageError, match=r"wrong\.nii\.gz (is damaged|ends early)"):
        read_image(tmp_path / "wrong.nii.gz")


def test_bytes_are_counted_against_the_header(tmp_path):
    data = nifti(values())
    with pytest.raises(ImageError, match=r"a\.nii ends early: 420 of the 840 bytes of voxels"):
        read(tmp_path, data[:-420], "a.nii")
    with pytest.raises(ImageError, match="ends early: 420 of the 840 bytes of voxels"):
        read(tmp_path, data[:-420])
    with pytest.raises(ImageError, match="has 840 bytes more than the 840"):
        read(tmp_path, data + data[-840:], "a.nii")
    with pytest.raises(ImageError, match="ends early, in its header"):
        read(tmp_path, data[:200], "a.nii")
    read(tmp_path, data + bytes(100), "a.nii")  # less than a slice: a block that is filled up


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"srow": placed(AXES, (0, 25, 0))}, r"differ by up to 25 mm \(shifted\), the limit is 1 mm; state"),
        ({"srow": placed(AXES * [1, 1, -1])}, r"differ by up to 32 mm \(one mirrors head and feet\)"),
        ({"srow": placed(AXES * [-1, 1, 1])}, "one mirrors left and right"),
        ({"srow": placed(TURN @ AXES), "sform": (2,)}, "turned by 12 degrees"),
        ({"sform": (0,), "qform": (0,)}, "states no orientation: its sform and qform codes are 0"),
        ({"pixdim": (1, 1.5, -2, 4, 1, 1, 1, 1)}, r"negative spacing 1\.5 x -2 x 4 in pixdim"),
        ({"pixdim": (1, 1.5, 0, 4, 1, 1, 1, 1)}, r"no spacing 1\.5 x 0 x 4 in pixdim"),
        ({"pixdim": (1, 1.5, np.nan, 4, 1, 1, 1, 1)}, "no spacing"),
        ({"srow": placed(AXES + [[0, 1, 0], [0, 0, 0], [0, 0, 0]]), "qform": (0,)}, "axes are sheared"),
        (
            {"srow": placed(AXES * 2), "qform": (0,)},
            r"voxels are 3 x 4 x 8 mm large by its sform and 1\.5 x 2 x",
        ),
        ({"srow": placed(AXES * np.nan), "qform": (0,)}, "not finite"),
        ({"srow": placed(AXES * [1, 0, 1]), "qform": (0,)}, "are no directions"),
        ({"datatype": (128,)}, r"holds colours, complex .*data type 128"),
        ({"dim": (4, 7, 6, 1, 5, 1, 1, 1)}, r"has 4 dimensions, 7 x 6 x 1 x 5; give one volume"),
        ({"dim": (2, 7, 6, 1, 1, 1, 1, 1)}, "has 2 dimensions"),
        ({"dim": (3, 7, -6, 5, 1, 1, 1, 1)}, "its header is damaged"),
        (
            {"dim": (3, 30000, 30000, 30000, 1, 1, 1, 1)},
            r"bytes cannot hold the 108000000000000 bytes of vox",
        ),
        ({"vox_offset": (np.inf,)}, "its header is damaged: voxels start at byte inf"),
    ],
)
def test_a_header_that_cannot_be_believed_is_rejected_in_one_line(tmp_path, fields, message):
    with pytest.raises(ImageError, match=rf"woman\.nii\.gz.*{message}") as error:
        read(tmp_path, nifti(values(), **fields))
    assert "\n" not in str(error.value)


def test_placements_that_differ_by_rounding_are_one(tmp_path):
    near = placed(rotation(np.array([0, 0, 0.5])) @ AXES, (0.3, 0, 0))
    image = read(tmp_path, nifti(values(), srow=near, sform=(2,)))
    # The sform is the one that counts.
    np.testing.assert_allclose(image.grid.direction, rotation(np.array([0, 0, 0.5])), atol=1e-6)


def test_what_is_no_number_is_no_intensity_and_no_label(tmp_path):
    wrong = values()
    wrong[1, 2, :3], wrong[0, 0, 0] = np.nan, np.inf
    with pytest.raises(ImageError, match=r"4 of 210 voxels are no numbers \(3 NaN and 1 infinite\)"):
        read(tmp_path, nifti(wrong))
    with pytest.raises(ImageError, match="no numbers"):
        read_labels(tmp_path / "woman.nii.gz")


def test_analyze_says_not_where_left_is(tmp_path):
    data = bytearray(nifti(values()))
    data[344:348] = bytes(4)
    with pytest.raises(ImageError, match="header of Analyze or of a NIfTI pair"):
        read(tmp_path, bytes(data), "woman.hdr")
