"""Strokes that a person painted in an image: our CSV, or a label map of ITK-SNAP or 3D Slicer, as points.

In a label map 0 is what was not painted; other values are codes of core.labels, or those of segments, whose
names in the header of a `.seg.nrrd` mean what `data/label_names.csv` says. The air need not be painted:
segmentation knows it round the body.
"""

from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from pathlib import Path

import numpy as np
import pandas as pd
import SimpleITK as sitk

from mammosim.core.errors import SegmentationError
from mammosim.core.labels import Label
from mammosim.io.given import given_table, numbers
from mammosim.io.images import ENDINGS, grid_of, itk_volume, read_labels, whole_volume
from mammosim.io.label_codes import meaning_of
from mammosim.io.label_maps import segments_of
from mammosim.io.missing import require_there

AXES = ("x_mm", "y_mm", "z_mm")
COLUMNS = (*AXES, "tissue")
# What can be painted; a lesion is put into the phantom, and none of the tissues that are learnt.
TISSUES = tuple(label.tissue for label in Label if label is not Label.LESION)
# ASSUME: of a tissue that was painted over whole regions, so many voxels say what all of them do.
MOST_OF_A_TISSUE = 2000


def read_strokes(path: str | Path) -> pd.DataFrame:
    """Columns x_mm, y_mm, z_mm (LPS), tissue: the rows of a `.csv`, or the painted voxels of a label map.

    Of a tissue with more than MOST_OF_A_TISSUE painted voxels as many are taken, evenly in the order of the
    voxels. Raises SegmentationError, which names file, row and value: absent, empty, a column missing, no
    finite number, an unknown tissue or code; ImageError where a label map cannot be read.
    """
    path = Path(path)
    if not path.is_file():
        raise SegmentationError(f"no strokes {path}; paint some, or correct the path")
    require_there(path)
    if path.suffix.lower() == ".csv":
        return _from_table(path)
    if path.name.lower().endswith(ENDINGS):
        return _from_map(path)
    raise SegmentationError(
        f"{path}: unknown format {path.suffix!r}; choose one of: .csv, {', '.join(ENDINGS)}"
    )


def _from_table(path: Path) -> pd.DataFrame:
    table = given_table(path, error=SegmentationError, columns=COLUMNS)
    if missing := [name for name in COLUMNS if name not in table]:
        raise SegmentationError(f"{path} lacks {', '.join(missing)}; its header must be: {','.join(COLUMNS)}")
    points = numbers(table, AXES)
    if len(bad := np.flatnonzero(~np.isfinite(points).all(axis=1))):
        written = " ".join(str(table[name].iloc[bad[0]]) for name in AXES)
        raise SegmentationError(
            f"{path}: row {bad[0] + 1} ({written}) has no three finite numbers in mm; correct or delete it"
        )
    tissue = ["" if pd.isna(name) else str(name).lower() for name in table["tissue"]]
    for row, name in enumerate(tissue, 1):
        _require_known(name, f"{path}: row {row}")
    return pd.DataFrame(points, columns=list(AXES)).assign(tissue=tissue)


def _require_known(tissue: str, where: str) -> None:
    """Raise SegmentationError for a tissue that cannot be painted, with the one that may be meant."""
    if tissue not in TISSUES:
        meant = meaning_of(tissue)
        near = [meant] if meant in TISSUES else get_close_matches(tissue, TISSUES, n=1)
        advice = f"did you mean {near[0]}" if near else f"choose of: {', '.join(TISSUES)}"
        raise SegmentationError(f"{where}: unknown tissue {tissue!r}; {advice}")


def _from_map(path: Path) -> pd.DataFrame:
    """Raises SegmentationError where nothing is painted."""
    parts = [
        pd.DataFrame(points, columns=list(AXES)).assign(tissue=tissue) for tissue, points in _painted(path)
    ]
    if not parts:
        raise SegmentationError(f"{path}: no voxel is painted; paint some of each tissue")
    return pd.concat(parts, ignore_index=True)


def _painted(path: Path) -> Iterator[tuple[str, np.ndarray]]:
    """Each tissue that is painted, with points (n, 3) mm of its voxels."""
    volume = whole_volume(path)
    names = {(layer, code): meaning_of(name) for name, layer, code in segments_of(volume, path)}
    for number, labels in enumerate(_layers(path, volume)):
        values = sitk.GetArrayViewFromImage(labels)
        for value in np.unique(values[values != 0]).tolist():
            tissue = _tissue_of(value, number, names, path)
            voxels = np.argwhere(values == value)
            kept = np.linspace(0, len(voxels) - 1, min(len(voxels), MOST_OF_A_TISSUE)).round().astype(int)
            yield tissue, grid_of(labels).points(voxels[kept].astype(float))


def _layers(path: Path, volume: sitk.Image) -> list[sitk.Image]:
    """The layers of a label map: several where segments overlap in a `.seg.nrrd`."""
    if (n := volume.GetNumberOfComponentsPerPixel()) == 1:
        labels = read_labels(path)
        return [itk_volume(labels.grid, labels.values)]
    return [sitk.VectorIndexSelectionCast(volume, layer) for layer in range(n)]


def _tissue_of(value: int, layer: int, names: Mapping[tuple[int, int], str], path: Path) -> str:
    """The tissue of a painted value; names: of each segment its tissue. Raises SegmentationError."""
    if names and (layer, value) not in names:
        raise SegmentationError(
            f"{path}: value {value} is of no segment in the header; save the segmentation again"
        )
    if names:
        if names[layer, value] not in TISSUES:  # the name is free text, and maybe a patient's
            raise SegmentationError(
                f"{path}: the name of the segment with value {value} is of no tissue that is painted; rename "
                f"it to one of: {', '.join(TISSUES)}"
            )
        return names[layer, value]
    if value not in {int(label) for label in Label if label.tissue in TISSUES}:
        codes = ", ".join(f"{int(label)} {label.tissue}" for label in Label if label.tissue in TISSUES[1:])
        raise SegmentationError(f"{path}: value {value} is the code of no tissue; paint with {codes}")
    return Label(value).tissue
