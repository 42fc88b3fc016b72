"""A copy of the study that tests may edit, and the whole chain run in it once on the tiny configuration."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

# Targets that run beside the default one: their jobs keep a core busy while it has none to start.
BESIDE = ("accuracy", "recovery", "scenes")
PARTS = ("config", "workflow", "src", "environment.lock")


@dataclass(frozen=True)
class Study:
    """A copy of the study and the folder where it runs."""

    home: Path
    run: Path

    def snakemake(
        self, *arguments: str, env: Mapping[str, str] | None = None
    ) -> subprocess.CompletedProcess[str]:
        """Run snakemake on the tiny configuration; both streams as text in stdout. env: more of it."""
        command = [
            *(sys.executable, "-m", "snakemake", "--snakefile", str(self.home / "workflow/Snakefile")),
            *("--directory", str(self.run), "--configfile", str(self.home / "config/smoke.yaml")),
            *("--cores", "2", "--workflow-profile", "none", *arguments),
        ]
        return subprocess.run(
            command,
            env=os.environ | dict(env or {}),
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            check=False,
        )

    def jobs(self, *arguments: str) -> dict[str, list[str]]:
        """What a dry run would do: the input files of each job, under 'rule: first output'."""
        jobs, rule = {}, ""
        for line in self.snakemake("--dry-run", *arguments).stdout.splitlines():
            word, _, rest = line.strip().partition(": ")
            if word.startswith(("rule ", "localrule ", "checkpoint ")):
                rule, inputs = word.split()[1].rstrip(":"), []
            elif word == "input" and rule:
                inputs = rest.split(", ")
            elif word == "output" and rule:
                jobs[f"{rule}: {rest.split(', ')[0]}"] = inputs
        return jobs

    @contextmanager
    def showing(self, target: str) -> Iterator["Study"]:
        """The numbers of a target of BESIDE are where the report looks for what else it may show."""
        numbers = self.run / f"results/study/{target}.json"
        aside = numbers.with_suffix(".aside")
        aside.rename(numbers)
        yield self
        numbers.rename(aside)


@pytest.fixture(scope="session")
def study(repository, tmp_path_factory) -> Study:
    """A copy of the study in which nothing has run."""
    home = tmp_path_factory.mktemp("study") / "home"
    home.mkdir()
    for part in PARTS:
        source = repository / part
        copy = shutil.copytree if source.is_dir() else shutil.copy2
        copy(source, home / part)
    run = home.parent / "run"
    run.mkdir()
    return Study(home, run)


@pytest.fixture(scope="session")
def finished(study) -> Study:
    """The copy after one run of the chain and of the targets beside it, which its report does not show."""
    result = study.snakemake("study", *BESIDE)
    assert result.returncode == 0, result.stdout[-6000:]
    for target in BESIDE:
        numbers = study.run / f"results/study/{target}.json"
        numbers.rename(numbers.with_suffix(".aside"))
    return study
