"""A stage without an answer leaves a row with the reason: the study ends, and its report names it first."""

import shutil
from dataclasses import replace

import pandas as pd
import pytest
import yaml

from mammosim.io.missing import write_missing

pytestmark = pytest.mark.workflow
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


def test_a_detector_too_small_and_a_strategy_too_strong_are_reasons_on_the_first_page(copied, tmp_path):
    """The field holds one woman; no breast bears the force of squash."""
    field = pd.read_csv(copied.run / "results/study/field.csv").query("view == 'mammogram'")
    widths = field.set_index("volunteer").shadow_width_mm
    strategies = yaml.safe_load((copied.home / "config/strategies_smoke.yaml").read_text())
    listed, extra = tmp_path / "strategies.yaml", tmp_path / "extra.yaml"
    listed.write_text(yaml.safe_dump(strategies | {"squash": {"until": {"force_n": 5000.0}}}))
    pressing = {"strategies_file": str(listed), "strategies": ["standard", "reduced", "squash"]}
    xray = {"field_mm": {"width": float(widths.mean().round())}, "strategies": ["standard", "squash"]}
    extra.write_text(yaml.safe_dump({"compression": pressing, "xray": xray}))
    result = copied.snakemake("--configfile", str(copied.home / "config/smoke.yaml"), str(extra))
    assert result.returncode == 0, result.stdout[-6000:]
    reasons = missing(copied).set_index("reason").tables
    assert {reason.split(":")[0] for reason in reasons.index} == {
        "mammogram large left standard gravity",
        "compress small left squash gravity",
        "compress large left squash gravity",
    }
    (lacking,) = reasons[reasons.index.str.startswith("mammogram large")]
    assert {"dose", "image", "dose_routes", "slices", "conservation"} & set(lacking.split(", ")) == {
        *("dose", "image", "dose_routes", "slices")
    }
    first = begins(copied)
    assert "3 results could not be had." in first
    assert all(reason.split(":")[0] in first for reason in reasons.index)
    rows = pd.read_csv(copied.run / "results/study/image.csv").set_index(["volunteer", "strategy"])
    assert rows.dose_mgy["small", "standard"] > 0
    assert rows.outcome["large", "standard"].startswith("missing: mammogram large")
    assert "could not be had" in "\n".join(result.stdout.splitlines()[-20:])


def test_whatever_follows_from_a_missing_mesh_says_so_and_the_other_woman_is_complete(copied):
    why = "mesh large prone: the surface is open"
    write_missing(copied.run / "results/meshes/large/prone.vtu", why)
    before = {name: (copied.run / "results/study" / name).read_bytes() for name in ("report.html",)}
    result = copied.snakemake("--rerun-triggers", "mtime")
    assert result.returncode == 0, result.stdout[-6000:]
    assert (copied.run / "results/study/report.html").read_bytes() != before["report.html"]
    assert missing(copied).reason.tolist() == [why]
    assert why in begins(copied)
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
