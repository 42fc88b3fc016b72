"""A job without an answer says why in every output; a setting that cannot be meant, and a fault, stop it."""

from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest

from mammosim.core.errors import ConfigurationError, DamagedFile, MechanicsError, MissingResult
from mammosim.figures.style import new_figure
from mammosim.io.figures import missing_reason
from mammosim.io.tables import read_json, read_rows, write_table

JOB = {"volunteer": "ada", "side": "left", "youngs_modulus_kpa": "0.5"}


@pytest.fixture
def stage(script, monkeypatch):
    """_stage, which leaves the log of the tests alone."""
    module = script("_stage")
    monkeypatch.setattr(module._log, "to", lambda path, *, threads: None)
    return module


@pytest.fixture
def job(tmp_path):
    """A job of two wildcards with another name in tables, as Snakemake gives it to a script."""
    return SimpleNamespace(
        rule="soften",
        log=["job.log"],
        threads=1,
        wildcards={"v": "ada", "side": "left", "kpa": "0.5", "also": "-01234567"},
        output=[str(tmp_path / name) for name in ("row.csv", "shape.vtu", "figure.png", "figure.pdf")],
        params={"moduli": "gravity", "library": "0123", "solver": "4567"},
    )


def test_rows_are_told_apart_by_the_wildcards_under_the_names_of_their_columns(stage, job):
    with stage.run(job) as columns:
        assert columns == JOB
    with stage.run(SimpleNamespace(**vars(job) | {"wildcards": {"w": "ada", "p": "prone"}})) as columns:
        assert columns == {"volunteer": "ada", "position": "prone"}


def require_missing(job, reason):
    row, shape, figure, vector = job.output
    assert read_rows(row).to_dict("records") == [
        {**JOB, "youngs_modulus_kpa": 0.5, "outcome": f"missing: {reason}"}
    ]
    with pytest.raises(MissingResult) as error:
        read_json(shape)
    assert str(error.value) == missing_reason(figure) == reason
    assert Path(vector).read_bytes().startswith(b"%PDF"), "the notice, as the picture shows it"


def test_without_an_answer_every_output_says_whose_and_why_in_one_line(stage, job, capsys):
    with stage.run(job):
        raise MechanicsError("it slides\n  away")
    reason = "soften ada left 0.5: it slides away"
    require_missing(job, reason)
    assert f"no result here; all other jobs continue: {reason}" in capsys.readouterr().err


def test_what_is_missing_before_it_is_handed_on_as_it_was_said_first(stage, job, capsys):
    with stage.run(job):
        raise MissingResult("mesh ada prone: it is open")
    require_missing(job, "mesh ada prone: it is open")
    assert capsys.readouterr().err == "", "it was said where it happened"


@pytest.mark.parametrize(
    "error",
    [ConfigurationError("xray has no key 'kv'"), ValueError("a fault"), DamagedFile("mesh ends early")],
)
def test_a_setting_that_cannot_be_meant_and_a_fault_fail_the_job(stage, job, tmp_path, error):
    with pytest.raises(type(error), match=str(error)), stage.run(job):
        raise error
    assert list(tmp_path.iterdir()) == []


def test_settings_of_a_script_are_its_params_without_the_digests_of_code(stage, job):
    assert stage.settings(job) == {"moduli": "gravity"}


def test_a_table_of_parts_keeps_whole_numbers_and_the_reasons_of_parts_that_are_missing(script, tmp_path):
    (there, gone, out) = (str(tmp_path / name) for name in ("there.csv", "gone.csv", "all.csv"))
    write_table(
        pd.DataFrame({"volunteer": ["007"], "outcome": ["converged"], "draws": [123456], "mm": [2 / 3]}),
        there,
    )
    write_table(pd.DataFrame({"volunteer": ["ada"], "outcome": ["missing: it is open"]}), gone)
    script("table").main([gone, there], out)
    with open(out) as file:
        assert file.read().splitlines() == [
            *("volunteer,draws,mm,outcome", "ada,,,missing: it is open", "007,123456,0.66667,converged")
        ]


def test_a_picture_is_drawn_by_its_function_of_files_settings_and_job(script, monkeypatch, tmp_path):
    picture, given = script("picture"), []

    def drawn(files, told, job):
        given.extend([files, told, job])
        return new_figure(1.0)

    monkeypatch.setattr("drawn.xrays.phantom", drawn)
    parts = ({"labels": "a.nii.gz"}, {"behind_mm": 5.0}, {"side": "left"})
    picture.main("xrays.phantom", *parts, str(tmp_path / "there.png"))
    assert tuple(given) == parts
    assert missing_reason(tmp_path / "there.png") is None
