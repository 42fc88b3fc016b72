"""Compressed pixels decoded by the GDCM that SimpleITK carries: a plugin for pydicom.

pydicom decodes RLE, and through Pillow JPEG 2000 and JPEG of 8 bits. This one adds JPEG-LS, lossless JPEG and
JPEG of 12 bits. Choice and costs: docs/decisions/dicom_decoder.md.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import SimpleITK as sitk
from pydicom import Dataset
from pydicom.dataset import FileMetaDataset
from pydicom.encaps import encapsulate
from pydicom.pixels import get_decoder
from pydicom.pixels.decoders.base import DecodeRunner
from pydicom.uid import (
    UID,
    JPEGBaseline8Bit,
    JPEGExtended12Bit,
    JPEGLossless,
    JPEGLosslessSV1,
    JPEGLSLossless,
    JPEGLSNearLossless,
    SecondaryCaptureImageStorage,
)

LABEL = "simpleitk"
END, PADDED = b"\xff\xd9", 16  # of every JPEG and JPEG-LS stream, among so many last bytes: writers pad them
DECODED = (
    JPEGBaseline8Bit,
    JPEGExtended12Bit,
    JPEGLossless,
    JPEGLosslessSV1,
    JPEGLSLossless,
    JPEGLSNearLossless,
)
# What pydicom asks of a plugin: what it needs, beside the two functions below.
DECODER_DEPENDENCIES = dict.fromkeys(DECODED, ("simpleitk",))


def is_available(uid: str) -> bool:
    """Whether this decodes a transfer syntax."""
    return uid in DECODER_DEPENDENCIES


def decode_frame(src: bytes, runner: DecodeRunner) -> bytes:
    """The pixels of one compressed grey frame, as pydicom's `runner` describes them.

    GDCM reads files only: the frame is laid into a file of its own. Raises NotImplementedError for colour,
    ValueError or RuntimeError for a stream that is damaged.
    """
    if runner.samples_per_pixel != 1:
        raise NotImplementedError("colour is not decoded here")
    if END not in src[-PADDED:]:
        raise ValueError("the stream has no end")  # GDCM makes up the rest of a lossless one
    with TemporaryDirectory() as folder:
        path = Path(folder) / "frame.dcm"
        _single(src, runner).save_as(path, enforce_file_format=True)
        values = sitk.GetArrayFromImage(sitk.ReadImage(str(path), imageIO="GDCMImageIO"))
    return values.astype(np.dtype(runner.pixel_dtype)).tobytes()


def register_decoder() -> None:
    """Let pydicom decode by this whatever it cannot decode itself; again without effect."""
    for syntax in DECODED:
        decoder = get_decoder(syntax)
        if LABEL not in decoder.available_plugins:
            decoder.add_plugin(LABEL, (__name__, decode_frame.__name__))


def _single(src: bytes, runner: DecodeRunner) -> Dataset:
    """A file of this one frame, without a patient and without a place."""
    dataset = Dataset()
    dataset.file_meta = FileMetaDataset()
    dataset.file_meta.TransferSyntaxUID = UID(str(runner.transfer_syntax))
    dataset.SOPClassUID = dataset.file_meta.MediaStorageSOPClassUID = SecondaryCaptureImageStorage
    dataset.SOPInstanceUID = dataset.file_meta.MediaStorageSOPInstanceUID = UID("1.2.3")
    dataset.Rows, dataset.Columns = runner.rows, runner.columns
    dataset.SamplesPerPixel, dataset.PhotometricInterpretation = 1, "MONOCHROME2"
    dataset.BitsAllocated, dataset.BitsStored = runner.bits_allocated, runner.bits_stored
    dataset.HighBit, dataset.PixelRepresentation = runner.bits_stored - 1, runner.pixel_representation
    dataset.PixelData = encapsulate([src])
    dataset["PixelData"].VR, dataset["PixelData"].is_undefined_length = "OB", True
    return dataset
