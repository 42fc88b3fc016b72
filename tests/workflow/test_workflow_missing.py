"""A stage without an answer leaves a row with the reason: the study ends, and its report names it first."""

import shutil
from dataclasses import replace

import pandas as pd
import pytest
import yaml

from mammosim.io.missing import write_missing
from mammosim.study.jobs.completeness import missing_results

pytestmark = pytest.mark.workflow
CELL_MM = 15.0  # of scatter in the tiny study, which must divide its detectors
XRAYED = "results/xray/{v}/left/standard_gravity"


@pytest.fixture
def copied(finished, tmp_path):
    """The finished study in a folder of its own, where a test may go on with other settings."""
    shutil.copytree(finished.run, tmp_path / "run", symlinks=True)
    return replace(finished, run=tmp_path / "run")


def missing(study) -> pd.DataFrame:
    return pd.read_csv(study.run / "results/study/missing.csv", keep_default_na=False)


def begins(study) -> str:
    """What stands in the report before its third section."""
    report = (study.run / "results/study/report.html").read_text()
    return report[: report.index('id="volunteers"')]


def test_nothing_is_missing_of_the_published_study(finished):
    assert missing(finished).empty
    assert "Every result that was asked for is there." in begins(finished)


def test_the_field_holds_both_women_with_10_mm_to_spare(finished):
    """The tiny study has the detectors of the default one."""
    field = pd.read_csv(finished.run / "results/study/field.csv")
    assert set(field.volunteer) == {"small", "large"}
    assert field.outcome.tolist() == ["held"] * len(field)
    assert field.room_mm.min() > 10


def test_a_detector_too_small_and_a_strategy_too_strong_are_rows_with_reasons(copied, tmp_path):
    """The field holds one woman; squash would press further than is allowed, which is said before the run."""
    field = pd.read_csv(copied.run / "results/study/field.csv").query("view == 'mammogram'")
    between = float(CELL_MM * (field.shadow_width_mm.mean() // CELL_MM + 1))
    assert field.shadow_width_mm.min() < between < field.shadow_width_mm.max()
    strategies = yaml.safe_load((copied.home / "config/strategies_smoke.yaml").read_text())
    listed, extra = tmp_path / "strategies.yaml", tmp_path / "extra.yaml"
    listed.write_text(yaml.safe_dump(strategies | {"squash": {"until": {"thickness_share": 0.3}}}))
    pressing = {"strategies_file": str(listed), "strategies": ["standard", "reduced", "squash"]}
    xray = {"field_mm": {"width": between}, "strategies": ["standard", "squash"]}
    extra.write_text(yaml.safe_dump({"compression": pressing, "xray": xray}))
    tables = ("compression", "field", "image", "dose", "slices", "dose_routes")
    smoke, targets = str(copied.home / "config/smoke.yaml"), [f"results/study/{name}.csv" for name in tables]
    result = copied.snakemake("--configfile", smoke, str(extra), "--", *targets)
    assert result.returncode == 0, result.stdout[-6000:]
    assert "squash would press small to 13.5 mm" in result.stdout
    rows = {name: pd.read_csv(copied.run / f"results/study/{name}.csv") for name in tables}
    reasons = missing_results(rows, {}).set_index("reason").tables
    assert {reason.split(":")[0]: lacking for reason, lacking in reasons.items()} == {
        "mammogram large left standard gravity": "image, dose, slices, dose_routes",
        "compress small left squash gravity": "compression, field, image, dose",
        "compress large left squash gravity": "compression, field, image, dose",
    }
    standard = rows["image"].query("strategy == 'standard'").set_index("volunteer")
    assert standard.dose_mgy["small"] > 0
    assert "enlarge xray.field_mm" in standard.outcome["large"]


def test_whatever_follows_from_a_missing_mesh_says_so_and_the_other_woman_is_complete(copied):
    why = "mesh large prone: the surface is open"
    write_missing(copied.run / "results/meshes/large/prone.vtu", why)
    before = {name: (copied.run / "results/study" / name).read_bytes() for name in ("report.html",)}
    result = copied.snakemake("--rerun-triggers", "mtime")
    assert result.returncode == 0, result.stdout[-6000:]
    assert (copied.run / "results/study/report.html").read_bytes() != before["report.html"]
    assert missing(copied).reason.tolist() == [why]
    assert "One result could not be had." in begins(copied)
    assert why in begins(copied)
    assert f"  {why}" in result.stdout.splitlines()[-20:]
    for name in ("compression", "image", "identification", "validation"):
        rows = pd.read_csv(copied.run / f"results/study/{name}.csv")
        assert rows[rows.volunteer == "small"].drop(columns="outcome").notna().any(axis=1).all()
        assert (rows[rows.volunteer == "large"].outcome == f"missing: {why}").any()


def test_slices_alone_are_missing_where_only_their_detector_is_too_small(copied):
    file = copied.run / XRAYED.format(v="large")
    file = file.with_name(f"{file.name}_field.csv")
    rows = pd.read_csv(file)
    rows.loc[rows["view"] == "tomosynthesis", "outcome"] = "too wide by 4 mm"
    rows.to_csv(file, index=False)
    tables = ("results/study/slices.csv", "results/study/image.csv")
    result = copied.snakemake("--rerun-triggers", "mtime", "--", *tables)
    assert result.returncode == 0, result.stdout[-6000:]
    slices, image = (pd.read_csv(copied.run / name).set_index("volunteer") for name in tables)
    assert slices.outcome["large"] == "missing: tomosynthesis large left standard gravity: too wide by 4 mm"
    assert slices.cnr["small"].notna().all()
    assert image.dose_mgy.notna().all()
