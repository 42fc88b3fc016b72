"""A small series of tests' own: six tilted slices of noise, to be changed slice by slice."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from pydicom import Dataset
from pydicom.dataset import FileMetaDataset
from pydicom.uid import EnhancedMRImageStorage, ExplicitVRLittleEndian, MRImageStorage, generate_uid

from mammosim.core.rigid import rotation
from mammosim.core.volume import Grid

GRID = Grid(
    (6, 5, 4), np.array([1.5, 1.25, 3.0]), np.array([-20.0, -30.0, 40.0]), rotation(np.array([0, 2.0, 0]))
)
VALUES = np.random.default_rng(1).integers(0, 1000, GRID.shape).astype(np.uint16)
Change = Callable[[int, Dataset], None]


def uid(*words: object) -> str:
    """The same UID for the same words."""
    return generate_uid(entropy_srcs=[str(word) for word in words])


def place(k: float) -> list[float]:
    """ImagePositionPatient of slice k, which may lie between two."""
    return GRID.points(np.array([[k, 0, 0]]))[0].round(6).tolist()


def slice_of(k: int, values: np.ndarray = VALUES) -> Dataset:
    """Slice k as a scanner writes it."""
    dataset = Dataset()
    dataset.file_meta = FileMetaDataset()
    dataset.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
    dataset.SOPClassUID = dataset.file_meta.MediaStorageSOPClassUID = MRImageStorage
    dataset.SOPInstanceUID = dataset.file_meta.MediaStorageSOPInstanceUID = uid("slice", k)
    dataset.SeriesInstanceUID, dataset.SeriesNumber, dataset.InstanceNumber = uid("series"), 5, k + 1
    dataset.PatientID, dataset.PatientPosition, dataset.Modality = "large", "HFP", "MR"
    dataset.PatientName, dataset.SeriesDescription = "Dent^Mavis", "T2 prone"
    dataset.SliceThickness = "3.0"
    dataset.ImagePositionPatient = place(k)
    dataset.ImageOrientationPatient = [*GRID.direction[:, 0].round(9), *GRID.direction[:, 1].round(9)]
    dataset.PixelSpacing = [GRID.spacing[1], GRID.spacing[0]]
    dataset.Rows, dataset.Columns = GRID.shape[1:]
    dataset.BitsAllocated = dataset.BitsStored = 16
    dataset.HighBit, dataset.PixelRepresentation = 15, 0
    dataset.SamplesPerPixel, dataset.PhotometricInterpretation = 1, "MONOCHROME2"
    dataset.PixelData = values[k].tobytes()
    dataset["PixelData"].VR = "OW"
    return dataset


def unchanged(k: int, dataset: Dataset) -> None:
    """Leave a slice as it is."""


def write(
    folder: Path, change: Change = unchanged, *, slices: Sequence[int] = range(6), start: int = 9
) -> Path:
    """Write slices, each changed; file names run against their order: only the position may decide."""
    folder.mkdir(parents=True, exist_ok=True)
    for k in slices:
        dataset = slice_of(k)
        change(k, dataset)
        save(dataset, folder / f"{start - k}.dcm")
    return folder


def save(dataset: Dataset, path: Path) -> Path:
    """Write one file."""
    dataset.save_as(path, enforce_file_format=True)
    return path


def item(**tags: object) -> Dataset:
    """An item of a sequence; a tag that is a Dataset becomes a sequence of it."""
    dataset = Dataset()
    for keyword, value in tags.items():
        setattr(dataset, keyword, [value] if isinstance(value, Dataset) else value)
    return dataset


def enhanced(order: Sequence[int] = range(6)) -> Dataset:
    """All slices in one file of the enhanced class, frames in this order."""
    dataset = slice_of(0)
    orientation, pixel = dataset.ImageOrientationPatient, dataset.PixelSpacing
    for keyword in ("ImagePositionPatient", "ImageOrientationPatient", "PixelSpacing", "SliceThickness"):
        delattr(dataset, keyword)
    dataset.SOPClassUID = dataset.file_meta.MediaStorageSOPClassUID = EnhancedMRImageStorage
    dataset.NumberOfFrames, dataset.PixelData = len(order), VALUES[list(order)].tobytes()
    dataset.SharedFunctionalGroupsSequence = [
        item(
            PlaneOrientationSequence=item(ImageOrientationPatient=orientation),
            PixelMeasuresSequence=item(PixelSpacing=pixel, SliceThickness=3.0),
        )
    ]
    dataset.PerFrameFunctionalGroupsSequence = [
        item(PlanePositionSequence=item(ImagePositionPatient=place(k))) for k in order
    ]
    return dataset
