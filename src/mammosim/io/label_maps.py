"""Label maps as other programs write them, each voxel as a tissue.

A map is NIfTI, NRRD, MHA or MHD, or one of these in a `.zip`; its values are whole numbers of any type. A
DICOM segmentation is a file, or the only one in a folder or a zip. `.seg.nrrd` of 3D Slicer says by name what
its segments are, which may overlap. Codes are explained by a preset of `data/label_codes.csv`, by a table of
`code` and `tissue`, by a colour table of 3D Slicer, by a label description file of ITK-SNAP, or by the
`dataset.json` of nnU-Net. Names mean what `data/label_names.csv` says. Frame LPS, mm.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import SimpleITK as sitk

from mammosim.core.errors import ImageError
from mammosim.core.volume import Grid, LabelMap
from mammosim.io.dicom_files import File, dicom_files
from mammosim.io.images import ENDINGS, grid_of, whole_volume
from mammosim.io.label_codes import (
    ELSEWHERE,
    OWN,
    TISSUES,
    explained,
    fits,
    is_preset,
    of_names,
    presets,
)
from mammosim.io.missing import require_there
from mammosim.io.plain import repeated

SHOWN = 8  # codes that a message lists
SEGMENT = re.compile(r"Segment(\d+)_(?:ID|Name|Layer|LabelValue)")
ROUNDING = 1e-3  # of a code, by the slope that it was stored with
LARGEST = np.iinfo(np.int32)
GIVE = "give a preset, or a table of code and tissue"


@dataclass(frozen=True)
class CodedMap:
    """A label map as a file has it: codes (nz, ny, nx) int32 on a grid; names: of codes, where told.

    overlapping: voxels that lie in several segments, of which the smallest one is kept.
    """

    grid: Grid
    codes: np.ndarray
    path: str
    names: Mapping[int, str] = field(default_factory=dict)
    overlapping: int = 0

    @classmethod
    def of_segments(cls, grid: Grid, segments: Sequence[tuple[str, np.ndarray]], path: str) -> "CodedMap":
        """Of names with masks (nz, ny, nx), which may overlap: the n-th has the code n.

        Of those the smallest one is kept, as io.dicom_segmentation does.
        """
        codes, several = np.zeros(grid.shape, np.int32), np.zeros(grid.shape, bool)
        size = [np.count_nonzero(mask) for _, mask in segments]
        # ASSUME: of segments that overlap, the smaller one is a part of the larger one.
        for n in np.argsort(np.negative(size), kind="stable"):
            several |= segments[n][1] & (codes > 0)
            codes[segments[n][1]] = n + 1
        names = {n: name for n, (name, _) in enumerate(segments, 1)}
        return cls(grid, codes, path, names, int(np.count_nonzero(several)))

    @property
    def found(self) -> tuple[int, ...]:
        """The codes that some voxel has, lowest first."""
        return tuple(self.counts)

    @cached_property
    def counts(self) -> Mapping[int, int]:
        """How many voxels have each code, lowest first."""
        found, count = np.unique(self.codes, return_counts=True)
        return dict(zip(found.tolist(), count.tolist()))


def read_label_map(path: str | Path) -> CodedMap:
    """A label map, its axes as those of `io.images`.

    Raises ImageError: absent, unreadable, DICOM images, not one volume, or values that are no whole numbers.
    """
    if not Path(path).exists():
        raise ImageError(f"no label map {path}; correct the path")
    from mammosim.io.dicom_segmentation import holds_seg, read_seg  # pydicom: where a map is read only

    with dicom_files(path) as files:
        if Path(path).suffix.lower() == ".zip":
            inside = [file for file in files if file.name.lower().endswith(ENDINGS)]
            if len(inside) > 1:
                raise ImageError(f"{path} holds {len(inside)} label maps; give a zip of one, or unpack it")
            if inside:
                return _unpacked(files, inside[0], str(path))
        if holds_seg(files, str(path)):
            grid, codes, names, overlapping = read_seg(path)
            return CodedMap(grid, codes.astype(np.int32), str(path), names, overlapping)
        if Path(path).is_dir() or Path(path).suffix.lower() == ".zip" or any(map(_is_dicom, files)):
            raise ImageError(
                f"{path} holds no label map; give a DICOM segmentation, or one of: {', '.join(ENDINGS)}"
            )
    require_there(path)
    return _coded(whole_volume(path), str(path))


def tissue_map(coded: CodedMap, codes: str = "") -> LabelMap:
    """Each voxel's Label, or BREAST or IGNORE.

    codes: a preset, or a file that explains them; without it, names that the map's own file has, else OWN.
    Raises ImageError: a code is not explained, or its name is of no tissue; ConfigurationError: no such file.
    """
    meaning = meanings(coded, codes)
    whose = codes or (coded.path if coded.names else OWN)
    if unknown := [code for code in coded.found if code not in meaning]:
        raise ImageError(
            f"{coded.path}: {whose} has no tissue for {_listed(unknown)} of {_listed(coded.found, '')}; "
            f"in the column codes {GIVE} ({fits(coded.found)})"
        )
    if unnamed := [code for code in coded.found if not meaning[code]]:
        raise ImageError(
            f"{coded.path}: the name of {_listed(unnamed)} in {whose} is of no tissue; rename it to one of: "
            f"{', '.join(TISSUES)}; or in the column codes {GIVE}"
        )
    if ELSEWHERE in (meaning[code] for code in coded.found):
        raise ImageError(f"{coded.path}: {codes} has no breast; give it in one file with it, as segments")
    found = np.array(coded.found)
    values = np.array([TISSUES[meaning[code]] for code in coded.found], np.uint8)
    return LabelMap(coded.grid, values[np.searchsorted(found, coded.codes)])


def meanings(coded: CodedMap, codes: str) -> Mapping[int, str]:
    """Code -> tissue, '' for a name of none. Raises ConfigurationError as label_codes.explained."""
    if is_preset(codes):
        return presets()[codes]
    if codes:
        return explained(codes)
    return of_names(coded.names) if coded.names else presets()[OWN]


def _listed(codes: Sequence[int], word: str = "code") -> str:
    """'codes -5, 2', at most SHOWN of them; without a word the numbers alone."""
    numbers = ", ".join(map(str, codes[:SHOWN])) + (", ..." if len(codes) > SHOWN else "")
    return f"{word}{'s' * (len(codes) > 1)} {numbers}" if word else numbers


def _is_dicom(file: File) -> bool:
    with file.open() as opened:
        return opened.read(132)[128:] == b"DICM"


def _unpacked(files: Sequence[File], inside: File, path: str) -> CodedMap:
    """The map `inside` an archive, whose other files may hold its voxels."""
    with TemporaryDirectory() as folder:
        for file in files:
            place = _below(folder, file)
            place.parent.mkdir(parents=True, exist_ok=True)
            with file.open() as opened:
                place.write_bytes(opened.read())
        try:
            found = read_label_map(_below(folder, inside))
        except ImageError as error:  # the user knows the archive, and not where it was unpacked
            raise ImageError(str(error).replace(f"{folder}/", f"{path}: ")) from None
    return replace(found, path=path)


def _below(folder: str, file: File) -> Path:
    """Its place in a folder, also where an archive names it from the root."""
    return Path(folder, file.name.lstrip("/"))


def _coded(volume: sitk.Image, path: str) -> CodedMap:
    if volume.GetDimension() != 3:
        raise ImageError(f"{path} has {volume.GetDimension()} dimensions; give a label map of 3")
    segments = segments_of(volume, path)
    layers = volume.GetNumberOfComponentsPerPixel()
    if layers == 1:
        turned = sitk.DICOMOrient(volume, "LPS")
        names = {code: name for name, _, code in segments}
        return CodedMap(_grid(turned, path), _whole(sitk.GetArrayFromImage(turned), path), path, names)
    if not segments:
        raise ImageError(
            f"{path} has {layers} values per voxel and no segments; give a label map of one value"
        )
    turned = [
        sitk.DICOMOrient(sitk.VectorIndexSelectionCast(volume, layer), "LPS") for layer in range(layers)
    ]
    codes = [_whole(sitk.GetArrayFromImage(each), path) for each in turned]
    if beyond := [layer for _, layer, _ in segments if layer >= layers]:
        raise ImageError(
            f"{path}: a segment lies in layer {beyond[0]}, and layers are 0 to {layers - 1}; save the "
            "segmentation again"
        )
    masks = [(name, codes[layer] == code) for name, layer, code in segments]
    return CodedMap.of_segments(_grid(turned[0], path), masks, path)


def segments_of(volume: sitk.Image, path: str | Path) -> list[tuple[str, int, int]]:
    """Name, layer and code of each segment that 3D Slicer wrote, in its order.

    Before Slicer 4.11 each segment was 1 in a layer of its own. Raises ImageError: a layer or code that is no
    whole number, or that two segments have.
    """
    keys = set(volume.GetMetaDataKeys())
    numbers = sorted({int(match[1]) for key in keys if (match := SEGMENT.fullmatch(key))})
    found = []
    for place, n in enumerate(numbers):
        of = {
            key: volume.GetMetaData(f"Segment{n}_{key}")
            for key in ("Name", "Layer", "LabelValue")
            if f"Segment{n}_{key}" in keys
        }
        layer, code = of.get("Layer", "0" if "LabelValue" in of else str(place)), of.get("LabelValue", "1")
        if not (layer.strip().isdecimal() and code.strip().isdecimal()):
            raise ImageError(f"{path}: Segment{n} has no whole number as layer and code; save it again")
        found.append((of.get("Name", ""), int(layer), int(code)))
    if twice := repeated([each[1:] for each in found]):
        raise ImageError(f"{path}: two segments have layer and code {twice[0]}; save the segmentation again")
    return found


def _grid(volume: sitk.Image, path: str) -> Grid:
    """Where the voxels are. Raises ImageError where that is not finite."""
    numbers = (*volume.GetSpacing(), *volume.GetOrigin(), *volume.GetDirection())
    if not np.isfinite(numbers).all():
        raise ImageError(
            f"{path}: spacing, origin and axes must be finite numbers; export the label map again"
        )
    return grid_of(volume)


def _whole(values: np.ndarray, path: str) -> np.ndarray:
    """Codes (nz, ny, nx) int32. Raises ImageError unless all values are whole ones, within ROUNDING."""
    if not np.isfinite(values).all():
        raise ImageError(f"{path} has values that are no numbers; export the label map again")
    whole = values if np.issubdtype(values.dtype, np.integer) else np.rint(values)
    low, high = float(values.min()), float(values.max())
    if not np.allclose(whole, values, rtol=0, atol=ROUNDING):
        raise ImageError(
            f"{path} has values from {low:g} to {high:g} that are no whole numbers: is it an image?"
        )
    if low < LARGEST.min or high > LARGEST.max:
        raise ImageError(f"{path} has codes from {low:g} to {high:g}; give codes of at most 32 bits")
    codes: np.ndarray = whole.astype(np.int32)
    return codes
