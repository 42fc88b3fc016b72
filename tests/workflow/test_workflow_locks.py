"""A folder in which a run is at work, or was killed: no other run begins there, and who looks on may."""

import os
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

from mammosim.study.jobs.last_words import Run

SPECTRUM = "results/xray/spectrum.csv"
LONG_ONE = "results/segmentation/tissues.ctbl"
LONG = """import os, time
from pathlib import Path

import _log

_log.to(snakemake.log[0])
Path("job").write_text(str(os.getpid()))
time.sleep(600)
"""


@pytest.fixture
def at_work(study, tmp_path):
    """The study in a folder that this process has locked, as a run does for its outputs."""
    lock = tmp_path / ".snakemake/locks/0.output.lock"
    lock.parent.mkdir(parents=True)
    lock.write_text(SPECTRUM)
    Run.here().write(tmp_path / ".snakemake/mammosim_run")
    return replace(study, run=tmp_path)


def test_a_dry_run_beside_a_run_says_what_it_would_do(at_work):
    assert f"spectrum: {SPECTRUM}" in at_work.jobs(SPECTRUM), "the plan is such a dry run, in a run"


def test_a_second_run_is_told_of_the_first_before_anything_is_made(at_work):
    second = at_work.snakemake(SPECTRUM)
    assert second.returncode != 0
    assert f"another run, process {os.getpid()}, is at work" in second.stdout
    assert not (at_work.run / "results").exists()


@pytest.fixture
def long(study, tmp_path):
    """The study with a job that lasts, and an environment whose shells do not give their place to it."""
    home, run, programs = (tmp_path / name for name in ("home", "run", "bin"))
    shutil.copytree(study.home, home)
    run.mkdir()
    programs.mkdir()
    (home / "workflow/scripts/label_colours.py").write_text(LONG)
    stays = programs / "bash"
    stays.write_text(f'#!/bin/sh\n{shutil.which("bash")} "$@"\nexit $?\n')
    stays.chmod(0o755)
    return replace(study, home=home, run=run), os.environ | {"PATH": f"{programs}:{os.environ['PATH']}"}


def within(seconds: float, there) -> bool:
    """Whether something is so, before so much time has passed."""
    end = time.monotonic() + seconds
    while not there() and time.monotonic() < end:
        time.sleep(0.1)
    return there()


def runs(process: int) -> bool:
    """Whether a process has not ended."""
    state = Path(f"/proc/{process}/stat")
    return state.exists() and state.read_text().rpartition(")")[2].split()[0] not in "ZX"


@pytest.fixture
def begun(long):
    """The study, a run of it in a session of its own whose job has begun, and the job's number."""
    study, environment = long
    command = [
        *(sys.executable, "-m", "snakemake", "--snakefile", str(study.home / "workflow/Snakefile")),
        *("--directory", str(study.run), "--configfile", str(study.home / "config/smoke.yaml")),
        *("--cores", "1", "--workflow-profile", "none", LONG_ONE),
    ]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    run = subprocess.Popen(command, env=environment, text=True, start_new_session=True, **pipes)
    file = study.run / "job"
    assert within(120.0, lambda: run.poll() is not None or (file.exists() and file.read_text() != ""))
    yield study, run, int(file.read_text())
    run.kill()
    run.communicate()


@pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="how a job is seen to have ended is of Linux"
)
def test_a_killed_run_takes_its_jobs_with_it_whatever_shell_is_between_and_its_lock_is_told(begun):
    study, run, job = begun
    second = study.snakemake(LONG_ONE)
    assert second.returncode != 0
    assert f"another run, process {run.pid}, is at work" in second.stdout
    run.kill()
    run.wait()
    assert within(20.0, lambda: not runs(job))
    assert "was killed and has left its lock" in study.snakemake(LONG_ONE).stdout


def test_ctrl_c_ends_the_job_and_the_last_three_lines_say_how_to_go_on(begun):
    _, run, job = begun
    os.killpg(run.pid, signal.SIGINT)
    said, _ = run.communicate(timeout=120)
    assert run.returncode != 0
    assert not runs(job)
    last = said.splitlines()[-3:]
    assert last[0] == "Stopped as you asked; 1 job left, including those that were running."
    assert last[-1].endswith("the same command computes only what is left.")
    assert "Error in rule" not in said
    assert "Traceback" not in said
