"""Inputs that cannot be used are rejected in one clear message, and what earlier runs made stays."""

import shutil
from dataclasses import replace

import pandas as pd
import pytest
import yaml

pytestmark = pytest.mark.workflow
IMAGE = "results/images/small/prone.nii.gz"
OWN = "results/images/ada/prone.nii.gz"  # of no digital volunteer, who has no other images than her own
FIDUCIALS = "results/fiducials/small/prone.csv"


@pytest.fixture
def changed(finished, tmp_path):
    """Run one target with prone's row of the volunteer table changed; nothing may be lost."""

    def run(target: str, **change: str) -> str:
        table = pd.read_table(finished.home / "config/volunteers.tsv", dtype=str)
        volunteer = target.split("/")[2]
        table = table[table.volunteer == "small"].assign(volunteer=volunteer)
        table = table[table.position == "prone"] if target == OWN else table
        here = table.position == "prone"
        for column, value in change.items():
            table.loc[here, column] = value
        rows, extra = tmp_path / "volunteers.tsv", tmp_path / "extra.yaml"
        table.to_csv(rows, sep="\t", index=False)
        extra.write_text(yaml.safe_dump({"volunteer_table": str(rows), "volunteers": [volunteer]}))
        kept = finished.run / target
        before = kept.read_bytes() if kept.exists() else None
        smoke = finished.home / "config/smoke.yaml"
        result = finished.snakemake(target, "--configfile", str(smoke), str(extra))
        assert result.returncode != 0
        assert (kept.read_bytes() if kept.exists() else None) == before
        return result.stdout

    return run


@pytest.fixture
def series(finished, tmp_path):
    """A copy of the prone series that a test may damage."""
    copy = tmp_path / "series"
    shutil.copytree(finished.run / "results/raw/small/prone", copy)
    return copy


def test_a_missing_slice_is_found(changed, series):
    sorted(series.glob("*.dcm"))[20].unlink()
    message = changed(OWN, images=str(series))
    assert "ImageError" in message
    assert str(series) in message
    assert "lacks a slice" in message


def test_mixed_series_are_rejected(changed, series, finished):
    other = sorted((finished.run / "results/raw/small/supine").glob("*.dcm"))[0]
    shutil.copy(other, series / "other.dcm")
    assert "mixes 2 series" in changed(OWN, images=str(series))


def test_a_series_of_another_position_is_rejected(changed, finished, tmp_path):
    supine = shutil.copytree(finished.run / "results/raw/small/supine", tmp_path / "supine")
    message = changed(OWN, images=str(supine))
    assert "position 'prone' contradicts the PatientPosition tag 'HFS'" in message


def test_gravity_that_contradicts_the_position_is_rejected(changed):
    assert "contradicts 'prone'" in changed(IMAGE, gravity="0 1 0")


def test_three_chest_markers_are_too_few(changed, finished, tmp_path):
    listed = pd.read_csv(finished.run / "results/raw/small/prone_fiducials.csv")
    # A nipple clicked on a chest marker takes that marker from the chest.
    listed.loc[listed.name == "nipple_left", ["x_mm", "y_mm", "z_mm"]] = listed.loc[
        listed.name == "chest_1", ["x_mm", "y_mm", "z_mm"]
    ].to_numpy()
    path = tmp_path / "fiducials.csv"
    listed.to_csv(path, index=False)
    message = changed(FIDUCIALS, fiducials=str(path))
    assert "FiducialError" in message
    assert "chest" in message


def test_a_rejected_image_ends_the_run_before_anything_else_is_done(finished, series, tmp_path):
    """Though a fault later on stops its own branch only. Every other input is good."""
    sorted(series.glob("*.dcm"))[20].unlink()
    gravity = {"prone": "0 -1 0", "supine": "0 1 0"}
    images = {"prone": str(series), "supine": str(finished.run / "results/raw/small/supine")}
    raw = finished.run / "results/raw/small"
    rows = [
        {"volunteer": "ada", "position": p, "images": images[p], "fiducials": f"{raw}/{p}_fiducials.csv",
         "strokes": f"{raw}/{p}_strokes.csv", "gravity": gravity[p]}
        for p in images
    ]  # fmt: skip
    table, extra, run = tmp_path / "volunteers.tsv", tmp_path / "extra.yaml", tmp_path / "run"
    pd.DataFrame(rows).to_csv(table, sep="\t", index=False)
    pressed = {"thickness_mm": {"ada": 45.0}}
    values = {"volunteer_table": str(table), "volunteers": ["ada"], "compression": pressed}
    extra.write_text(yaml.safe_dump(values | {"validation": {"positions": []}}))
    run.mkdir()
    smoke = str(finished.home / "config/smoke.yaml")
    result = replace(finished, run=run).snakemake("--configfile", smoke, str(extra), "--keep-going")
    assert result.returncode != 0
    last = "\n".join(result.stdout.splitlines()[-20:])
    assert "check_input ada prone: ImageError" in last
    done = {path.parent.name for path in (run / "results/benchmarks").glob("*/*.tsv")}
    assert done <= {"check_input", "report195", "beams", "spectrum"}
