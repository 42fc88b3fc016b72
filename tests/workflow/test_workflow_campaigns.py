"""Campaigns on the tiny configuration: a table, a page, only what is added is computed, faults come first."""

import pandas as pd
import pytest

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
