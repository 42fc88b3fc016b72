"""Results that a stage could not give: every reader says why, and tables keep the rows that are there."""

import numpy as np
import pandas as pd
import pytest

from mammosim.core.errors import MissingResult, TableError
from mammosim.figures.status import notice
from mammosim.figures.style import new_figure
from mammosim.io.fiducials import read_fiducials
from mammosim.io.figures import missing_reason, write_figure
from mammosim.io.images import read_image, read_labels
from mammosim.io.meshes import read_cell_data, read_mesh, read_point_data
from mammosim.io.missing import require_there, write_missing
from mammosim.io.tables import read_json, read_rows, read_table, read_those_there, write_table
from mammosim.io.transforms import read_transform

WHY = 'press large left: no equilibrium above 20 mm, "half" of 3 N'
JOB = {"volunteer": "large", "side": "left"}


@pytest.mark.parametrize(
    ("name", "reader"),
    [
        ("a.nii.gz", read_image),
        ("a.nii.gz", read_labels),
        ("a.vtu", read_mesh),
        ("a.vtu", lambda path: read_point_data(path, "rest")),
        ("a.vtu", lambda path: read_cell_data(path, "J")),
        ("a.json", read_json),
        ("a.tfm", read_transform),
        ("a.csv", read_table),
        ("a.csv", read_fiducials),
        ("a.csv", lambda path: read_those_there([path, path])),
    ],
)
def test_every_reader_says_why_a_result_is_missing(tmp_path, name, reader):
    write_missing(tmp_path / name, WHY, job=JOB)
    with pytest.raises(MissingResult) as error:
        reader(tmp_path / name)
    assert str(error.value) == WHY


def test_a_table_is_read_without_the_rows_in_the_place_of_missing_results(tmp_path):
    there = pd.DataFrame({"volunteer": ["small"], "side": ["left"], "force_n": [1.5]})
    write_table(there, tmp_path / "small.csv")
    write_missing(tmp_path / "large.csv", WHY, job=JOB)
    both = pd.concat([read_rows(tmp_path / name) for name in ("small.csv", "large.csv")])
    write_table(both, tmp_path / "all.csv")
    pd.testing.assert_frame_equal(read_table(tmp_path / "all.csv"), there)
    (_, gone) = read_rows(tmp_path / "all.csv").to_dict("records")
    assert gone["outcome"] == f"missing: {WHY}"
    assert {name: gone[name] for name in JOB} == JOB, "whose result it is"
    pd.testing.assert_frame_equal(read_those_there([tmp_path / "large.csv", tmp_path / "small.csv"]), there)


def test_outcomes_that_are_no_missing_results_stay(tmp_path):
    for outcomes in (["converged", "failed: its start is missing: unstable"], [np.nan, np.nan]):
        rows = pd.DataFrame({"E": [1.0, 0.1], "outcome": outcomes})
        write_table(rows, tmp_path / "all.csv")
        pd.testing.assert_frame_equal(read_table(tmp_path / "all.csv"), rows)


def test_a_picture_says_why_another_one_is_missing(tmp_path):
    write_figure(notice(WHY), tmp_path / "gone.png", missing=WHY)
    write_figure(new_figure(1.0), tmp_path / "there.png")
    assert missing_reason(tmp_path / "gone.png") == WHY
    assert missing_reason(tmp_path / "there.png") is None
    assert WHY in " ".join(text.get_text().replace("\n", " ") for text in notice(WHY).texts)
    assert np.isfinite(notice(30 * WHY).get_size_inches()).all()


@pytest.mark.parametrize("reader", [require_there, read_image, read_mesh, read_json, read_transform])
def test_a_damaged_word_in_the_place_of_a_result_is_named(tmp_path, reader):
    """Cut short by a full disk, or with a byte of another file in it: one line, no fault of the program."""
    path = tmp_path / (
        "a.tfm" if reader is read_transform else "a.vtu" if reader is read_mesh else "a.nii.gz"
    )
    write_missing(path, WHY)
    whole = path.read_bytes()
    for damaged in (whole[:-4], whole[:20] + b"\xff" + whole[21:]):
        path.write_bytes(damaged)
        with pytest.raises(
            TableError, match=r"a\.\S+ should say why .* and is cut short or damaged"
        ) as error:
            reader(path)
        assert len(str(error.value).splitlines()) == 1


def test_what_cannot_be_opened_is_named(tmp_path):
    for path, why in ((tmp_path, "Is a directory"), (tmp_path / "none.json", "No such file")):
        with pytest.raises(TableError, match=rf"{path} cannot be read: {why}.*; run the stage that makes it"):
            require_there(path)
