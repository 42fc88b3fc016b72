"""One sampled patient from her draw to the page of the moduli that were found again."""

import pandas as pd
import pytest

pytestmark = pytest.mark.workflow
COLUMNS = ["seed", "side", "tissue", "true_kpa", "fitted_kpa", "low_kpa", "high_kpa", "inside_95", "seconds"]


@pytest.fixture(scope="module")
def recovered(finished):
    """The study after the target ran; before and afterwards its report shows nothing of it."""
    with finished.showing("recovery"):
        yield finished


def test_every_modulus_of_every_seed_has_a_row(recovered):
    table = pd.read_csv(recovered.run / "results/study/recovery.csv")
    assert list(table.columns[: len(COLUMNS)]) == COLUMNS
    assert set(table.seed) == {1}
    assert sorted(table.tissue) == sorted(["adipose", "glandular", "skin", "fascia", "muscle"] * 2)
    assert (table.true_kpa[table.tissue != "fascia"] > 0).all()
    assert (table[table.identifiable].low_kpa < table[table.identifiable].high_kpa).all()


def test_the_draw_is_told_and_stable(recovered):
    draws = pd.read_csv(recovered.run / "results/study/recovery_draws.csv")
    assert list(draws.columns) == ["volunteer", "draw", "outcome"]
    assert draws.outcome.iloc[-1] == "converged", "the draw that was taken"


def test_the_page_stands_alone_and_the_report_shows_it(recovered):
    page = (recovered.run / "results/study/recovery.html").read_text()
    assert '<img src="figures/' in page
    jobs = recovered.jobs("results/study/report.html")
    assert "results/study/recovery.csv" in jobs["report: results/study/report.html"]


def test_a_misprint_is_rejected_with_what_was_meant(study, tmp_path):
    text = (study.home / "config/recovery_smoke.yaml").read_text().replace("skin_kpa", "skin_pa")
    (tmp_path / "wrong.yaml").write_text(text)
    (tmp_path / "extra.yaml").write_text(f"recovery: {tmp_path / 'wrong.yaml'}\n")
    smoke = study.home / "config/smoke.yaml"
    message = study.snakemake("--dry-run", "--configfile", str(smoke), str(tmp_path / "extra.yaml"))
    assert message.returncode != 0
    assert "did you mean 'skin_kpa'?" in message.stdout
