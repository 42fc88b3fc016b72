"""Other meshes and larger breasts are run each in a folder of its own; what one lacks is told, and counts."""

import importlib.util
import shutil
import subprocess
from types import SimpleNamespace

import pytest


@pytest.fixture
def tool(repository, tmp_path):
    """The tool, at home in a folder with two variants and a study with a result."""
    (tmp_path / "tools").mkdir()
    place = shutil.copy(repository / "tools/robust.py", tmp_path / "tools/robust.py")
    spec = importlib.util.spec_from_file_location("robust", place)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    for name in ("config/robust/coarse.yaml", "config/robust/large.yaml", "results/study/missing.csv"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("reason,tables,figures\n" if name.endswith("csv") else "mesh: {}\n")
    return module


def run(tool, monkeypatch, lacks):
    """The exit code, and the commands; lacks: reasons by folder, None where the run failed."""
    commands = []

    def ran(command, *, cwd, check):
        commands.append(command)
        folder = cwd / "robust" / "large" if "large" in command[-1] else cwd
        if lacks.get(folder.name) is None and folder.name in lacks:
            return SimpleNamespace(returncode=1)
        rows = "".join(f"{reason},dose,\n" for reason in lacks.get(folder.name, ()))
        (folder / "results/study/missing.csv").write_text(f"reason,tables,figures\n{rows}")
        return SimpleNamespace(returncode=0)

    monkeypatch.setattr(subprocess, "run", ran)
    return tool.main("snakemake", "2"), commands


def test_each_variant_begins_from_the_study_in_its_own_folder(tool, monkeypatch, tmp_path):
    code, commands = run(tool, monkeypatch, {})
    assert code == 0
    assert commands[0] == ["snakemake", "--cores", "2"]
    assert commands[1][3:] == [
        *("--configfile", str(tmp_path / "config/robust/coarse.yaml")),
        *("--directory", str(tmp_path / "robust/coarse")),
    ]
    assert (tmp_path / "robust/coarse/results/study/missing.csv").exists()
    outcome = (tmp_path / "robust/outcome.csv").read_text().splitlines()
    assert [line.split(",")[:2] for line in outcome[1:]] == [
        [name, "made"] for name in ("published", "coarse", "large")
    ]


@pytest.mark.parametrize(
    ("lacks", "words"),
    [(["it is open", "it slides"], "large,made,0.0,it is open; it slides"), (None, "large,not made,0.0,")],
)
def test_what_a_variant_lacks_is_told_and_fails_the_check(tool, monkeypatch, tmp_path, lacks, words):
    code, _ = run(tool, monkeypatch, {"large": lacks})
    assert code == 1
    assert (tmp_path / "robust/outcome.csv").read_text().splitlines()[-1] == words
