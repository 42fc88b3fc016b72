"""A job ends with the run that has started it: else it would write what the next run makes, too."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).parents[3] / "workflow/scripts"
JOB = "import time, _log; _log.end_with_the_run(); print('begun', flush=True); time.sleep(60)"
RUN = f"""
import subprocess, sys
print(subprocess.Popen([sys.executable, "-c", {JOB!r}]).pid, flush=True)
input()
"""


@pytest.fixture
def pair():
    """A run, and the number of its job, which has begun."""
    path = os.pathsep.join([str(SCRIPTS), os.environ.get("PYTHONPATH", "")])
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    run = subprocess.Popen(
        [sys.executable, "-c", RUN], env=os.environ | {"PYTHONPATH": path}, text=True, **pipes
    )
    job = int(run.stdout.readline())
    assert run.stdout.readline() == "begun\n"
    yield run, job
    run.kill()
    run.communicate()


def ends(process: int, within_s: float = 20.0) -> bool:
    """Whether a process is gone, or only its number is left."""
    end = time.monotonic() + within_s
    while time.monotonic() < end:
        state = Path(f"/proc/{process}/stat")
        if not state.exists() or state.read_text().rsplit(")", 1)[1].split()[0] == "Z":
            return True
        time.sleep(0.05)
    return False


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="what a parent's death sends is of Linux")
def test_a_job_ends_when_its_run_is_killed(pair):
    run, job = pair
    run.kill()
    assert ends(job)


def test_a_job_that_a_person_ends_says_nothing(pair):
    run, job = pair
    os.kill(job, signal.SIGINT)
    assert ends(job)
    said, _ = run.communicate("\n")
    assert said == ""
