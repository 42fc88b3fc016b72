"""An image as a raw DICOM series, one file per axial slice, as a T2 turbo spin echo leaves the scanner."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from pydicom.dataset import FileDataset, FileMetaDataset
from pydicom.uid import UID, ExplicitVRLittleEndian, MRImageStorage, generate_uid

from mammosim.core.errors import ConfigurationError, ImageError
from mammosim.core.volume import Image
from mammosim.io.atomic import replacing

# How the patient lies, head first. DICOM has no code for a tilted table; the series description names it.
PATIENT_POSITION: Mapping[str, str] = {"prone": "HFP", "supine": "HFS", "supine_tilted": "HFS"}
LARGEST = np.iinfo(np.uint16).max
# One fixed implementation, so that files do not depend on the version of the library that wrote them.
IMPLEMENTATION = generate_uid(entropy_srcs=["mammosim", "implementation"])


def write_series(
    folder: Path,
    image: Image,
    *,
    position: str,
    volunteer: str,
    echo_time_ms: float,
    repetition_time_ms: float,
) -> None:
    """Write slice_001.dcm, ... into a folder: intensities rounded to uint16, geometry at full precision.

    The same arguments give the same bytes: UIDs derive from volunteer and position, and no date is written.
    Raises ConfigurationError for a position that is not scanned, ImageError for intensities outside uint16.
    """
    if position not in PATIENT_POSITION:
        raise ConfigurationError(
            f"no scanner takes position {position!r}; choose one of: {', '.join(PATIENT_POSITION)}"
        )
    low, high = float(image.values.min()), float(image.values.max())
    if low < 0 or high > LARGEST:
        raise ImageError(f"intensities {low:g} to {high:g} exceed 0 to {LARGEST}; scale the image")
    with replacing(folder) as unfinished:
        unfinished.mkdir(parents=True)
        for k in range(image.grid.shape[0]):
            dataset = _slice(image, k, position, volunteer)
            dataset.EchoTime, dataset.RepetitionTime = _decimals(np.array([echo_time_ms, repetition_time_ms]))
            dataset.save_as(unfinished / f"slice_{k + 1:03d}.dcm", enforce_file_format=True)


def _slice(image: Image, k: int, position: str, volunteer: str) -> FileDataset:
    grid, study = image.grid, ("mammosim", volunteer)
    uid = generate_uid(entropy_srcs=[*study, position, f"slice {k}"])
    dataset = FileDataset("", {}, file_meta=_meta(uid), preamble=b"\0" * 128)
    dataset.SpecificCharacterSet = "ISO_IR 192"
    dataset.SOPClassUID, dataset.SOPInstanceUID = MRImageStorage, uid
    dataset.StudyInstanceUID = generate_uid(entropy_srcs=[*study, "study"])
    dataset.SeriesInstanceUID = generate_uid(entropy_srcs=[*study, position, "series"])
    # Each position is a session of its own: coordinates of two positions are not related.
    dataset.FrameOfReferenceUID = generate_uid(entropy_srcs=[*study, position, "frame"])
    dataset.Modality, dataset.Manufacturer = "MR", "mammosim"
    dataset.PatientID = dataset.PatientName = volunteer
    dataset.PatientSex, dataset.PatientPosition = "F", PATIENT_POSITION[position]
    dataset.StudyDescription, dataset.SeriesDescription = "digital volunteer", f"T2 TSE {position}"
    dataset.ScanningSequence, dataset.SequenceVariant, dataset.MRAcquisitionType = "SE", "SK", "2D"
    dataset.SeriesNumber, dataset.InstanceNumber = list(PATIENT_POSITION).index(position) + 1, k + 1
    _place(dataset, grid.points(np.array([[k, 0.0, 0.0]]))[0], grid.spacing, grid.direction)
    _fill(dataset, np.round(image.values[k]).astype("<u2"))
    return dataset


def _meta(uid: UID) -> FileMetaDataset:
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID = MRImageStorage, uid
    meta.TransferSyntaxUID, meta.ImplementationClassUID = ExplicitVRLittleEndian, IMPLEMENTATION
    meta.ImplementationVersionName = "MAMMOSIM"
    return meta


def _place(dataset: FileDataset, corner: np.ndarray, spacing: np.ndarray, direction: np.ndarray) -> None:
    dx, dy, dz = spacing
    dataset.ImagePositionPatient = _decimals(corner)
    dataset.ImageOrientationPatient = _decimals(direction.T[:2].ravel())
    dataset.PixelSpacing = _decimals(np.array([dy, dx]))  # DICOM: between rows first, then between columns
    dataset.SliceThickness, dataset.SpacingBetweenSlices = _decimals(np.array([dz, dz]))
    dataset.SliceLocation = _decimals(np.array([corner @ direction[:, 2]]))[0]


def _fill(dataset: FileDataset, pixels: np.ndarray) -> None:
    dataset.Rows, dataset.Columns = pixels.shape
    dataset.SamplesPerPixel, dataset.PhotometricInterpretation = 1, "MONOCHROME2"
    dataset.BitsAllocated, dataset.BitsStored, dataset.HighBit, dataset.PixelRepresentation = 16, 16, 15, 0
    dataset.PixelData = pixels.tobytes()
    dataset["PixelData"].VR = "OW"


def _decimals(values: np.ndarray) -> list[str]:
    """DICOM decimal strings of at most 16 characters, to 1e-8."""
    return [f"{value:.8f}".rstrip("0").rstrip(".") for value in values + 0.0]
