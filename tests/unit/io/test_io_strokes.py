"""Strokes mean the same places as a table of points and as a label map of another program."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import SimpleITK as sitk

from mammosim.core.errors import ImageError, SegmentationError
from mammosim.core.labels import Label
from mammosim.core.volume import Grid
from mammosim.io.images import itk_volume
from mammosim.io.strokes import MOST_OF_A_TISSUE, read_strokes
from mammosim.io.tables import write_table

GRID = Grid((5, 6, 7), np.array([2.0, 3.0, 4.0]), np.array([-10.0, 20.0, 30.0]))
PAINTED = {Label.ADIPOSE: [(0, 1, 2), (4, 5, 6)], Label.MUSCLE: [(2, 0, 0)], Label.MARKER: [(1, 1, 1)]}


def painted(values: dict[int, list[tuple[int, int, int]]] = PAINTED, grid: Grid = GRID) -> sitk.Image:
    array = np.zeros(grid.shape, np.uint8)
    for value, voxels in values.items():
        array[tuple(np.array(voxels).T)] = value
    return itk_volume(grid, array)


def expected(grid: Grid = GRID) -> pd.DataFrame:
    rows = [
        (*grid.points(np.array([voxel], float))[0], label.tissue)
        for label, voxels in PAINTED.items()
        for voxel in voxels
    ]
    return pd.DataFrame(rows, columns=["x_mm", "y_mm", "z_mm", "tissue"])


def in_order(strokes: pd.DataFrame) -> pd.DataFrame:
    return strokes.sort_values(list(strokes.columns)).reset_index(drop=True)


def test_a_table_reads_back(tmp_path: Path) -> None:
    write_table(expected(), tmp_path / "s.csv")
    pd.testing.assert_frame_equal(read_strokes(tmp_path / "s.csv"), expected())


@pytest.mark.parametrize(
    ("text", "encoding"),
    [
        ("x_mm,y_mm,z_mm,tissue\n1.5,-2,3, Adipose \n", "utf-8-sig"),
        ("x_mm;y_mm;z_mm;tissue\n1,5;-2;3;ADIPOSE\n", "latin-1"),
        ("x_mm\ty_mm\tz_mm\ttissue\n1,5\t-2\t3\tadipose\n", "utf-16"),
        ("painted_by,x_mm,y_mm,z_mm,tissue\r\nJ\xf6rg,1.5,-2,3,adipose\r\n", "latin-1"),
    ],
)
def test_a_table_as_other_programs_save_it_means_the_same_strokes(tmp_path, text, encoding) -> None:
    (tmp_path / "s.csv").write_bytes(text.encode(encoding))
    assert read_strokes(tmp_path / "s.csv").to_dict("list") == {
        "x_mm": [1.5], "y_mm": [-2.0], "z_mm": [3.0], "tissue": ["adipose"],
    }  # fmt: skip


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"s\.csv is empty; its first line should be: x_mm,y_mm,z_mm,tissue"),
        ("x_mm,y_mm,z_mm,tissue\n", r"s\.csv has a header and no rows"),
        ("x_mm,y_mm,z_mm,label\n1,2,3,adipose\n", r"s\.csv lacks tissue; its header must be"),
        ("x_mm,y_mm,z_mm,tissue\n1,2,3,air\nforty,2,3,air\n", r"row 2 \(forty 2 3\) has no three finite"),
        ("x_mm,y_mm,z_mm,tissue\n1,inf,3,air\n", r"s\.csv: row 1 \(1 inf 3\.?0?\) has no three finite"),
        (
            "x_mm,y_mm,z_mm,tissue\n1,2,3,air\n1,2,3,fat\n",
            "row 2: unknown tissue 'fat'; did you mean adipose",
        ),
        (
            "x_mm,y_mm,z_mm,tissue\n1,2,3,glandulr\n",
            "row 1: unknown tissue 'glandulr'; did you mean glandular",
        ),
        ("x_mm,y_mm,z_mm,tissue\n1,2,3,\n", "row 1: unknown tissue ''; choose of: air, adipose"),
        ("x_mm,y_mm,z_mm,tissue\n1,2,3,lesion\n", "row 1: unknown tissue 'lesion'"),
        ('x_mm,y_mm,z_mm,tissue\n1,2,3,"adipose\n', r"s\.csv is no table"),
    ],
)
def test_a_faulty_table_is_named_with_the_row(tmp_path, text, message) -> None:
    (tmp_path / "s.csv").write_text(text)
    with pytest.raises(SegmentationError, match=message) as caught:
        read_strokes(tmp_path / "s.csv")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("ending", ["nii.gz", "nii", "nrrd", "mha"])
def test_a_label_map_painted_by_our_codes_gives_the_voxels_of_each_tissue(tmp_path, ending) -> None:
    sitk.WriteImage(painted(), str(tmp_path / f"painted.{ending}"))
    found = read_strokes(tmp_path / f"painted.{ending}")
    pd.testing.assert_frame_equal(in_order(found), in_order(expected()), atol=1e-4)


def test_a_label_map_along_other_axes_gives_the_same_places(tmp_path) -> None:
    sitk.WriteImage(sitk.DICOMOrient(painted(), "SAR"), str(tmp_path / "painted.nrrd"))
    pd.testing.assert_frame_equal(
        in_order(read_strokes(tmp_path / "painted.nrrd")), in_order(expected()), atol=1e-4
    )


def named(image: sitk.Image, *segments: tuple[str, int, int]) -> sitk.Image:
    """With the names, values and layers of segments, as 3D Slicer writes them."""
    for n, (name, value, layer) in enumerate(segments):
        told = {"Name": name, "LabelValue": str(value), "Layer": str(layer)}
        for key, text in told.items():
            image.SetMetaData(f"Segment{n}_{key}", text)
    return image


def test_segments_of_slicer_are_known_by_their_names_whatever_their_values(tmp_path) -> None:
    values = dict(zip((1, 2, 3), PAINTED.values()))
    volume = named(painted(values), ("Breast fat", 1, 0), ("Pectoral muscle", 2, 0), ("marker", 3, 0))
    sitk.WriteImage(volume, str(tmp_path / "p.seg.nrrd"))
    pd.testing.assert_frame_equal(
        in_order(read_strokes(tmp_path / "p.seg.nrrd")), in_order(expected()), atol=1e-4
    )


def test_segments_that_overlap_lie_in_layers(tmp_path) -> None:
    layers = [painted({1: voxels}) for voxels in PAINTED.values()]
    names = [(label.tissue, 1, layer) for layer, label in enumerate(PAINTED)]
    sitk.WriteImage(named(sitk.Compose(layers), *names), str(tmp_path / "p.seg.nrrd"))
    pd.testing.assert_frame_equal(
        in_order(read_strokes(tmp_path / "p.seg.nrrd")), in_order(expected()), atol=1e-4
    )


def test_a_segment_or_code_that_is_no_tissue_is_named(tmp_path) -> None:
    sitk.WriteImage(named(painted({1: [(0, 0, 0)]}), ("Jane Roe", 1, 0)), str(tmp_path / "p.seg.nrrd"))
    with pytest.raises(
        SegmentationError, match=r"p\.seg\.nrrd: the name of the segment with value 1 is of no tissue"
    ) as caught:
        read_strokes(tmp_path / "p.seg.nrrd")
    assert "roe" not in str(caught.value).lower()
    sitk.WriteImage(named(painted({2: [(0, 0, 0)]}), ("skin", 1, 0)), str(tmp_path / "p.seg.nrrd"))
    with pytest.raises(SegmentationError, match="value 2 is of no segment"):
        read_strokes(tmp_path / "p.seg.nrrd")
    for code in (Label.LESION, 9):
        sitk.WriteImage(painted({code: [(0, 0, 0)]}), str(tmp_path / "p.nii.gz"))
        with pytest.raises(
            SegmentationError, match=rf"value {code:d} is the code of no tissue; .* 1 adipose"
        ):
            read_strokes(tmp_path / "p.nii.gz")
    sitk.WriteImage(painted({}), str(tmp_path / "p.nii.gz"))
    with pytest.raises(SegmentationError, match=r"p\.nii\.gz: no voxel is painted"):
        read_strokes(tmp_path / "p.nii.gz")


def test_a_region_is_thinned_evenly_and_always_the_same(tmp_path) -> None:
    grid = Grid((40, 50, 60), np.ones(3), np.zeros(3))
    values = np.zeros(grid.shape, np.uint8)
    values[:20], values[30] = Label.ADIPOSE, Label.MUSCLE
    sitk.WriteImage(itk_volume(grid, values), str(tmp_path / "p.nii.gz"))
    found = read_strokes(tmp_path / "p.nii.gz")
    counts = found.tissue.value_counts()
    assert counts["adipose"] == counts["muscle"] == MOST_OF_A_TISSUE
    fat = found[found.tissue == "adipose"]
    assert not fat.duplicated().any()
    np.testing.assert_allclose(fat[["x_mm", "y_mm", "z_mm"]].mean(), [29.5, 24.5, 9.5], atol=0.2)
    pd.testing.assert_frame_equal(found, read_strokes(tmp_path / "p.nii.gz"))


def test_what_is_no_stroke_file_is_rejected(tmp_path) -> None:
    with pytest.raises(SegmentationError, match=r"no strokes .*absent\.csv; paint some"):
        read_strokes(tmp_path / "absent.csv")
    (tmp_path / "s.txt").write_text("")
    with pytest.raises(SegmentationError, match=r"unknown format '\.txt'; choose one of: \.csv, \.nii"):
        read_strokes(tmp_path / "s.txt")
    (tmp_path / "s.nrrd").write_bytes(b"NRRD0004\n")
    with pytest.raises(ImageError, match=r"s\.nrrd states no orientation: it has no field 'space'") as caught:
        read_strokes(tmp_path / "s.nrrd")
    assert "\n" not in str(caught.value)


def test_the_ending_of_a_table_may_be_in_capitals(tmp_path: Path) -> None:
    write_table(expected(), tmp_path / "s.csv")
    (tmp_path / "s.csv").rename(tmp_path / "S.CSV")
    pd.testing.assert_frame_equal(read_strokes(tmp_path / "S.CSV"), expected())
