"""NRRD (.nrrd, .nhdr) and MetaImage (.mha, .mhd) files: what their headers say of bytes, units and axes.

ITK reads the values. Here is checked what it does not look at: that all bytes are there and their
checksums right, that left and right are stated, that lengths are in mm and axes at right angles.
Definitions: https://teem.sourceforge.net/nrrd/format.html and https://itk.org/Wiki/MetaIO/Documentation.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mammosim.core.errors import ImageError
from mammosim.io.placement import require_rigid
from mammosim.io.whole import require_count, rest_of, unpacked

VECTOR = re.compile(r"\([^)]*\)|none")
NRRD_PACKED = {"raw": False, "gzip": True, "gz": True}
NRRD_BYTES = {
    "signed char": 1, "int8": 1, "int8_t": 1, "uchar": 1, "unsigned char": 1, "uint8": 1, "uint8_t": 1,
    "short": 2, "short int": 2, "signed short": 2, "signed short int": 2, "int16": 2, "int16_t": 2,
    "ushort": 2, "unsigned short": 2, "unsigned short int": 2, "uint16": 2, "uint16_t": 2,
    "int": 4, "signed int": 4, "int32": 4, "int32_t": 4, "uint": 4, "unsigned int": 4, "uint32": 4,
    "uint32_t": 4, "longlong": 8, "long long": 8, "long long int": 8, "signed long long": 8,
    "signed long long int": 8, "int64": 8, "int64_t": 8, "ulonglong": 8, "unsigned long long": 8,
    "unsigned long long int": 8, "uint64": 8, "uint64_t": 8, "float": 4, "double": 8,
}  # fmt: skip
NRRD_SPACES = (
    "left-posterior-superior",
    "lps",
    "right-anterior-superior",
    "ras",
    "left-anterior-superior",
    "las",
)
META_BYTES = {
    "CHAR": 1, "UCHAR": 1, "SHORT": 2, "USHORT": 2, "INT": 4, "UINT": 4, "LONG": 4, "ULONG": 4,
    "LONG_LONG": 8, "ULONG_LONG": 8, "FLOAT": 4, "DOUBLE": 8,
}  # fmt: skip
# ASSUME: programs pad what they do not pack by less than a hundredth.
PADDING = 0.01
# MetaIO reads keys by their case, takes 1 and 0 for what is not there, and true by its first letter.
META_MATRIX = ("TransformMatrix", "Rotation", "Orientation")
META_OFFSET = ("Offset", "Position", "Origin")
META_SPACING = ("ElementSpacing", "ElementSize")


@dataclass(frozen=True)
class Stored:
    """Where the voxels of a file stand, whether they are packed, and how many bytes they are."""

    file: Path
    skip: int
    packed: bool
    n_bytes: int

    def require_whole(self, path: str | Path) -> None:
        """Raises ImageError where bytes are missing or wrong; path: the file that the user named."""
        if not self.file.is_file():
            raise ImageError(f"{path} keeps its voxels in {self.file.name}, which is not there; copy both")
        if not self.packed:
            there = self.file.stat().st_size - self.skip
            require_count(self.file, there, self.n_bytes, slack=int(PADDING * self.n_bytes))
            return
        with unpacked(self.file, skip=self.skip, packed=True) as file:
            require_count(self.file, rest_of(file), self.n_bytes)


def require_whole_nrrd(path: Path) -> None:
    """Raises ImageError: cut short, damaged, no known frame, not in mm, axes not at right angles."""
    header, end = _nrrd_header(path)
    if (space := header.get("space", "").lower()) not in NRRD_SPACES:
        stated = f"space is {space!r}" if space else "it has no field 'space'"
        raise ImageError(f"{path} states no orientation: {stated}; save it with 3D Slicer or ITK")
    if any(unit.strip('"') != "mm" for unit in header.get("space units", "").split()):
        raise ImageError(f"{path}: space units are {header['space units']}, not mm; save it in mm")
    _nrrd_stored(path, header, end).require_whole(path)
    vectors = VECTOR.findall(header.get("space directions", ""))
    steps = {n: v for n, v in enumerate(vectors) if v != "none"}  # none: of an axis of segments or colours
    if len(steps) != 3:
        raise ImageError(
            f"{path} states no orientation: its space directions are not 3 vectors; save it with 3D Slicer "
            "or ITK"
        )
    _require_origin(header, path)
    axes = np.column_stack([np.array(v.strip("()").split(","), float) for v in steps.values()])
    counts = header["sizes"].split()
    require_rigid(axes, [int(counts[n]) for n in steps], path)


def _require_origin(header: Mapping[str, str], path: Path) -> None:
    """Raise ImageError where the place of the first voxel, if it is stated, is not 3 finite numbers."""
    try:
        origin = np.array(header.get("space origin", "(0,0,0)").strip("()").split(","), float)
    except ValueError:
        origin = np.zeros(0)
    if len(origin) != 3 or not np.isfinite(origin).all():
        raise ImageError(f"{path}: space origin must be 3 finite numbers; export the image again")


def _nrrd_header(path: Path) -> tuple[dict[str, str], int]:
    """Fields by their names in small letters, and where the header ends."""
    header: dict[str, str] = {}
    end = 0
    with path.open("rb") as file:
        for line in file:
            end += len(line)
            text = line.decode("utf-8", "replace").strip()
            if not text:
                return header, end
            if not text.startswith("#") and ": " in text:
                name, value = text.split(": ", 1)
                header[name.lower()] = value.strip()
    return header, end


def _nrrd_stored(path: Path, header: Mapping[str, str], end: int) -> Stored:
    name = header.get("data file", header.get("datafile"))
    packing = header.get("encoding", "").lower()
    several = name is not None and ("%" in name or name.split()[:1] == ["LIST"])
    if packing not in NRRD_PACKED or several:
        raise ImageError(
            f"{path}: encoding {packing!r} or voxels in several files cannot be checked; save it as one "
            ".nrrd, raw or gzip"
        )
    n = int(np.prod([int(n) for n in _need(path, header, "sizes").split()], dtype=float))
    if (kind := _need(path, header, "type").lower()) not in NRRD_BYTES:
        raise ImageError(f"{path}: no number has the type {kind!r}; save it as integers or floats")
    n_bytes = n * NRRD_BYTES[kind]
    file = path.parent / name if name else path
    skip = 0 if name else end
    with file.open("rb") if file.is_file() else path.open("rb") as lines:
        lines.seek(skip)
        skip += sum(len(lines.readline()) for _ in range(int(header.get("line skip", "0"))))
    given = int(header.get("byte skip", "0"))
    skip = file.stat().st_size - n_bytes if given == -1 and file.is_file() else skip + given
    return Stored(file, max(skip, 0), NRRD_PACKED[packing], n_bytes)


def require_whole_metaimage(path: Path) -> None:
    """Raises ImageError: cut short, damaged, no axes stated or not at right angles, not in mm."""
    header, end = _meta_header(path)
    if (unit := header.get("DistanceUnits", "mm").strip("?").lower()) not in ("", "mm"):
        raise ImageError(f"{path}: DistanceUnits is {unit}, not mm; save it in mm")
    counts = [int(n) for n in _need(path, header, "DimSize").split()]
    spacing = _meta_spacing(header, path)
    if spacing.min() <= 0:
        raise ImageError(
            f"{path}: ElementSpacing {spacing.tolist()} must be positive; export the image again"
        )
    stored = _meta_stored(path, header, end, counts)
    stored.require_whole(path)
    if stored.packed:
        _require_packed_size(header, stored.file.stat().st_size - stored.skip, path)
    matrix = next((header[name] for name in META_MATRIX if name in header), None)
    if matrix is None:
        raise ImageError(
            f"{path} states no orientation: it has no TransformMatrix; save it with 3D Slicer or ITK"
        )
    _require_offset(header, len(counts), path)
    if len(counts) == len(spacing) == 3 and len(matrix.split()) == 9:
        require_rigid(np.array(matrix.split(), float).reshape(3, 3).T * spacing, counts, path)


def _require_offset(header: Mapping[str, str], n: int, path: Path) -> None:
    """Raise ImageError where the place of the first voxel is not n finite numbers: ITK takes 0 0 0 then."""
    for name in META_OFFSET:
        try:
            numbers = np.array(header.get(name, n * "0 ").split(), float)
        except ValueError:
            numbers = np.zeros(0)
        if len(numbers) != n or not np.isfinite(numbers).all():
            raise ImageError(f"{path}: {name} must be {n} finite numbers; export the image again")


def _meta_header(path: Path) -> tuple[dict[str, str], int]:
    """Its fields up to ElementDataFile, which is the last, and where the header ends."""
    header: dict[str, str] = {}
    end = 0
    with path.open("rb") as file:
        for line in file:
            end += len(line)
            name, _, value = line.decode("utf-8", "replace").partition("=")
            header[name.strip()] = value.strip()
            if "ElementDataFile" in header:
                break
    return header, end


def _meta_stored(path: Path, header: Mapping[str, str], end: int, counts: list[int]) -> Stored:
    name = _need(path, header, "ElementDataFile")
    kind = _need(path, header, "ElementType").removeprefix("MET_").removesuffix("_ARRAY")
    several = "%" in name or name.split()[:1] == ["LIST"]
    if kind not in META_BYTES or not _is_true(header.get("BinaryData", "True")) or several:
        raise ImageError(
            f"{path}: voxels as text, in several files or of type {kind} cannot be checked; save one .mha"
        )
    channels = int(header.get("ElementNumberOfChannels", "1"))
    n_bytes = int(np.prod(counts, dtype=float)) * channels * META_BYTES[kind]
    local = name.upper() == "LOCAL"
    file = path if local else path.parent / name
    skip = (end if local else 0) + max(int(header.get("HeaderSize", "0")), 0)
    if int(header.get("HeaderSize", "0")) == -1 and file.is_file():
        skip = file.stat().st_size - n_bytes
    packed = _is_true(header.get("CompressedData", "False"))
    return Stored(file, max(skip, 0), packed, n_bytes)


def _is_true(value: str) -> bool:
    return value[:1] in ("T", "t", "1")


def _meta_spacing(header: Mapping[str, str], path: Path) -> np.ndarray:
    """Distances of voxels, mm. Raises ImageError where none is stated."""
    given = next((header[name] for name in META_SPACING if name in header), None)
    if given is None:
        raise ImageError(f"{path} states no voxel size: it has no ElementSpacing; export the image again")
    return np.array(given.split(), float)


def _require_packed_size(header: Mapping[str, str], there: int, path: Path) -> None:
    """Raise ImageError unless the header says how many bytes are packed: MetaIO unpacks no others."""
    given = header.get("CompressedDataSize", "")
    if given != str(there):
        stated = f"states {given}" if given else "states none"
        raise ImageError(
            f"{path}: {there} packed bytes are there, and its CompressedDataSize {stated}; export it again, "
            "or copy it again"
        )


def _need(path: Path, header: Mapping[str, str], name: str) -> str:
    if name not in header:
        raise ImageError(f"{path} ends early or is damaged: its header has no {name!r}; copy it again")
    return header[name]
