"""A stage without an answer leaves a row with the reason: the study ends, and its report names it first.

The tiny study has one woman. The second one is she again, under another name: a copy of every file.
"""

import re
import shutil
from dataclasses import replace

import pandas as pd
import pytest
import yaml

from mammosim.io.missing import write_missing
from mammosim.study.jobs.completeness import missing_results

pytestmark = pytest.mark.workflow
WOMAN, OTHER = "small", "large"
CELL_MM = 15.0  # of scatter in the tiny study, which must divide its detectors
XRAYED = "results/xray/{v}/left/standard_gravity"
# Of what a list of settings is made of, one: what follows from another value is the same.
ONE_OF_EACH = {
    "mechanics": {
        "stress_free": {"methods": ["anderson"]},
        "sweep": {"youngs_modulus_kpa": [1.0]},
        "upright": {"skin_kpa": [0]},
    },
}


@pytest.fixture
def copied(finished, tmp_path):
    """The finished study in a folder of its own, where a test may go on with other settings."""
    shutil.copytree(finished.run, tmp_path / "run", symlinks=True)
    return replace(finished, run=tmp_path / "run")


@pytest.fixture
def two(copied):
    """The finished study of two women with the same results, which no table holds together yet."""
    results = copied.run / "results"
    for file in [path for path in results.rglob("*") if path.is_file()]:
        name = str(file.relative_to(results))
        if WOMAN in name and not name.startswith(("logs", "benchmarks")):
            copy_of_hers(file, results / name.replace(WOMAN, OTHER))
    return copied


def copy_of_hers(file, copy) -> None:
    """A file of one woman under the other's name, in its rows, too; as old as it is."""
    copy.parent.mkdir(parents=True, exist_ok=True)
    if file.suffix == ".csv":
        copy.write_text(re.sub(rf"\b{WOMAN}\b", OTHER, file.read_text()))
        shutil.copystat(file, copy)
    else:
        shutil.copy2(file, copy)


def asked(study, settings, *arguments: str):
    """Run snakemake with settings over those of the tiny study."""
    extra = study.run / "extra.yaml"
    extra.write_text(yaml.safe_dump(settings))
    files = ("--configfile", str(study.home / "config/smoke.yaml"), str(extra))
    result = study.snakemake(*files, *arguments)
    assert result.returncode == 0, result.stdout[-6000:]
    return result.stdout


def missing(study) -> pd.DataFrame:
    return pd.read_csv(study.run / "results/study/missing.csv", keep_default_na=False)


def begins(study) -> str:
    """What stands in the report before its third section."""
    report = (study.run / "results/study/report.html").read_text()
    return report[: report.index('id="volunteers"')]


def test_nothing_is_missing_of_the_published_study(finished):
    assert missing(finished).empty
    assert "Every result that was asked for is there." in begins(finished)


def test_a_detector_too_small_and_a_strategy_too_strong_are_rows_with_reasons(copied, tmp_path):
    """squash would press further than is allowed, which is said before the run."""
    field = pd.read_csv(copied.run / "results/study/field.csv").query("view == 'mammogram'")
    narrow = float(CELL_MM * (field.shadow_width_mm.iloc[0] // CELL_MM))
    strategies = yaml.safe_load((copied.home / "config/strategies_smoke.yaml").read_text())
    listed = tmp_path / "strategies.yaml"
    listed.write_text(yaml.safe_dump(strategies | {"squash": {"until": {"thickness_share": 0.3}}}))
    pressing = {"strategies_file": str(listed), "strategies": ["standard", "reduced", "squash"]}
    xray = {"field_mm": {"width": narrow}, "strategies": ["standard", "squash"]}
    tables = ("compression", "field", "image", "dose", "slices", "dose_routes")
    targets = [f"results/study/{name}.csv" for name in tables]
    said = asked(copied, {"compression": pressing, "xray": xray}, "--", *targets)
    assert "squash would press small to 13.5 mm" in said
    rows = {name: pd.read_csv(copied.run / f"results/study/{name}.csv") for name in tables}
    reasons = missing_results(rows, {}).set_index("reason").tables
    assert {reason.split(":")[0]: lacking for reason, lacking in reasons.items()} == {
        "mammogram small left standard gravity": "image, dose, slices, dose_routes",
        "compress small left squash gravity": "compression, field, image, dose",
    }
    image = rows["image"].set_index("strategy")
    assert "enlarge xray.field_mm" in image.outcome["standard"]
    assert rows["compression"].set_index("strategy").force_n[["standard", "reduced"]].gt(0).all()


def test_whatever_follows_from_a_missing_mesh_says_so_and_the_other_woman_is_complete(two):
    why = f"mesh {OTHER} prone: the surface is open"
    write_missing(two.run / f"results/meshes/{OTHER}/prone.vtu", why)
    before = (two.run / "results/study/report.html").read_bytes()
    said = asked(two, {"volunteers": [WOMAN, OTHER]} | ONE_OF_EACH, "--rerun-triggers", "mtime", "input")
    assert (two.run / "results/study/report.html").read_bytes() != before
    assert missing(two).reason.tolist() == [why]
    assert "One result could not be computed." in begins(two)
    assert why in begins(two)
    assert f"  {why}" in said.splitlines()[-20:]
    for name in ("compression", "image", "identification", "validation"):
        rows = pd.read_csv(two.run / f"results/study/{name}.csv")
        assert rows[rows.volunteer == WOMAN].drop(columns="outcome").notna().any(axis=1).all()
        assert (rows[rows.volunteer == OTHER].outcome == f"missing: {why}").any()
    for name in ("registration", "segmentation_overlap"):
        rows = pd.read_csv(two.run / f"results/study/{name}.csv").groupby("volunteer", sort=False)
        assert list(rows.size()) == 2 * [len(rows.get_group(WOMAN))], "nothing is missing before her mesh"


def test_slices_alone_are_missing_where_only_their_detector_is_too_small(two):
    file = two.run / XRAYED.format(v=OTHER)
    file = file.with_name(f"{file.name}_field.csv")
    rows = pd.read_csv(file)
    rows.loc[rows["view"] == "tomosynthesis", "outcome"] = "too wide by 4 mm"
    rows.to_csv(file, index=False)
    tables = ("results/study/slices.csv", "results/study/image.csv")
    asked(two, {"volunteers": [WOMAN, OTHER]}, "--rerun-triggers", "mtime", "--", *tables)
    slices, image = (pd.read_csv(two.run / name).set_index("volunteer") for name in tables)
    assert slices.outcome[OTHER] == f"missing: tomosynthesis {OTHER} left standard gravity: too wide by 4 mm"
    assert slices.cnr[WOMAN].gt(0).all()
    assert image.dose_mgy.notna().all()
    assert set(image.index) == {WOMAN, OTHER}
