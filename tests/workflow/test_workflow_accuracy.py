"""Two cheap numerical parameters varied on the finished study, from the chain as it is to the page."""

import pandas as pd
import pytest

pytestmark = pytest.mark.workflow
COLUMNS = ["stage", "parameter", "value", "quantity", "error", "seconds", "memory_mb"]


@pytest.fixture(scope="module")
def tried(finished):
    """The study after the target ran; before and afterwards its report shows nothing of it."""
    with finished.showing("accuracy"):
        yield finished


def _table(study, name):
    return pd.read_csv(study.run / f"results/study/{name}.csv")


def test_every_value_of_every_parameter_has_its_error_seconds_and_memory(tried):
    table = _table(tried, "accuracy")
    assert list(table.columns[: len(COLUMNS)]) == COLUMNS
    assert set(table.parameter) == {"chain", "dose_photons", "energies"}
    varied = table[table.parameter != "chain"]
    assert (varied.outcome == "converged").all()
    assert (varied.error >= 0).all()
    assert (varied.seconds > 0).all()
    assert (varied.memory_mb > 50).all(), "an interpreter with numpy needs more"
    assert set(varied[varied.today].value) == {"4", "8"}, "the values of config/smoke.yaml"


def test_the_budget_adds_up_and_the_page_stands_alone(tried):
    shares = _table(tried, "accuracy_budget").groupby("quantity").share_percent.sum()
    assert shares.between(99.9, 100.1).all()
    page = (tried.run / "results/study/accuracy.html").read_text()
    assert page.count('<img src="figures/') == 5, "two quantities, memory, orders, budget"
    assert "Presets" in page


def test_the_report_shows_it(tried):
    jobs = tried.jobs("results/study/report.html")
    assert "results/study/accuracy.csv" in jobs["report: results/study/report.html"]


def test_another_value_is_one_more_trial(tried, tmp_path):
    parameters = tmp_path / "parameters.yaml"
    given = (tried.home / "config/accuracy/parameters_smoke.yaml").read_text()
    parameters.write_text(given.replace("values: [10.0, 5.0]", "values: [10.0, 7.0, 5.0]"))
    jobs = tried.jobs("results/study/accuracy.csv", "--config", f"accuracy={parameters}")
    assert [name for name in jobs if name.startswith("accuracy_trial")] == [
        "accuracy_trial: results/accuracy/dose_photons/7.csv"
    ]


@pytest.mark.parametrize(
    ("right", "wrong", "words"),
    [
        ("xray.energies", "xray.energys", "no setting 'xray.energys'; known beside it: "),
        ("[agd_percent, mas_percent]", "[agd]", "'agd': must be one of: nipple_mm"),
    ],
)
def test_a_parameter_that_cannot_be_meant_is_rejected_by_name(study, tmp_path, right, wrong, words):
    parameters = tmp_path / "parameters.yaml"
    given = (study.home / "config/accuracy/parameters_smoke.yaml").read_text()
    parameters.write_text(given.replace(right, wrong))
    result = study.snakemake("--dry-run", "accuracy", "--config", f"accuracy={parameters}")
    assert result.returncode != 0
    assert words in result.stdout
