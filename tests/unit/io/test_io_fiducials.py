"""A list of points means the same places in every format."""

import json
from pathlib import Path

import numpy as np
import pytest

from mammosim.core.errors import FiducialError
from mammosim.core.fiducials import NAMES, Fiducials
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
    ("markups", "message"),
    [
        ([{"type": "Fiducial"}], "lists no point"),
        ([{"controlPoints": None}], "lists no point"),
        ([None], "is not a point list as 3D Slicer writes it; export it again$"),
        ("none", "is not a point list as 3D Slicer writes it; export it again$"),
        ([{"controlPoints": [None]}], "is not a point list as 3D Slicer writes it; export it again$"),
        (
            [{"controlPoints": [{"label": "chest_1", "position": [[1], [2], [3]]}]}],
            "chest_1 has no three finite numbers in mm; mark it again$",
        ),
        (
            [{"controlPoints": [{"label": "chest_1", "position": ["one", 2, 3]}]}],
            "chest_1 has no three finite numbers in mm; mark it again$",
        ),
    ],
)
def test_markups_of_another_shape_are_named_in_words(tmp_path: Path, markups: object, message: str) -> None:
    (tmp_path / "list.mrk.json").write_text(json.dumps({"markups": markups}))
    with pytest.raises(FiducialError, match=rf"list\.mrk\.json:? {message}"):
        read_fiducials(tmp_path / "list.mrk.json")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name,kind,x_mm,y_mm\na,chest,1,2\n", "lacks z_mm; its header must be"),
        (
            "name,kind,x_mm,y_mm,z_mm\nchest_1,chest,1,two,3\n",
            r"list\.csv: row 1 \(chest_1\) has no three finite numbers",
        ),
        ("name,kind,x_mm,y_mm,z_mm\nchest_1,chin,1,2,3\n", "unknown kind .*choose one of: chest, breast"),
        ("name,kind,x_mm,y_mm,z_mm\nchest_1,nipple,1,2,3\n", "kind 'nipple' contradicts the name 'chest_1'"),
        ("name,x_mm,y_mm,z_mm\nchest_1,1,2,3\nChest 1,1,2,4\n", "chest_1 stands twice.* unique"),
        ("name,x_mm,y_mm,z_mm\nchest_1,1,inf,3\n", "chest_1.* has no three finite numbers"),
        ("name,x_mm,y_mm,z_mm\nchest_1,1,2\n", "chest_1.* has no three finite numbers"),
        (
            "name,x_mm,y_mm,z_mm\nchest_1,1,2,3",
            r"last line has no end, and chest_2, .* missing: was it cut off",
        ),
        ("name,x_mm,y_mm,z_mm\n", "has a header and no rows"),
        (" , ,\n;\n", r"list\.csv is empty"),
        ("#\nchest_1,1,2\n", "row 1 has 3 cells and the header 1"),
        ('name,x_mm,y_mm,z_mm\n"chest_1,1,2,3\n', r"list\.csv is no table: .* quotation mark"),
        ("name,x_mm,y_mm,z_mm\nchest_1,1,5,2,3\n", "row 1 has 5 cells and the header 4; .* decimal points"),
        ("", r"list\.csv is empty; its first line should be: name,kind,x_mm,y_mm,z_mm"),
        (
            "label,l,p,s,defined\nchest_1,1,2,3,1\nchest_2,0,0,0,0\n",
            r"row 2 \(chest_2\) is not placed; place",
        ),
    ],
)
def test_a_faulty_list_is_rejected(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "list.csv").write_text(text)
    with pytest.raises(FiducialError, match=message):
        read_fiducials(tmp_path / "list.csv")


@pytest.mark.parametrize(
    ("text", "encoding"),
    [
        ("name,kind,x_mm,y_mm,z_mm\nchest_1 ,chest,1.5,-2,3\nNipple Left,nipple,0.5,1,2\n", "utf-8-sig"),
        ("name;kind;x_mm;y_mm;z_mm\nchest_1;chest;1,5;-2;3\nnipple-left;nipple;0,5;1;2\n", "utf-8"),
        ("name\tx_mm\ty_mm\tz_mm\nchest_1\t1,5\t-2\t3\nleft nipple\t0,5\t1\t2\n", "utf-16"),
        ("name,x_mm,y_mm,z_mm,note\nchest_1,1.5,-2,3,gr\xf6\xdfer\nnipple_left,0.5,1,2,,,\n", "latin-1"),
        ("label,r,a,s,defined\nchest_1,-1.5,2,3,1\nnipple_left,-0.5,-1,2,1\n", "utf-8"),
        ("label,l,p,s,defined\r\nchest_01,1.5,-2,3,1\r\nNIPPLE_LEFT,0.5,1,2,1\r\n", "utf-8"),
    ],
)
def test_a_table_as_other_programs_save_it_means_the_same_points(tmp_path: Path, text, encoding) -> None:
    (tmp_path / "list.csv").write_bytes(text.encode(encoding))
    found = read_fiducials(tmp_path / "list.csv")
    assert (found.names, found.kinds) == (("chest_1", "nipple_left"), ("chest", "nipple"))
    assert found.points.tolist() == [[1.5, -2.0, 3.0], [0.5, 1.0, 2.0]]


def test_a_list_without_an_end_of_its_last_line_is_whole_where_no_name_is_missing(tmp_path: Path) -> None:
    rows = "\n".join(f"{name},{n},0,0" for n, name in enumerate(NAMES))
    (tmp_path / "list.csv").write_text(f"name,x_mm,y_mm,z_mm\n{rows}")
    assert read_fiducials(tmp_path / "list.csv").names == NAMES


@pytest.mark.parametrize(
    ("header", "place"),
    [
        ("# CoordinateSystem = LPS\n", [1.5, -2.5, 3.5]),
        ("# CoordinateSystem=LPS\n", [1.5, -2.5, 3.5]),
        ("#CoordinateSystem = lps\n", [1.5, -2.5, 3.5]),
        ("# CoordinateSystem = 1\n", [1.5, -2.5, 3.5]),
        ("# CoordinateSystem = 0\n", [-1.5, 2.5, 3.5]),
        ("# CoordinateSystem=RAS\n# columns=label,x,y,z\n", [-1.5, 2.5, 3.5]),
        ("", [-1.5, 2.5, 3.5]),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1"])
def test_every_spelling_of_a_header_is_understood(tmp_path: Path, header, place, encoding) -> None:
    head = f"# Markups fiducial file version = 4.11\n{header}"
    row = "1,1.5,-2.5,3.5,0,0,0,1,1,1,0,nipple_left,gr\xf6\xdfer,\n"
    row = "nipple_left,1.5,-2.5,3.5\n" if "columns" in header else row
    (tmp_path / "list.fcsv").write_bytes((head + row).encode(encoding))
    assert read_fiducials(tmp_path / "list.fcsv").point("nipple_left").tolist() == place


def test_a_list_of_slicer_5_says_whether_a_point_was_placed(tmp_path: Path) -> None:
    rows = "1,1,2,3,0,0,0,1,1,1,0,chest_1,,,2,0\n2,0,0,0,0,0,0,1,1,1,0,chest_2,,,{},0\n"
    path = tmp_path / "list.fcsv"
    path.write_text("# CoordinateSystem = LPS\n" + rows.format(2))
    assert read_fiducials(path).names == ("chest_1", "chest_2")
    for status, words in ((0, "is not placed"), (1, "is not placed"), (3, "was skipped")):
        path.write_text("# CoordinateSystem = LPS\n" + rows.format(status))
        with pytest.raises(FiducialError, match=rf"list\.fcsv: row 2 \(chest_2\) {words}.*; place it, or"):
            read_fiducials(path)


def _markups(tmp_path: Path, point: dict, **about) -> Path:
    path = tmp_path / "list.mrk.json"
    point = {"label": "nipple_left", "position": [1, 2, 3]} | point
    path.write_text(json.dumps({"markups": [{"type": "Fiducial", "controlPoints": [point], **about}]}))
    return path


@pytest.mark.parametrize(
    ("point", "message"),
    [
        ({"positionStatus": "undefined", "position": [0, 0, 0]}, "nipple_left is not placed; place it"),
        ({"positionStatus": "preview"}, "nipple_left is not placed; place it"),
        ({"positionStatus": "missing"}, "nipple_left was skipped"),
        ({"position": None}, "nipple_left has no three finite numbers"),
        ({"position": [1, 2]}, "nipple_left has no three finite numbers"),
        ({"position": [float("nan")] * 3}, "nipple_left has no three finite numbers"),
        ({"position": [1, float("inf"), 2]}, "nipple_left has no three finite numbers"),
        ({"label": "F-1"}, "'F-1' is no name of a point; name the points chest_1"),
        ({"label": "nipple_lfet"}, "'nipple_lfet' is no name .* nipple_left is missing, did you mean that"),
    ],
)
def test_a_point_of_slicer_without_a_place_or_a_name_is_rejected(tmp_path: Path, point, message) -> None:
    with pytest.raises(FiducialError, match=rf"list\.mrk\.json: {message}"):
        read_fiducials(_markups(tmp_path, point))


@pytest.mark.parametrize(
    ("units", "mm"),
    [("mm", 1), ("um", 1e-3), ("cm", 10), ("m", 1000), (["um", "UCUM", "micrometer"], 1e-3)],
)
def test_the_unit_that_a_list_states_counts(tmp_path: Path, units, mm) -> None:
    found = read_fiducials(_markups(tmp_path, {}, coordinateUnits=units))
    np.testing.assert_allclose(found.points, [[mm, 2 * mm, 3 * mm]])
    with pytest.raises(FiducialError, match=r"unknown coordinateUnits 'inch'; choose one of: mm, um"):
        read_fiducials(_markups(tmp_path, {}, coordinateUnits="inch"))


def test_several_lists_in_one_file_are_one_list_and_other_markups_none(tmp_path: Path) -> None:
    point = {"label": "chest_1", "position": [1, 2, 3]}
    lists = [
        {"type": "Fiducial", "coordinateSystem": "LPS", "controlPoints": [point]},
        {"type": "Fiducial", "coordinateSystem": "RAS", "controlPoints": [point | {"label": "chest_2"}]},
        {"type": "Line", "controlPoints": [point | {"label": "L-1"}]},
    ]
    (tmp_path / "f.mrk.json").write_text(json.dumps({"markups": lists}))
    found = read_fiducials(tmp_path / "f.mrk.json")
    assert (found.names, found.points.tolist()) == (("chest_1", "chest_2"), [[1, 2, 3], [-1, -2, 3]])
    (tmp_path / "f.mrk.json").write_text(json.dumps({"markups": lists[2:]}))
    with pytest.raises(FiducialError, match=r"f\.mrk\.json lists no point"):
        read_fiducials(tmp_path / "f.mrk.json")


def test_an_unknown_format_or_absent_list_is_rejected(tmp_path: Path) -> None:
    (tmp_path / "list.txt").write_text("")
    with pytest.raises(FiducialError, match=r"unknown format '\.txt'; choose one of"):
        read_fiducials(tmp_path / "list.txt")
    with pytest.raises(FiducialError, match=r"no fiducial list .*absent\.csv"):
        read_fiducials(tmp_path / "absent.csv")


@pytest.mark.parametrize("name", ["list.csv", "list.fcsv", "list.mrk.json"])
def test_the_ending_of_a_file_may_be_in_capitals(tmp_path: Path, name: str) -> None:
    write_fiducials(LIST, tmp_path / name)
    (tmp_path / name).rename(tmp_path / name.upper())
    np.testing.assert_array_equal(read_fiducials(tmp_path / name.upper()).points, LIST.points)


def test_a_header_may_begin_with_a_number_sign(tmp_path: Path) -> None:
    (tmp_path / "list.csv").write_text("# name,x_mm,y_mm,z_mm\nchest_1,1,2,3\n")
    assert read_fiducials(tmp_path / "list.csv").point("chest_1").tolist() == [1, 2, 3]
