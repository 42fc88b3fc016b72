"""Campaigns on the tiny configuration: a table, a page, only what is added is computed, faults come first."""

import json
import re

import pandas as pd
import pytest
import yaml
from whole_study import with_words_for_scripts

pytestmark = pytest.mark.workflow
CAMPAIGN = """
title: How much exposure does the machine choose?
vary:
  xray.peak_kv: [26, 30, 3]
  xray.field_mm.width: [240, 40] # no breast is as narrow as that
asked: [exposure_mas]
"""
KV, WIDTH = "xray.peak_kv", "xray.field_mm.width"


def write(study, text=CAMPAIGN):
    (study.home / "config/campaigns/mine.yaml").write_text(text)


def run(study, *arguments):
    result = study.snakemake("campaign_mine", *arguments)
    assert result.returncode == 0, result.stdout[-4000:]
    return pd.read_csv(study.run / "results/campaigns/mine.csv", dtype={"point": str})


@pytest.fixture(scope="module")
def campaign(finished):
    """The study after the campaign has run in it, and its table."""
    write(finished)
    return finished, run(finished)


def test_every_point_has_an_answer_or_a_reason(campaign):
    study, table = campaign
    assert list(table.columns[:5]) == ["volunteer", "side", KV, WIDTH, "exposure_mas"]
    assert table.outcome.tolist() == ["rejected"] * 2 + ["failed", "converged"] * 2
    assert table.reason[table.outcome == "rejected"].str.contains(f"{KV} = 3: must be").all()
    assert table.reason[table.outcome == "failed"].str.contains("field").all()
    found = table[table.outcome == "converged"]
    assert found.exposure_mas.iloc[0] > 1.2 * found.exposure_mas.iloc[1], "harder photons need less exposure"
    assert (found.seconds > 0).all()
    arro3 = pytest.importorskip("arro3.io")
    parquet = arro3.read_parquet(study.run / "results/campaigns/mine.parquet").read_all()
    assert parquet.column_names == list(table.columns)
    assert parquet["outcome"].to_pylist() == table.outcome.tolist()


def test_the_page_has_every_answer_and_says_what_failed(campaign):
    page = (campaign[0].run / "results/campaigns/mine.html").read_text()
    assert page.count("data:image/png;base64,") >= 2
    assert "How much exposure does the machine choose?" in page
    assert "must be a number from" in page
    assert "mine.parquet" in page


def test_a_value_added_is_all_that_is_computed(campaign):
    study, table = campaign
    kept = {
        path: path.stat().st_mtime_ns for path in (study.run / "results/campaigns/points").rglob("*.json")
    }
    assert len(kept) == 4
    write(study, CAMPAIGN.replace("26, 30", "26, 28, 30"))
    more = run(study)
    assert {path: path.stat().st_mtime_ns for path in kept} == kept
    assert len(list((study.run / "results/campaigns/points").rglob("*.json"))) == 6
    assert len(more) == 8
    assert set(table.point) <= set(more.point)
    assert "Nothing to be done" in study.snakemake("campaign_mine").stdout


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("[26, 30, 3]", "{from: 26}"), f"vary.{KV} has no end"),
        (("vary:", "varies:"), "did you mean 'vary'?"),
        (("asked:", "subjects: {ada: [left]}\nasked:"), "'ada' is not in volunteer_table"),
        (("asked:", "accuracy: exact\nasked:"), "accuracy = 'exact': 'exact' is not in study"),
    ],
)
def test_a_campaign_that_cannot_be_meant_is_refused_before_any_job(study, change, words):
    write(study, CAMPAIGN.replace(*change))
    result = study.snakemake("--dry-run", "campaign_mine")
    assert result.returncode != 0
    (line,) = [line for line in result.stdout.splitlines() if words in line]
    assert "mine.yaml" in line


# A batch writes its rows; while `broken` is there, the program fails in the point of 2 kPa.
BATCH = """from pathlib import Path

import _log

from mammosim.io.tables import write_json
from mammosim.study.campaigns.answers import faulty, row_of

KEY = "load.tissues.glandular.youngs_modulus_kpa"
given, rows = snakemake.params.batch, []
for point in given["points"]:
    bad = Path("broken").exists() and point["shown"][KEY] == 2
    row = faulty(ZeroDivisionError("a mistake")) if bad else row_of({"force_n": point["shown"][KEY]})
    whose = {"volunteer": given["volunteer"], "side": given["side"], "point": point["name"]}
    rows.append(whose | {"shown": point["shown"]} | row)
write_json(rows, snakemake.output[0])
"""
QUICK = """
title: How does force depend on the gland?
vary: {load.tissues.glandular.youngs_modulus_kpa: [1, 2, 3]}
asked: [force_n]
"""


@pytest.fixture(scope="module")
def quick(study, tmp_path_factory):
    """The study with scripts that compute nothing."""
    made = with_words_for_scripts(study, tmp_path_factory.mktemp("quick"))
    (made.home / "workflow/scripts/campaign_batch.py").write_text(BATCH)
    write(made, QUICK)
    return made


def test_a_fault_of_the_program_leaves_the_table_and_fails_the_run_until_it_is_mended(quick):
    broken = quick.run / "broken"
    broken.touch()
    result = quick.snakemake("campaign_mine")
    assert result.returncode != 0
    assert (quick.run / "results/campaigns/mine.csv").exists(), result.stdout
    table = pd.read_csv(quick.run / "results/campaigns/mine.csv", dtype={"point": str}).set_index(
        "load.tissues.glandular.youngs_modulus_kpa"
    )
    assert table.outcome.tolist() == ["converged", "failed", "converged"]
    assert table.reason[2] == "fault of the program: ZeroDivisionError: a mistake"
    assert table.force_n.dropna().tolist() == [1, 3]
    assert (quick.run / "results/campaigns/mine.html").exists()
    last = result.stdout[-3000:]
    assert f"point {table.point[2]}" in last
    assert "ZeroDivisionError: a mistake" in last
    assert "Traceback" not in result.stdout
    # The same command tries it again, and does nothing more when it is mended.
    assert quick.snakemake("campaign_mine").returncode != 0
    broken.unlink()
    assert quick.snakemake("campaign_mine").returncode == 0
    assert pd.read_csv(quick.run / "results/campaigns/mine.csv").outcome.eq("converged").all()
    assert "Nothing to be done" in quick.snakemake("campaign_mine").stdout


def test_a_job_reads_what_its_run_has_planned_and_plans_nothing(quick):
    (quick.run / "broken").unlink(missing_ok=True)
    assert quick.snakemake("--force", "campaign_mine", "--forcerun", "campaigns_batch").returncode == 0
    (kept,) = (quick.run / ".snakemake/mammosim_campaigns/mine").iterdir()
    given = json.loads(kept.read_text())
    assert len(given["batch"]["points"]) == 3
    job = ("--mode", "remote", "--allowed-rules", "campaigns_batch", "--dry-run", "--force", "--")
    job = (*job, f"results/campaigns/mine/{kept.name}")
    try:
        # A file that means nothing by now: the plan of the whole campaign would be refused.
        write(quick, "title: none\n")
        result = quick.snakemake(*job)
        assert result.returncode == 0, result.stdout[-2000:]
        assert all(path in result.stdout for path in given["inputs"])
        kept.unlink()
        assert "mine.yaml" in quick.snakemake(*job).stdout
    finally:
        write(quick, QUICK)


OTHER = """
title: other settings
tissues: layered
accuracy: draft
settings: {compression: {steps: 7}}
load: {strategy: reduced, moduli: MODULI}
vary: {load.thickness_mm: [45]}
asked: [force_n]
"""


def test_a_campaign_has_its_own_tissues_moduli_accuracy_settings_and_load(quick):
    """On one breast: what its images were labelled with is the study's."""
    campaigns = quick.home / "config/campaigns"
    for moduli in ("gravity", "compression"):
        (campaigns / f"other_{moduli}.yaml").write_text(OTHER.replace("MODULI", moduli))
    quick.snakemake("--touch", "campaign_other_gravity", "campaign_other_compression")

    def values(file):
        return yaml.safe_load((quick.home / f"config/{file}.yaml").read_text())

    for moduli, tissues in {"gravity": "layered", "compression": "compression"}.items():
        (kept,) = (quick.run / f".snakemake/mammosim_campaigns/other_{moduli}").iterdir()
        given = json.loads(kept.read_text())["given"]["settings"]
        assert given["tissues"] == values("tissues/layered")
        assert given["load"]["moduli"] == moduli
        assert given["load"]["tissues"] == values(f"tissues/{tissues}")
        assert given["load"]["strategy"] == values("strategies_smoke")["reduced"]
        assert given["mesh"]["element_mm"] == values("accuracy/draft")["mesh"]["element_mm"]
        assert (
            given["compression"]["penetration_mm"]
            == values("accuracy/draft")["compression"]["penetration_mm"]
        )
        assert given["compression"]["steps"] == 7, "over those of the accuracy"
        assert given["segmentation"]["trees"] == values("smoke")["segmentation"]["trees"]


def test_campaigns_may_have_any_name(quick):
    """Also that of a rule or of a folder; what a system leaves beside a file is none."""
    names = ["batch", "table", "page", "points", "my-own", "mesh", "my study (2)", "größe", "a.b", "it's"]
    campaigns = quick.home / "config/campaigns"
    for name in names:
        (campaigns / f"{name}.yaml").write_text(QUICK)
        (campaigns / f"._{name}.yaml").write_bytes(b"\x00\x05\x16\x07")
    result = quick.snakemake("--dry-run", *(f"campaign_{name}" for name in names))
    assert result.returncode == 0, result.stdout[-2000:]
    assert all(f"results/campaigns/{name}.csv" in result.stdout for name in names)
    assert re.search(rf"^campaigns_batch +{len(names)}$", result.stdout, re.M)


def test_a_file_with_another_ending_is_not_left_out_in_silence(quick):
    file = quick.run / "config/campaigns/firmness.yml"
    file.parent.mkdir(parents=True)
    file.write_text(QUICK)
    try:
        result = quick.snakemake("--dry-run", "campaign_firmness")
        assert result.returncode != 0
        assert "firmness.yml would not be read: its name is to end in .yaml; rename it" in result.stdout
    finally:
        file.unlink()
