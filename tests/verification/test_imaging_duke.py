"""A real prone series is segmented without a person: scored by contours that we drew in six of its slices.

The gland of those is what exceeds a threshold. In four other slices strands of gland were drawn by hand,
before anything was scored by them.
"""

import zipfile
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import ndimage
from skimage.draw import polygon2mask

from mammosim.core.labels import Label
from mammosim.core.volume import Image, LabelMap
from mammosim.imaging.segmentation import Settings, segment
from mammosim.io.dicom import read_series

ZIP = Path(__file__).parents[2].parent / "shared/data/duke_breast_mri_001_dicom.zip"
CONTOURS = Path(__file__).parent / "data/imaging_duke_001_contours.csv"
STRANDS = Path(__file__).parent / "data/imaging_duke_001_strands.csv"
LAST_ROW = 300  # where the contours end: what lies behind is not scored
BREAST = (Label.ADIPOSE, Label.GLANDULAR, Label.SKIN)
DEEP_VOXELS = 10  # 8 mm under the skin: nearer to it the fat suppression fails
FAT_VOXELS, BRIGHTER, LEAST_PIXELS = 12, 1.35, 25


@pytest.fixture(scope="module")
def series(tmp_path_factory) -> Image:
    """T1 with suppressed fat, of the first woman of Duke-Breast-Cancer-MRI."""
    if not ZIP.is_file():
        pytest.skip(f"the real series {ZIP.name} is not beside the checkout (shared/data)")
    folder = tmp_path_factory.mktemp("duke")
    with zipfile.ZipFile(ZIP) as archive:
        archive.extractall(folder, [name for name in archive.namelist() if name.endswith(".dcm")])
    return read_series(next(folder.rglob("*.dcm")).parent).image


def _regions(image: Image) -> dict[int, dict[str, np.ndarray]]:
    """Slice -> breast, gland and, where the pleura was drawn, muscle (ny, nx) bool."""
    found = {}
    for k, drawn in pd.read_csv(CONTOURS, comment="#").groupby("slice"):
        line = {
            name: image.grid.indices(points[["x_mm", "y_mm", "z_mm"]].to_numpy())[:, 1:]
            for name, points in drawn.groupby("contour")
        }
        shape = image.grid.shape[1:]
        breast = polygon2mask(shape, np.vstack([line["skin"], line["wall"][::-1]]))
        inner = ndimage.binary_erosion(breast, iterations=DEEP_VOXELS)
        found[int(k)] = {"breast": breast, "inner": inner, "glandular": _gland(image, int(k), inner)}
        if "pleura" in line:
            found[int(k)]["muscle"] = polygon2mask(shape, np.vstack([line["wall"], line["pleura"][::-1]]))
    return found


def _gland(image: Image, k: int, inner: np.ndarray) -> np.ndarray:
    """What is 1.35 times as bright as fat within 10 mm, seen by eye to be gland and vessels; no specks."""
    I = ndimage.gaussian_filter(image.values[k - 1 : k + 2].mean(axis=0).astype(float), 0.8)
    fat = inner
    for _ in range(4):
        level = ndimage.gaussian_filter(np.where(fat, I, 0), FAT_VOXELS) / np.maximum(
            ndimage.gaussian_filter(fat.astype(float), FAT_VOXELS), 1e-3
        )
        fat = inner & (1.15 * level > I)
    parts, _ = ndimage.label(inner & (BRIGHTER * level < I), np.ones((3, 3)))
    size = np.bincount(parts.ravel())
    size[0] = 0
    return (size >= LEAST_PIXELS)[parts]


def _strands(shape: tuple[int, int]) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """Slice -> what was looked at and what of it was drawn as gland, (ny, nx) bool each."""
    found = {}
    for k, drawn in pd.read_csv(STRANDS, comment="#").groupby("slice"):
        pieces = {n: piece[["row", "column", "width"]].to_numpy(float) for n, piece in drawn.groupby("piece")}
        seen = polygon2mask(shape, pieces.pop(0)[:, :2])
        found[int(k)] = seen, seen & np.any([_strand(piece, shape) for piece in pieces.values()], axis=0)
    return found


def _strand(piece: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Voxels (ny, nx) within half a width of a line through rows and columns (n, 3): row, column, width."""
    at = np.stack(np.indices(shape), axis=-1).astype(float)
    inside = np.zeros(shape, bool)
    for a, b in zip(piece[:-1, :2], piece[1:, :2]):
        along = np.clip((at - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        inside |= np.linalg.norm(at - a - along[..., None] * (b - a), axis=-1) <= piece[0, 2] / 2
    return inside


def _dice(labels: LabelMap, regions: dict[int, dict[str, np.ndarray]], name: str) -> float:
    """Of all slices in which a region was drawn."""
    both = all_ = 0
    for k, drawn in regions.items():
        if name in drawn:
            mine = np.isin(labels.values[k], BREAST if name == "breast" else Label[name.upper()])
            mine[LAST_ROW + 1 :] = False
            mine &= drawn["inner"] if name == "glandular" else True
            both += 2 * np.count_nonzero(mine & drawn[name])
            all_ += np.count_nonzero(mine) + np.count_nonzero(drawn[name])
    return both / all_


@pytest.mark.data
def test_breast_gland_and_muscle_of_a_real_woman_are_found_without_a_person(series) -> None:
    labels, regions = segment(series, settings=Settings()).labels, _regions(series)
    # Asked are 0.90, 0.75 and 0.74 (by atlases: Gubern-Merida, IEEE J Biomed Health Inform 19:349, 2015).
    # By these contours gland reaches 0.78; they were smoothed much as the segmentation is.
    assert _dice(labels, regions, "breast") > 0.90
    assert _dice(labels, regions, "glandular") > 0.75
    assert _dice(labels, regions, "muscle") > 0.74
    # Both readings of the strands, the threshold's and the hand's, agree by 0.64: lines 2 to 5 voxels wide,
    # drawn to about a voxel. One threshold and one hand are too few to say what can be reached by them.
    drawn = _strands(series.grid.shape[1:])
    mine = {k: (labels.values[k] == Label.GLANDULAR) & seen for k, (seen, _) in drawn.items()}
    both = sum(np.count_nonzero(mine[k] & gland) for k, (_, gland) in drawn.items())
    assert 2 * both / sum(mine[k].sum() + gland.sum() for k, (_, gland) in drawn.items()) > 0.58
    # Behind the breasts there is the thorax, up to the image's back.
    middle = labels.values[30:130, :, 120:320]
    assert (middle[:, -1] == Label.THORAX).all()
