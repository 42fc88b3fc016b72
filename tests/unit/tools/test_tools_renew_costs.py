"""Costs are those that were measured last, of rules that there are."""

import importlib.util

import pandas as pd
import pytest

RULES = """
rule mesh:
    output: "a"
    shell: "true"

checkpoint screen:
    output: "b"
    shell: "true"

rule dose:
    output: "c"
    shell: "true"

for name in ["field"]:
    rule:
        name: f"figure_{name}"
        output: f"{name}.png"
        shell: "true"
"""
BENCHMARK = "s\th:m:s\tmax_rss\tcpu_time\n9.0\t0:00:09\t{}\t{}\n"


@pytest.fixture
def tool(repository, tmp_path, monkeypatch):
    """The tool, at home where there are four rules, one made in a loop, and a table of two and one more."""
    spec = importlib.util.spec_from_file_location("renew_costs", repository / "tools/renew_costs.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    (tmp_path / "workflow").mkdir()
    (tmp_path / "workflow/Snakefile").write_text(RULES)
    table = "# said before\nrule\tseconds\tmemory_mb\tlongest\ndose\t90.0\t800\t91.0\n"
    table += "gone\t1.0\t1\t1.0\nmesh\t99.0\t9999\t99.0\n"
    (tmp_path / "costs.tsv").write_text(table)
    monkeypatch.setattr(module, "HOME", tmp_path)
    monkeypatch.setattr(module, "COSTS", tmp_path / "costs.tsv")
    return module


def measured(folder, jobs: dict[str, list[tuple[float, float]]]):
    """Benchmarks of jobs by rule: MB and processor seconds of each."""
    for rule, each in jobs.items():
        (folder / rule).mkdir(parents=True)
        for number, (memory, seconds) in enumerate(each):
            (folder / rule / f"{number}.tsv").write_text(BENCHMARK.format(memory, seconds))
    return folder


def test_what_was_measured_replaces_the_table_and_what_did_not_run_stays(tool, tmp_path):
    jobs = {"mesh": [(300.4, 10.0), (500.0, 20.04)], "screen": [(7.0, 1.0)], "total": [(1.0, 1.0)]}
    tool.main(measured(tmp_path / "benchmarks", jobs | {"figure_field": [(30.0, 0.4)]}))
    assert (tmp_path / "costs.tsv").read_text().startswith(tool.HEAD)
    costs = pd.read_table(tmp_path / "costs.tsv", comment="#").set_index("rule")
    means = {"dose": 90.0, "figure_field": 0.4, "mesh": 15.0, "screen": 1.0}
    assert costs.seconds.to_dict() == means, "means of processor time"
    assert costs.memory_mb.to_dict() == {"dose": 800, "figure_field": 30, "mesh": 500, "screen": 7}, (
        "the largest"
    )
    assert costs.longest.to_dict() == {"dose": 91.0, "figure_field": 0.4, "mesh": 20.0, "screen": 1.0}


def test_other_women_count_for_the_longest_and_the_largest_job_only(tool, tmp_path):
    study = measured(tmp_path / "study", {"mesh": [(300.0, 10.0), (500.0, 20.0)]})
    heavy = measured(tmp_path / "heavy", {"mesh": [(900.0, 200.0)], "screen": [(7.0, 3.0)]})
    tool.main(study, heavy)
    costs = pd.read_table(tmp_path / "costs.tsv", comment="#").set_index("rule")
    assert costs.loc["mesh"].to_dict() == {"seconds": 15.0, "memory_mb": 900.0, "longest": 200.0}
    assert costs.loc["screen"].to_dict() == {"seconds": 3.0, "memory_mb": 7.0, "longest": 3.0}
