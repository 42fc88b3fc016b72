"""What a person reads of how files were read: who says so, and no name of a patient."""

import numpy as np
import pytest

from mammosim.core.volume import Grid, Image
from mammosim.io.dicom import Series
from mammosim.io.label_maps import CodedMap
from mammosim.io.understood import codes_read, orientation_read, series_read

GRID = Grid((1, 1, 4), np.full(3, 10.0), np.zeros(3))
CODES = np.array([[[0, 1, 1, 12]]], np.int32)


@pytest.mark.parametrize(
    ("codes", "names", "by", "found"),
    [
        ("", {}, "the program's own (preset mammosim)", "0: air, 1 cm3; 1: adipose, 2 cm3; 12: no tissue"),
        ("victre", {}, "preset victre, as the column codes", "0: air, 1 cm3; 1: adipose, 2 cm3; 12: no"),
        ("", {1: "Fat", 12: "Jane Roe"}, "names of its own segments", "1: adipose, 2 cm3; 12: no tissue"),
        ("none.tsv", {}, "as none.tsv says", "0: no tissue, 1 cm3"),
    ],
)
def test_each_code_is_told_with_its_tissue_and_who_says_so(codes, names, by, found):
    read = codes_read(CodedMap(GRID, CODES, "l.nii", names), codes)
    assert by in read["codes"]
    assert found in read["codes found"]
    assert "Roe" not in str(read)


def test_a_series_is_told_with_why_it_was_read():
    image = Image(GRID, np.zeros(GRID.shape, np.float32))
    scan = Series(image, None, "HFP", None, chosen="5: MR, 4 slices; 1 of 3 series of the folder or file")
    read = series_read(scan, series="t1 fs", gaps="resample")
    assert read["series"] == f"{scan.chosen}; as the column series says (t1 fs)"
    assert "interpolated onto an even grid, as the column gaps says" in read["gaps"]
    alone = series_read(scan, series="", gaps="")
    assert alone["series"].endswith("; the only volume there is")
    assert "would be rejected" in alone["gaps"]
    assert series_read(Series(image, None, None, None), series="", gaps="") == {}, "of an image file"


@pytest.mark.parametrize(
    ("path", "tag", "who"),
    [
        ("a.nii.gz", None, "as the header's sform or qform says"),
        ("a.nrrd", None, "as the file's header says"),
        ("a.dcm", None, "as the tags of the frames say"),
        ("series", "HFP", "as the tags of the slices say (HFP, head first, prone)"),
        ("series", "FFDR", "as the tags of the slices say (FFDR, feet first, on her right)"),
    ],
)
def test_who_says_where_her_head_is_depends_on_the_kind_of_file(path, tag, who):
    read = orientation_read(path, tag)
    assert who in read
    assert "listed points" not in read
    assert "the listed points were compared" in orientation_read(path, tag, listed=True)
