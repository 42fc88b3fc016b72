"""The crate of the results: every file is there and described, with the workflow that made it."""

import json
from pathlib import Path

import pytest

from mammosim.core.errors import ConfigurationError

RESULTS = {
    "results/study/report.html": "<html></html>",
    "results/study/provenance.json": json.dumps({"packages": {"numpy": "2.4.0", "mammosim": "0.1.0"}}),
    "results/study/sweep.csv": "force_n\n1.0\n",
}


@pytest.fixture
def home(tmp_path):
    """A checkout with one rule and its code."""
    home = tmp_path / "home"
    files = ("workflow/Snakefile", "workflow/rules/a.smk", "config/default.yaml", "src/mammosim/a.py")
    for name in (*files, "environment.lock"):
        (home / name).parent.mkdir(parents=True, exist_ok=True)
        (home / name).write_text("# text\n")
    return home


@pytest.fixture
def results(tmp_path, monkeypatch):
    """A few results in the folder where the study runs."""
    monkeypatch.chdir(tmp_path)
    for name, text in RESULTS.items():
        Path(name).parent.mkdir(parents=True, exist_ok=True)
        Path(name).write_text(text)
    return list(RESULTS)


def test_the_crate_has_and_describes_every_file_and_what_made_it(script, home, results, tmp_path):
    pytest.importorskip("rocrate", reason="rocrate is not installed: pip install '.[crate]'")
    out = tmp_path / "results/crate"
    script("crate").main(home, results, out)
    graph = {each["@id"]: each for each in json.loads((out / "ro-crate-metadata.json").read_text())["@graph"]}
    for name, text in RESULTS.items():
        assert (out / name).read_text() == text
        assert graph[name]["@type"] == "File"
    assert graph["./"]["mainEntity"] == {"@id": "workflow/Snakefile"}
    assert "ComputationalWorkflow" in graph["workflow/Snakefile"]["@type"]
    run = graph["#run"]
    assert {each["@id"] for each in run["result"]} == set(RESULTS)
    assert {"workflow/rules/a.smk", "src/mammosim/a.py", "environment.lock"} <= {
        each["@id"] for each in run["object"]
    }
    assert run["description"] == "mammosim 0.1.0, numpy 2.4.0"


def test_without_its_package_the_way_to_get_it_is_told(script, home, results, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "rocrate.rocrate", None)
    with pytest.raises(ConfigurationError, match="rocrate is not installed"):
        script("crate").main(home, results, tmp_path / "crate")
    assert not (tmp_path / "crate").exists()
