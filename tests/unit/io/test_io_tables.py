"""Tables and small values come back as they were written, and never half written."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from mammosim.io.atomic import replacing
from mammosim.io.tables import HOLDING_DIGITS, read_json, read_table, write_json, write_table


def test_a_table_reads_back_bit_for_bit(tmp_path: Path) -> None:
    numbers = np.random.default_rng(1).standard_normal(100) * 10.0 ** np.arange(-50, 50)
    frame = pd.DataFrame({"force_n": numbers, "n": np.arange(100), "name": ["NA", "left"] * 50})
    write_table(frame, tmp_path / "forces.csv")
    pd.testing.assert_frame_equal(read_table(tmp_path / "forces.csv"), frame, check_exact=True)


def test_a_missing_number_reads_back_as_missing(tmp_path: Path) -> None:
    write_table(pd.DataFrame({"thickness_mm": [1.5, np.nan]}), tmp_path / "t.csv")
    assert read_table(tmp_path / "t.csv")["thickness_mm"].isna().tolist() == [False, True]


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
