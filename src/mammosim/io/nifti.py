"""NIfTI files (.nii, .nii.gz, versions 1 and 2, either byte order): where voxels are, and their values.

A header may place the voxels twice, by qform (a rotation) and by sform (a matrix), each with a code that is 0
where it says nothing. As nibabel, FSL and SPM do, the sform is taken where its code is not 0; but a file
whose two placements differ is rejected, since gravity and points are meant for one of them.
Definitions: https://nifti.nimh.nih.gov/pub/dist/src/niftilib/nifti1.h and nifti2.h.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import Any, Literal

import numpy as np
import SimpleITK as sitk

from mammosim.core.errors import ImageError
from mammosim.io.placement import LARGEST_DIFFERENCE_MM, apart_mm, require_rigid
from mammosim.io.whole import unpacked, voxels_of

# name: (format, offset in version 1), (format, offset in version 2)
FIELDS = {
    "dim": (("8i2", 40), ("8i8", 16)),
    "datatype": (("i2", 70), ("i2", 12)),
    "pixdim": (("8f4", 76), ("8f8", 104)),
    "vox_offset": (("f4", 108), ("i8", 168)),
    "scl_slope": (("f4", 112), ("f8", 176)),
    "scl_inter": (("f4", 116), ("f8", 184)),
    "xyzt_units": (("u1", 123), ("i4", 500)),
    "qform_code": (("i2", 252), ("i4", 344)),
    "sform_code": (("i2", 254), ("i4", 348)),
    "quatern": (("3f4", 256), ("3f8", 352)),
    "qoffset": (("3f4", 268), ("3f8", 376)),
    "srow": (("(3,4)f4", 280), ("(3,4)f8", 400)),
    "magic": (("S4", 344), ("S8", 4)),
}
SIZES = (348, 540)
Order = Literal["<", ">"]
TYPES = {
    2: "u1", 4: "i2", 8: "i4", 16: "f4", 64: "f8", 256: "i1", 512: "u2", 768: "u4", 1024: "i8", 1280: "u8",
}  # fmt: skip
LARGEST_START = 2**30
UNIT_MM = {1: 1000.0, 2: 1.0, 3: 1e-3}  # metres, millimetres, micrometres; 0: not stated
FLIPS = np.diag([-1.0, -1.0, 1.0])  # NIfTI's x rises to the right and y to anterior, ours to left, posterior
SIDES = ("left and right", "front and back", "head and feet")


def is_nifti(head: bytes) -> bool:
    """Whether the first 4 bytes of an unpacked file are those of a NIfTI header, or of Analyze 7.5."""
    return any(int.from_bytes(head[:4], order) in SIZES for order in ("little", "big"))


def read_nifti(path: str | Path) -> sitk.Image:
    """The one volume of a file, scaled, in LPS, mm.

    Raises ImageError: cut short or damaged, another number of volumes, no or two placements, sheared axes.
    """
    with unpacked(path) as file:
        head = file.read(4)
        order: Order = "<" if int.from_bytes(head, "little") in SIZES else ">"
        size = int.from_bytes(head, "little" if order == "<" else "big")
        header = _header(head + file.read(size - 4), order, size, path)
        shape, spacing, A = _shape(header, path), _spacing(header, path), _placement(header, path)
        dtype = _dtype(header, order, path)
        file.read(_gap(header, size, path))
        values = _scaled(voxels_of(file, shape, dtype, path), header)
    volume = sitk.GetImageFromArray(values)
    volume.SetSpacing(spacing.tolist())
    volume.SetOrigin(A[:, 3].tolist())
    volume.SetDirection(require_rigid(A[:, :3], shape[::-1], path).ravel().tolist())
    return volume


def _header(head: bytes, order: Order, size: int, path: str | Path) -> Any:
    """The fields of a header by name."""
    if len(head) < size:
        raise ImageError(f"{path} ends early, in its header; copy it again")
    version = SIZES.index(size)
    formats, offsets = zip(*(field[version] for field in FIELDS.values()))
    layout: Any = {"names": [*FIELDS], "formats": formats, "offsets": offsets, "itemsize": size}
    header = np.frombuffer(head, np.dtype(layout).newbyteorder(order))[0]
    if not header["magic"].startswith((b"n+1", b"n+2")):
        raise ImageError(
            f"{path} is the header of Analyze or of a NIfTI pair, which states no orientation or keeps its "
            "voxels elsewhere; save it as one file .nii or .nii.gz"
        )
    return header


def _shape(header: Any, path: str | Path) -> tuple[int, int, int]:
    """(nz, ny, nx) of the one volume; axes beyond the third may have one entry."""
    n = int(header["dim"][0])
    counts = [int(count) for count in header["dim"][1 : n + 1]]
    while len(counts) > 3 and counts[-1] == 1:
        counts.pop()
    if not 1 <= n <= 7 or min(counts) < 1:
        raise ImageError(f"{path}: its header is damaged: dimensions {header['dim'].tolist()}; copy it again")
    if len(counts) != 3:
        raise ImageError(
            f"{path} has {len(counts)} dimensions, {_by(counts)}; give one volume: 3 dimensions, 1 component"
        )
    nx, ny, nz = counts
    return nz, ny, nx


def _gap(header: Any, size: int, path: str | Path) -> int:
    """How many bytes stand between the header and the voxels: extensions, or 4."""
    start = float(header["vox_offset"])
    if not 0 <= start < LARGEST_START:
        raise ImageError(f"{path}: its header is damaged: voxels start at byte {start:g}; copy it again")
    return max(int(start) - size, 0) or 4


def _dtype(header: Any, order: Order, path: str | Path) -> np.dtype:
    if (code := int(header["datatype"])) not in TYPES:
        raise ImageError(
            f"{path} holds colours, complex or unusual numbers (NIfTI data type {code}); save one number per "
            "voxel as integers or floats"
        )
    return np.dtype(TYPES[code]).newbyteorder(order)


def _scaled(values: np.ndarray, header: Any) -> np.ndarray:
    """Values in the machine's byte order, times the header's slope, plus its intercept, where it has one."""
    values = values.astype(values.dtype.newbyteorder("="), copy=False)
    slope, shift = float(header["scl_slope"]), float(header["scl_inter"])
    if not (np.isfinite(slope) and np.isfinite(shift)) or slope == 0 or (slope, shift) == (1, 0):
        return values
    scaled: np.ndarray = values.astype(np.float32) * np.float32(slope) + np.float32(shift)
    return scaled


def _spacing(header: Any, path: str | Path) -> np.ndarray:
    """Distances (3,) mm of voxels along i, j, k."""
    given = header["pixdim"][1:4].astype(float)
    if not (np.isfinite(given).all() and given.min() > 0):
        sign = "negative spacing" if given.min() < 0 else "no spacing"
        raise ImageError(
            f"{path}: {sign} {_by(given)} in pixdim, which must be positive; it may hide a mirrored axis: "
            "export the image again"
        )
    spacing: np.ndarray = given * _unit_mm(header)
    return spacing


def _by(values: Iterable[float]) -> str:
    return " x ".join(f"{value:g}" for value in values)


def _unit_mm(header: Any) -> float:
    return UNIT_MM.get(int(header["xyzt_units"]) & 7, 1.0)


def _placement(header: Any, path: str | Path) -> np.ndarray:
    """Affine map (3, 4) from voxel (i, j, k) to LPS, mm: the sform where its code is set, else the qform."""
    spacing, counts = _spacing(header, path), header["dim"][1:4].tolist()
    S, Q = FLIPS @ header["srow"].astype(float) * _unit_mm(header), _qform(header, spacing)
    by_sform, by_qform = header["sform_code"] > 0, header["qform_code"] > 0
    if not (by_sform or by_qform):
        raise ImageError(
            f"{path} states no orientation: its sform and qform codes are 0; convert the scanner's own "
            "files again, e.g. with dcm2niix"
        )
    A = S if by_sform else Q
    if not np.isfinite(A).all():
        raise ImageError(f"{path}: its placement holds numbers that are not finite; export the image again")
    if by_sform:
        _require_spacing(require_rigid(S[:, :3], counts, path), S, spacing, counts, path)
    if by_sform and by_qform:
        _require_same(S, Q, counts, path)
    return A


def _qform(header: Any, spacing: np.ndarray) -> np.ndarray:
    """Affine map (3, 4) of the quaternion (a, b, c, d); k runs against it where pixdim[0] is -1."""
    b, c, d = header["quatern"].astype(float)
    a = np.sqrt(max(1 - b * b - c * c - d * d, 0))
    R = np.array(
        [
            [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
            [2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b)],
            [2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - b * b - c * c],
        ]
    ) / (a * a + b * b + c * c + d * d)
    step = spacing * [1, 1, -1 if header["pixdim"][0] < 0 else 1]
    return FLIPS @ np.column_stack([R * step, header["qoffset"].astype(float) * _unit_mm(header)])


def _require_spacing(
    unit: np.ndarray, S: np.ndarray, spacing: np.ndarray, counts: list[int], path: str | Path
) -> None:
    off = apart_mm(S, np.column_stack([unit * spacing, S[:, 3]]), counts)
    if off > LARGEST_DIFFERENCE_MM:
        raise ImageError(
            f"{path}: voxels are {_by(np.linalg.norm(S[:, :3], axis=0))} mm large by its sform and "
            f"{_by(spacing)} mm by its pixdim; convert the scanner's own files again"
        )


def _require_same(S: np.ndarray, Q: np.ndarray, counts: list[int], path: str | Path) -> None:
    off = apart_mm(S, Q, counts)
    if off <= LARGEST_DIFFERENCE_MM:
        return
    turn = (S[:, :3] / np.linalg.norm(S[:, :3], axis=0)) @ (Q[:, :3] / np.linalg.norm(Q[:, :3], axis=0)).T
    angle = np.degrees(np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1)))
    how = f"turned by {angle:.0f} degrees" if angle > 0.5 else "shifted"
    if np.linalg.det(turn) < 0:
        how = f"one mirrors {SIDES[int(np.argmin(np.diag(turn)))]}"
    raise ImageError(
        f"{path} is placed twice, and its sform and qform differ by up to {off:.0f} mm ({how}), the limit is "
        f"{LARGEST_DIFFERENCE_MM:g} mm; state which counts: fslorient -copysform2qform FILE, or "
        "-copyqform2sform (the scanner's own is usually the qform)"
    )
