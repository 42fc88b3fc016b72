"""A copy of the study that tests may edit, and the whole chain run once on the tiny configuration.

Of several processes of tests one runs the chain; the others wait for it, and each works on a copy of its own.
"""

import fcntl
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
# What a script is replaced by that is to compute nothing.
WORD = """from pathlib import Path

for path in map(Path, snakemake.output):
    path.write_text("made") if path.suffix else path.mkdir(exist_ok=True)
"""


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


def copy_of_the_study(repository: Path, folder: Path) -> Study:
    """A copy of the study in a new folder, in which nothing has run."""
    made = Study(folder / "home", folder / "run")
    made.home.mkdir(parents=True)
    for part in PARTS:
        source = repository / part
        copy = shutil.copytree if source.is_dir() else shutil.copy2
        copy(source, made.home / part)
    made.run.mkdir()
    return made


def with_words_for_scripts(study: Study, folder: Path) -> Study:
    """A copy whose scripts, but for those of campaigns, write a word and compute nothing."""
    made = copy_of_the_study(study.home, folder)
    for script in (made.home / "workflow/scripts").glob("[!_]*.py"):
        if not script.name.startswith("campaign_"):
            script.write_text(WORD)
    return made


def cost(study: Study, rule: str, seconds: float) -> None:
    """Let the table say that a job of the rule takes so long."""
    table = study.home / "config/costs.tsv"
    lines = [line.split("\t") for line in table.read_text().splitlines()]
    told = [[name, str(seconds), *rest[1:]] if name == rule else [name, *rest] for name, *rest in lines]
    table.write_text("\n".join("\t".join(cells) for cells in told) + "\n")


@pytest.fixture(scope="session")
def study(repository, tmp_path_factory) -> Study:
    """A copy of the study in which nothing has run."""
    return copy_of_the_study(repository, tmp_path_factory.mktemp("study"))


@contextmanager
def locked(file: Path) -> Iterator[None]:
    """One process at a time; the others wait. A process that dies lets the next one in."""
    with file.open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def finished_once(repository: Path, folder: Path) -> str:
    """Run the chain and the targets beside it in folder/study, unless that was done: '' or why it failed."""
    said = folder / "said.txt"
    with locked(folder / "lock"):
        if not said.exists():
            shutil.rmtree(folder / "study", ignore_errors=True)  # of a process that died
            made = copy_of_the_study(repository, folder / "study")
            # Kernels are compiled beside their source: what this run or a test has compiled serves both.
            shutil.rmtree(made.home / "src")
            (made.home / "src").symlink_to(repository / "src", target_is_directory=True)
            result = made.snakemake("study", *BESIDE)
            said.write_text(result.stdout[-6000:] or "failed" if result.returncode else "")
    return said.read_text()


@pytest.fixture(scope="session")
def finished(repository, tmp_path_factory) -> Study:
    """A copy after one run of the chain and of the targets beside it, which its report does not show."""
    base = tmp_path_factory.getbasetemp()
    shared = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "shared"
    shared.mkdir(exist_ok=True)
    failure = finished_once(repository, shared)
    assert not failure, failure
    own = copy_of_the_study(repository, tmp_path_factory.mktemp("finished"))
    shutil.copytree(shared / "study/run", own.run, symlinks=True, dirs_exist_ok=True)
    for target in BESIDE:
        numbers = own.run / f"results/study/{target}.json"
        numbers.rename(numbers.with_suffix(".aside"))
    return own
