"""Series in every encoding that archives use read as the same volume; one that is not read is named."""

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pydicom
import pytest
import SimpleITK as sitk
from dicom_series import VALUES, save, slice_of
from PIL import Image as Picture
from pydicom import Dataset
from pydicom.data import get_testdata_file
from pydicom.encaps import encapsulate, get_frame
from pydicom.uid import (
    DeflatedExplicitVRLittleEndian,
    ExplicitVRBigEndian,
    HTJ2KLossless,
    ImplicitVRLittleEndian,
    JPEG2000Lossless,
    JPEGLosslessSV1,
    RLELossless,
)

from mammosim.core.errors import ImageError
from mammosim.io.dicom import read_series
from mammosim.io.dicom_decoder import register_decoder


def _encapsulated(dataset: Dataset, frame: bytes, syntax: pydicom.uid.UID) -> None:
    dataset.PixelData = encapsulate([frame])
    dataset["PixelData"].VR, dataset["PixelData"].is_undefined_length = "OB", True
    dataset.file_meta.TransferSyntaxUID = syntax


def _jpeg_lossless(k: int, dataset: Dataset, folder: Path) -> None:
    """As GDCM writes it."""
    writer, path = sitk.ImageFileWriter(), folder.parent / "encoded.dcm"
    writer.SetImageIO("GDCMImageIO")
    writer.SetFileName(str(path))
    writer.UseCompressionOn()
    writer.SetCompressor("JPEG")
    writer.Execute(sitk.GetImageFromArray(VALUES[k][None]))
    encoded = pydicom.dcmread(path)
    assert encoded.file_meta.TransferSyntaxUID == JPEGLosslessSV1
    _encapsulated(dataset, get_frame(encoded.PixelData, 0, number_of_frames=1), JPEGLosslessSV1)


def _jpeg_2000(k: int, dataset: Dataset, folder: Path) -> None:
    stream = io.BytesIO()
    Picture.fromarray(VALUES[k]).save(stream, "JPEG2000", irreversible=False, no_jp2=True)
    _encapsulated(dataset, stream.getvalue(), JPEG2000Lossless)


def _rle(k: int, dataset: Dataset, folder: Path) -> None:
    dataset.compress(RLELossless, generate_instance_uid=False)


def _big_endian(k: int, dataset: Dataset, folder: Path) -> None:
    dataset.PixelData = VALUES[k].astype(">u2").tobytes()
    dataset.file_meta.TransferSyntaxUID = ExplicitVRBigEndian


def _native(syntax: pydicom.uid.UID) -> Callable[[int, Dataset, Path], None]:
    def encode(k: int, dataset: Dataset, folder: Path) -> None:
        dataset.file_meta.TransferSyntaxUID = syntax

    return encode


@pytest.mark.parametrize(
    "encode",
    [
        _jpeg_lossless,
        _jpeg_2000,
        _rle,
        _big_endian,
        _native(ImplicitVRLittleEndian),
        _native(DeflatedExplicitVRLittleEndian),
    ],
)
def test_every_encoding_gives_the_same_volume(
    tmp_path: Path, encode: Callable[[int, Dataset, Path], None]
) -> None:
    folder = tmp_path / "series"
    folder.mkdir()
    for k in range(6):
        dataset = slice_of(k)
        encode(k, dataset, folder)
        save(dataset, folder / f"{k}.dcm")
    np.testing.assert_array_equal(read_series(folder).image.values, VALUES)


def _shipped(name: str) -> Dataset:
    """A file that pydicom brings with it."""
    register_decoder()
    return pydicom.dcmread(get_testdata_file(name, download=False))


def test_jpeg_ls_of_another_program_is_decoded() -> None:
    """The same slice, signed, with and without compression."""
    values = _shipped("MR_small_jpeg_ls_lossless.dcm").pixel_array
    np.testing.assert_array_equal(values, _shipped("MR_small.dcm").pixel_array)
    assert values.dtype == np.int16


def test_near_lossless_jpeg_ls_and_jpeg_of_12_bits_are_decoded() -> None:
    assert _shipped("JPEGLSNearLossless_16.dcm").pixel_array.max() == 65535
    values = _shipped("JPGExtended.dcm").pixel_array
    assert (values.dtype, values.shape, int(values.min())) == (np.uint16, (1024, 256), 0)
    assert 255 < values.max() < 4096, "of 12 bits"


def _cut(frame: bytes) -> bytes:
    return frame[: len(frame) // 2]


def _zeroed(frame: bytes) -> bytes:
    return _cut(frame) + bytes(len(frame) // 2)


@pytest.mark.parametrize("damage", [_cut, _zeroed])
@pytest.mark.parametrize("encode", [_jpeg_lossless, _jpeg_2000, _rle])
def test_a_damaged_stream_is_no_image(
    tmp_path: Path, encode: Callable[[int, Dataset, Path], None], damage: Callable[[bytes], bytes]
) -> None:
    folder = tmp_path / "series"
    folder.mkdir()
    for k in range(6):
        dataset = slice_of(k)
        encode(k, dataset, folder)
        if k == 3:
            frame = get_frame(dataset.PixelData, 0, number_of_frames=1)
            _encapsulated(dataset, damage(frame), dataset.file_meta.TransferSyntaxUID)
        save(dataset, folder / f"{k}.dcm")
    with pytest.raises(ImageError, match=r"3\.dcm is cut short or damaged: its pixels \(.*\) do not decode"):
        read_series(folder)


def test_an_encoding_that_is_not_read_is_named(tmp_path: Path) -> None:
    for k in range(2):
        dataset = slice_of(k)
        _encapsulated(dataset, b"\xff\x4f\xff\xd9", HTJ2KLossless)
        save(dataset, tmp_path / f"{k}.dcm")
    with pytest.raises(
        ImageError, match=r"0\.dcm is compressed by High-Throughput JPEG 2000.*, which is not read"
    ):
        read_series(tmp_path)
