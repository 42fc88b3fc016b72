"""A list of points means the same places in every format."""

import json
from pathlib import Path

import numpy as np
import pytest

from mammosim.core.errors import FiducialError
from mammosim.core.fiducials import Fiducials
from mammosim.io.fiducials import read_fiducials, write_fiducials

LIST = Fiducials(
    ("chest_1", "breast_2", "nipple_left"),
    ("chest", "breast", "nipple"),
    np.random.default_rng(1).normal(scale=100, size=(3, 3)),
)


@pytest.mark.parametrize("name", ["list.csv", "list.fcsv", "list.mrk.json"])
def test_a_list_reads_back_exactly(tmp_path: Path, name: str) -> None:
    write_fiducials(LIST, tmp_path / name)
    back = read_fiducials(tmp_path / name)
    assert (back.names, back.kinds) == (LIST.names, LIST.kinds)
    np.testing.assert_array_equal(back.points, LIST.points)


def test_slicer_ras_becomes_lps(tmp_path: Path) -> None:
    (tmp_path / "ras.fcsv").write_text(
        "# Markups fiducial file version = 4.10\n# CoordinateSystem = 0\n"
        "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n"
        "vtkMRML_1,1.5,-2.5,3.5,0,0,0,1,1,1,0,nipple_left,,\n"
    )
    point = {"label": "nipple_left", "position": [1.5, -2.5, 3.5]}
    markups = {"markups": [{"coordinateSystem": "RAS", "controlPoints": [point]}]}
    (tmp_path / "ras.mrk.json").write_text(json.dumps(markups))
    for name in ("ras.fcsv", "ras.mrk.json"):
        assert read_fiducials(tmp_path / name).point("nipple_left").tolist() == [-1.5, 2.5, 3.5]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name,kind,x_mm,y_mm\na,chest,1,2\n", "lacks z_mm; its header must be"),
        ("name,kind,x_mm,y_mm,z_mm\nchest_1,chest,1,two,3\n", r"row 1 \(chest_1\) has no three numbers"),
        ("name,kind,x_mm,y_mm,z_mm\nchest_1,chin,1,2,3\n", "unknown kind .*choose one of: chest, breast"),
        ("name,kind,x_mm,y_mm,z_mm\na,chest,1,2,3\na,chest,1,2,4\n", "unique"),
    ],
)
def test_a_faulty_list_is_rejected(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "list.csv").write_text(text)
    with pytest.raises(FiducialError, match=message):
        read_fiducials(tmp_path / "list.csv")


def test_a_name_without_a_kind_is_rejected(tmp_path: Path) -> None:
    point = {"label": "F-1", "position": [1, 2, 3]}
    (tmp_path / "f.mrk.json").write_text(json.dumps({"markups": [{"controlPoints": [point]}]}))
    with pytest.raises(FiducialError, match=r"'F-1' begins with no kind; name the points chest_1"):
        read_fiducials(tmp_path / "f.mrk.json")


def test_an_unknown_format_or_absent_list_is_rejected(tmp_path: Path) -> None:
    (tmp_path / "list.txt").write_text("")
    with pytest.raises(FiducialError, match=r"unknown format '\.txt'; choose one of"):
        read_fiducials(tmp_path / "list.txt")
    with pytest.raises(FiducialError, match=r"no fiducial list .*absent\.csv"):
        read_fiducials(tmp_path / "absent.csv")
