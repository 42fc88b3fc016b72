"""Costs are those that were measured last, of rules that there are."""

import importlib.util

import pandas as pd
import pytest

BENCHMARK = "s\th:m:s\tmax_rss\tcpu_time\n9.0\t0:00:09\t{}\t{}\n"


@pytest.fixture
def tool(repository, tmp_path, monkeypatch):
    """The tool, at home in a folder with three rules and a table that knows two of them and one more."""
    spec = importlib.util.spec_from_file_location("renew_costs", repository / "tools/renew_costs.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    rules = tmp_path / "workflow/rules"
    rules.mkdir(parents=True)
    (rules / "a.smk").write_text('rule mesh:\n    input: "a"\n\n\ncheckpoint screen:\n    input: "b"\n')
    (rules / "b.smk").write_text("rule dose:\n    input: rules.gone.output\n")
    table = "# said before\nrule\tseconds\tmemory_mb\ndose\t90.0\t800\ngone\t1.0\t1\nmesh\t99.0\t9999\n"
    (tmp_path / "costs.tsv").write_text(table)
    monkeypatch.setattr(module, "HOME", tmp_path)
    monkeypatch.setattr(module, "COSTS", tmp_path / "costs.tsv")
    return module


def test_what_was_measured_replaces_the_table_and_what_did_not_run_stays(tool, tmp_path):
    for rule, jobs in {
        "mesh": [(300.4, 10.0), (500.0, 20.04)],
        "screen": [(7.0, 1.0)],
        "total": [(1.0, 1.0)],
    }.items():
        folder = tmp_path / "benchmarks" / rule
        folder.mkdir(parents=True)
        for number, (memory, seconds) in enumerate(jobs):
            (folder / f"{number}.tsv").write_text(BENCHMARK.format(memory, seconds))
    tool.main(tmp_path / "benchmarks")
    assert (tmp_path / "costs.tsv").read_text().startswith(tool.HEAD)
    costs = pd.read_table(tmp_path / "costs.tsv", comment="#").set_index("rule")
    assert costs.seconds.to_dict() == {"dose": 90.0, "mesh": 15.0, "screen": 1.0}, "means of processor time"
    assert costs.memory_mb.to_dict() == {"dose": 800.0, "mesh": 500.0, "screen": 7.0}, "the largest"
