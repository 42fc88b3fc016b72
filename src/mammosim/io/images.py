"""Images and label maps as NIfTI, NRRD or MetaImage files; coordinates stay in the patient frame LPS, mm.

Half a file, a wrong byte, or a frame that is not stated is rejected, whoever wrote the file.
"""

import errno
import re
from pathlib import Path
from typing import NoReturn

import numpy as np
import SimpleITK as sitk

from mammosim.core.errors import ImageError
from mammosim.core.volume import Grid, Image, LabelMap
from mammosim.io.atomic import replacing
from mammosim.io.headers import require_whole_metaimage, require_whole_nrrd
from mammosim.io.missing import require_there
from mammosim.io.nifti import is_nifti, read_nifti
from mammosim.io.whole import AGAIN, require_written, unpacked

ENDINGS = (".nii", ".nii.gz", ".nrrd", ".nhdr", ".mha", ".mhd")
# Of a message of ITK: where in its code, and at which address in memory.
ITK_OWN = re.compile(
    r"Exception thrown in SimpleITK \S+|\S+\.[ch]xx:\d+:|itk::ERROR:|ITK ERROR:|\w+\(0x[0-9a-f]+\):"
)
# How archives begin that are not unpacked here, and what a repository has in the place of large files.
ARCHIVES = (b"PK\3\4", b"7z\xbc\xaf", b"Rar!", b"\xfd7zX", b"\x28\xb5\x2f\xfd")
POINTER = b"vers"


def read_image(path: str | Path) -> Image:
    """Read an image file.

    path: `.nii`, `.nii.gz`, `.nrrd`, `.nhdr`, `.mha` or `.mhd`.
    Returns intensities (nz, ny, nx) float32 in the patient frame LPS, mm, axes permuted and flipped to the
    order (z, y, x), not resampled.

    Raises ImageError when the file is absent, unreadable, damaged, not placed in the patient, not a volume,
    or holds values that are no numbers; MissingResult when it says that the image is missing.
    """
    return image_of(_read(path))


def write_image(image: Image, path: str | Path) -> None:
    """Write `.nii.gz`, complete or not at all."""
    _write(itk_volume(image.grid, image.values.astype(np.float32, copy=False)), path)


def read_labels(path: str | Path) -> LabelMap:
    """Read labels from a file.

    path: as of `read_image`. Returns labels (nz, ny, nx) uint8, axes in the order (z, y, x).
    Raises ImageError as `read_image`, or for values other than 0, 1, .. 255.
    """
    volume = _read(path)
    values = sitk.GetArrayFromImage(volume)
    labels = values.astype(np.uint8)
    if not np.array_equal(labels, values):
        raise ImageError(
            f"{path} has values from {values.min():g} to {values.max():g}, not all whole numbers in 0..255; "
            "give a label map, or read it as an image"
        )
    return LabelMap(grid_of(volume), labels)


def write_labels(labels: LabelMap, path: str | Path) -> None:
    """Write `.nii.gz`, complete or not at all."""
    _write(itk_volume(labels.grid, labels.values.astype(np.uint8, copy=False)), path)


def itk_volume(grid: Grid, values: np.ndarray) -> sitk.Image:
    """The SimpleITK image of values (nz, ny, nx), which shares the frame LPS."""
    volume = sitk.GetImageFromArray(values)
    volume.SetSpacing(grid.spacing.tolist())
    volume.SetOrigin(grid.origin.tolist())
    volume.SetDirection(grid.direction.ravel().tolist())
    return volume


def grid_of(volume: sitk.Image) -> Grid:
    """Where the voxels of a SimpleITK volume are; its direction made orthonormal to machine precision."""
    U, _, Vt = np.linalg.svd(np.array(volume.GetDirection()).reshape(3, 3))
    nx, ny, nz = volume.GetSize()
    return Grid((nz, ny, nx), np.array(volume.GetSpacing()), np.array(volume.GetOrigin()), U @ Vt)


def image_of(volume: sitk.Image) -> Image:
    """The image, its axes permuted and flipped to rise towards left, posterior, superior; not resampled."""
    volume = sitk.DICOMOrient(volume, "LPS")
    return Image(grid_of(volume), sitk.GetArrayFromImage(volume).astype(np.float32))


def whole_volume(path: str | Path) -> sitk.Image:
    """What a file holds, of any number of dimensions where it is no NIfTI, its axes not turned.

    By its first bytes, whatever its name. Raises ImageError: not to be read, no image, cut short, a wrong
    checksum, or not placed in the patient.
    """
    try:
        return _checked(Path(path))
    except OSError as error:
        raise ImageError(
            f"{path} cannot be read: {error.strerror}; see to its permissions and disk"
        ) from None
    except (RuntimeError, ValueError, IndexError) as error:
        reason = " ".join(ITK_OWN.sub("", str(error)).split())
        raise ImageError(f"{path} is not a readable image; give .nii or .nii.gz ({reason})") from error


def _checked(path: Path) -> sitk.Image:
    with unpacked(path) as file:
        head = file.read(4)
    if not head:
        raise ImageError(f"{path} is empty; {AGAIN}")
    if is_nifti(head):
        return read_nifti(path)
    if head == b"NRRD":
        require_whole_nrrd(path)
    elif path.suffix.lower() in (".mha", ".mhd"):
        require_whole_metaimage(path)
    else:
        _reject(path, head)
    return sitk.ReadImage(str(path))


def _reject(path: Path, head: bytes) -> NoReturn:
    """Raise ImageError, which says what a file of another kind is, and what to give."""
    if head in ARCHIVES or ".tar" in path.suffixes or path.suffix.lower() == ".tgz":
        raise ImageError(f"{path} is an archive; unpack it and give what is in it, or give a .zip")
    if head == POINTER:
        raise ImageError(f"{path} is a pointer of git-lfs and not the file itself; fetch it by git lfs pull")
    raise ValueError("it is no NIfTI, NRRD or MetaImage file, and one of .dcm is given by its folder")


def _read(path: str | Path) -> sitk.Image:
    if not Path(path).is_file():
        raise ImageError(f"no image {path}; run the stage that makes it, or correct the path")
    require_there(path)
    volume = whole_volume(path)
    if volume.GetDimension() != 3 or volume.GetNumberOfComponentsPerPixel() != 1:
        raise ImageError(
            f"{path} has {volume.GetDimension()} dimensions and {volume.GetNumberOfComponentsPerPixel()} "
            "components per voxel; give one volume: 3 dimensions, 1 component"
        )
    _require_finite(sitk.GetArrayViewFromImage(volume), path)
    return sitk.DICOMOrient(volume, "LPS")


def _require_finite(values: np.ndarray, path: str | Path) -> None:
    if not np.issubdtype(values.dtype, np.floating):
        return
    if wrong := int(np.count_nonzero(~np.isfinite(values))):
        infinite = int(np.count_nonzero(np.isinf(values)))
        counts = {"NaN": wrong - infinite, "infinite": infinite}
        kinds = " and ".join(f"{n} {kind}" for kind, n in counts.items() if n)
        raise ImageError(
            f"{path}: {wrong} of {values.size} voxels are no numbers ({kinds}); export it again, or "
            "put numbers in their place"
        )


def _write(volume: sitk.Image, path: str | Path) -> None:
    with replacing(path) as temporary:
        try:
            sitk.WriteImage(volume, str(temporary), useCompression=True)
        except RuntimeError as error:
            raise OSError(
                errno.EIO, f"cannot be written ({' '.join(str(error).split())})", str(path)
            ) from None
        # ITK says nothing where it finds no room for the rest.
        values = sitk.GetArrayViewFromImage(volume)
        require_written(temporary, path, values.nbytes)
