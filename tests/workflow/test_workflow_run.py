"""The whole chain on the tiny configuration: complete, repeatable, and stale exactly where it should be."""

import json
import re

import pytest

pytestmark = pytest.mark.workflow


def test_the_report_finds_all_it_shows_beside_it(finished):
    """It is read from a folder, without a network."""
    folder = finished.run / "results/study"
    report = (folder / "report.html").read_text()
    assert "://" not in report
    named = set(re.findall(r'(?:src|href)="([^"#]+)"', report)) - {"data:,"}
    assert len([name for name in named if name.startswith("figures/")]) > 40
    assert [name for name in sorted(named) if not (folder / name).exists()] == []


def test_every_headline_has_a_number(finished):
    numbers = json.loads((finished.run / "results/study/numbers.json").read_text())
    headlines = {name: value for name, value in numbers.items() if name.startswith("headline.")}
    assert len(headlines) > 20
    # The numerical error of the mass is not measured at the settings of the tiny study.
    assert {name for name, value in headlines.items() if value is None} <= {
        "headline.reduction_certain_least_mm"
    }


def test_a_second_run_does_nothing(finished):
    assert "Nothing to be done" in finished.snakemake().stdout


def test_editing_a_file_of_the_package_reruns_the_rules_that_use_it(finished):
    file = finished.home / "src/mammosim/xray/observer.py"
    text = file.read_text()
    file.write_text(text + "\n# edited\n")
    rules = {job.split(":")[0] for job in finished.jobs()}
    file.write_text(text)
    assert "mammogram" in rules
    assert rules.isdisjoint({"import_image", "register", "segment", "mesh", "sweep", "compress", "phantom"})


def test_a_result_made_again_has_the_same_bytes(finished):
    again = {
        "register": "results/registration/small/prone.tfm",
        "dose": "results/xray/small/left/standard_gravity_dose.csv",
        "mammogram": "results/xray/small/left/standard_gravity_mammogram.nii.gz",
    }
    before = {name: (finished.run / name).read_bytes() for name in again.values()}
    for rule, name in again.items():
        result = finished.snakemake(name, "--force", "--allowed-rules", rule, "--cores", "1")
        assert result.returncode == 0, result.stdout
    assert {name: (finished.run / name).read_bytes() for name in before} == before
