"""The catalogue of hard cases is whole and checked, and its target ends with a table, a figure and a page."""

import copy
from dataclasses import replace

import pandas as pd
import pytest
import yaml

from mammosim.chain.configuration import check_settings
from mammosim.core.errors import ConfigurationError
from mammosim.study.hard_cases.cases import HardCase
from mammosim.study.hard_cases.verdict import Converges

FAMILIES = {
    "soft",
    "nearly incompressible",
    "contrast",
    "large and pendulous",
    "toward the chest wall",
    "tilted and upright",
    "slivers",
    "sudden full load",
    "sliding",
    "equal problems",
    "path",
    "bad input",
    "compression",
    "block between plates",
    "small contact",
    "odd angles",
    "off-centre",
    "narrow and sharp",
    "friction",
    "strong compression",
    "outside bodies",
    "flat and pendulous",
    "self-contact",
    "stiff lumps",
    "random moduli",
    "held in one direction",
    "force control",
}
TINY = """
cases:
  inverted:
    family: bad input
    hard: three elements inside out
    problem: &problem
      body: {shape: brick, counts: [1, 1, 2], size_mm: [10, 10, 20], defect: inverted}
      tissues: {adipose: {youngs_modulus_kpa: 1, poisson_ratio: 0.45, density_g_cm3: 1}}
      gravity: [0, 0, 1]
    expected: {rejected: {by: MechanicsError, saying: [3 cells, inverted]}}
  for_another_reason:
    family: bad input
    hard: three elements inside out
    problem: *problem
    expected: {rejected: {by: MechanicsError, saying: [not attached]}}
"""


@pytest.fixture(scope="module")
def catalogue(repository):
    return yaml.safe_load((repository / "config/hard_cases.yaml").read_text())


@pytest.fixture(scope="module")
def schema(repository):
    return yaml.safe_load((repository / "workflow/schemas/hard_cases.schema.yaml").read_text())


def test_every_family_has_cases_and_every_bound_says_why(catalogue):
    cases = [HardCase.of(name, values) for name, values in catalogue["cases"].items()]
    assert len(cases) >= 140
    assert {case.family for case in cases} == FAMILIES
    assert all(len(case.expected.because) >= 10 for case in cases if isinstance(case.expected, Converges))


def test_the_schema_knows_every_key_and_rejects_others(catalogue, schema):
    check_settings(catalogue, schema, files=["hard_cases.yaml"], finite=False)
    wrong = copy.deepcopy(catalogue)
    wrong["cases"]["soft_1kpa"]["problem"]["gravty"] = [0, 0, 1]
    wrong["cases"]["soft_0.3kpa"]["expected"]["converges"]["within"] = 3
    with pytest.raises(ConfigurationError, match="did you mean 'gravity'") as rejected:
        check_settings(wrong, schema, files=["hard_cases.yaml"], finite=False)
    assert "was it given in percent?" in str(rejected.value)


def test_the_target_makes_a_page_that_names_unexpected_outcomes(study, tmp_path):
    tiny = tmp_path / "tiny.yaml"
    tiny.write_text(TINY)
    here = replace(study, run=tmp_path)
    result = here.snakemake("hard_cases", "--config", f"hard_cases={tiny}")
    assert result.returncode == 0, result.stdout[-3000:]
    assert "UNEXPECTED OUTCOME: for_another_reason" in result.stdout
    table = pd.read_csv(tmp_path / "results/study/hard_cases.csv").set_index("case")
    assert list(table.columns[:6]) == ["family", "hard", "expected", "outcome", "ok", "error"]
    assert dict(table.ok) == {"inverted": True, "for_another_reason": False}
    page = (tmp_path / "results/study/hard_cases.html").read_text()
    assert '<img src="figures/' in page
    assert "does not say" in page
    # The report shows the page from now on.
    jobs = here.jobs("results/study/report.html", "--config", f"hard_cases={tiny}")
    assert "results/study/hard_cases.csv" in jobs["report: results/study/report.html"]
