"""Tables and small values come back as they were written, and never half written."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mammosim.core.errors import DamagedTable, TableError
from mammosim.io.atomic import replacing
from mammosim.io.tables import (
    HOLDING_DIGITS,
    read_json,
    read_rows,
    read_table,
    write_json,
    write_numbers,
    write_table,
)


def test_a_table_reads_back_bit_for_bit(tmp_path: Path) -> None:
    numbers = np.random.default_rng(1).standard_normal(100) * 10.0 ** np.arange(-50, 50)
    frame = pd.DataFrame({"force_n": numbers, "n": np.arange(100), "name": ["NA", "left"] * 50})
    write_table(frame, tmp_path / "forces.csv")
    pd.testing.assert_frame_equal(read_table(tmp_path / "forces.csv"), frame, check_exact=True)


def test_a_missing_number_reads_back_as_missing(tmp_path: Path) -> None:
    write_table(pd.DataFrame({"thickness_mm": [1.5, np.nan]}), tmp_path / "t.csv")
    assert read_table(tmp_path / "t.csv")["thickness_mm"].isna().tolist() == [False, True]


def test_a_name_of_digits_reads_back_as_text(tmp_path: Path) -> None:
    frame = pd.DataFrame({"volunteer": ["007", "12"], "side": ["left", "right"], "n": [7, 12]})
    write_table(frame, tmp_path / "t.csv")
    pd.testing.assert_frame_equal(read_table(tmp_path / "t.csv"), frame)
    named = pd.DataFrame({"load.paddle": ["1e5", "007", "NA", "true"], "n": [1, 2, 3, 4]})
    write_table(named, tmp_path / "named.csv")
    pd.testing.assert_frame_equal(read_rows(tmp_path / "named.csv", names=["load.paddle"]), named)


def test_values_read_back_in_the_order_written(tmp_path: Path) -> None:
    values = {"b": [1, 2.5], "a": {"x": 0.1 + 0.2, "text": "µ"}}
    write_json(values, tmp_path / "v.json")
    assert read_json(tmp_path / "v.json") == values
    assert list(read_json(tmp_path / "v.json")) == ["b", "a"]


def test_numpy_values_are_written_as_plain_ones(tmp_path: Path) -> None:
    write_json({"n": np.int64(3), "x": np.float64(0.1), "v": np.arange(2)}, tmp_path / "v.json")
    assert read_json(tmp_path / "v.json") == {"n": 3, "x": 0.1, "v": [0, 1]}


def test_nan_is_rejected_and_the_earlier_file_stays(tmp_path: Path) -> None:
    write_json({"x": 1}, tmp_path / "v.json")
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json({"x": float("nan")}, tmp_path / "v.json")
    assert read_json(tmp_path / "v.json") == {"x": 1}


def test_of_numbers_that_texts_quote_those_that_are_none_are_null(tmp_path: Path) -> None:
    given = {"a": 1.5, "b": float("nan"), "c": np.float64("inf"), "d": np.float32("-inf"), "e": None}
    write_numbers(given | {"f": 3, "g": "inf", "h": np.int64(2)}, tmp_path / "v.json")
    expected = {"a": 1.5, "b": None, "c": None, "d": None, "e": None, "f": 3, "g": "inf", "h": 2}
    assert read_json(tmp_path / "v.json") == expected


def _write_half(path: Path) -> None:
    with replacing(path) as temporary:
        temporary.write_text("half")
        assert temporary.name.endswith(".nii.gz")
        raise RuntimeError("midway")


def test_a_failed_write_leaves_the_earlier_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "image.nii.gz"
    path.write_text("earlier")
    with pytest.raises(RuntimeError, match="midway"):
        _write_half(path)
    assert [p.name for p in tmp_path.iterdir()] == ["image.nii.gz"]
    assert path.read_text() == "earlier"


def test_a_folder_replaces_a_folder(tmp_path: Path) -> None:
    folder = tmp_path / "series"
    for name in ("old.dcm", "new.dcm"):
        with replacing(folder) as temporary:
            temporary.mkdir()
            (temporary / name).touch()
    assert [p.name for p in folder.iterdir()] == ["new.dcm"]


def test_a_table_may_carry_the_digits_that_hold(tmp_path):
    rows = pd.DataFrame({"force_n": [1.23456789, 12345.678, np.nan], "draw": [1, 2, 3], "name": list("abc")})
    write_table(rows, tmp_path / "table.csv", digits=HOLDING_DIGITS)
    found = read_table(tmp_path / "table.csv")
    assert found.force_n.tolist()[:2] == [1.2346, 12346.0]
    assert found.draw.tolist() == [1, 2, 3]
    assert np.isnan(found.force_n[2])


ROWS = pd.DataFrame(
    {"force_n": [1.25, 2.5, np.nan], "name": ["left", 'the "right", one', "x"], "n": [1, 2, 3]}
)


@pytest.mark.parametrize("frame", [ROWS, ROWS[["force_n", "n"]], ROWS[["force_n"]].fillna(0)])
def test_a_table_that_is_cut_within_a_row_is_rejected(tmp_path: Path, frame: pd.DataFrame) -> None:
    write_table(frame, tmp_path / "t.csv")
    text = (tmp_path / "t.csv").read_text()
    for end in range(1, len(text)):
        if text[end - 1] == "\n":
            continue  # a table of fewer rows, which nothing tells from a whole one
        (tmp_path / "t.csv").write_text(text[:end])
        with pytest.raises(TableError, match=r"t\.csv (ends early, in row \d|has columns and no rows)"):
            read_table(tmp_path / "t.csv")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"t\.csv is empty; delete it and run the stage that makes it"),
        ("\n", "is empty"),
        ("a,b\n1,2\n3\n", "row 2 has 1 of 2 cells"),
        ("a,b\n1,2,3\n", "row 1 has 3 of 2 cells"),
        ('a,b\n"x, y",2\n3\n', "row 2 has 1 of 2 cells"),
        ("a,b\n", "has columns and no rows"),
    ],
)
def test_a_table_without_all_its_cells_is_rejected(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "t.csv").write_text(text)
    with pytest.raises(TableError, match=message):
        read_table(tmp_path / "t.csv")


@pytest.mark.parametrize("wrong", [b'a,name\n1,"left\n', b"a,name\n1,\xb3left\n", b"a,b\n1,2\n\xff\xfe,3\n"])
def test_a_table_with_a_wrong_byte_is_named(tmp_path: Path, wrong: bytes) -> None:
    (tmp_path / "t.csv").write_bytes(wrong)
    with pytest.raises(TableError, match=r"t\.csv( is damaged|: row)"):
        read_table(tmp_path / "t.csv")


def test_a_table_may_be_empty_where_that_is_meant(tmp_path: Path) -> None:
    write_table(pd.DataFrame(columns=["a", "b"]), tmp_path / "t.csv")
    assert read_table(tmp_path / "t.csv", may_be_empty=True).columns.tolist() == ["a", "b"]
    assert read_rows(tmp_path / "t.csv").empty


@pytest.mark.parametrize(
    "text", ["a,b\n1,2\n3,4", "a,b\r\n1,2\r\n3,4\r\n", "a,b\n1,2\n\n3,4\n\n", 'a,b\n1,2\n3,"4"']
)
def test_a_table_by_hand_may_end_as_editors_end_it(tmp_path: Path, text: str) -> None:
    (tmp_path / "t.csv").write_bytes(text.encode())
    assert read_table(tmp_path / "t.csv", by_hand=True).to_numpy().tolist() == [[1, 2], [3, 4]]


def test_values_that_are_cut_short_are_rejected(tmp_path: Path) -> None:
    write_json({"force_n": [1.5, 2.5], "name": "µ"}, tmp_path / "v.json")
    whole = (tmp_path / "v.json").read_bytes()
    for end in range(len(whole) - 2):  # the last two are the brace and the end of its line
        (tmp_path / "v.json").write_bytes(whole[:end])
        with pytest.raises(TableError, match=r"v\.json is cut short or damaged.*run the stage"):
            read_json(tmp_path / "v.json")


def test_a_table_that_is_gone_is_named_and_fails_its_reader(tmp_path: Path) -> None:
    """As one that is damaged: a table of the study that nobody finds is no result that is missing."""
    with pytest.raises(
        DamagedTable, match=r"gone\.csv cannot be read: No such file or directory; delete it and"
    ):
        read_table(tmp_path / "gone.csv")
    with pytest.raises(TableError, match=r"cannot be read: Is a directory") as caught:
        read_table(tmp_path, by_hand=True)
    assert not isinstance(caught.value, DamagedTable)
