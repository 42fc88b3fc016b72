"""A job ends with the run that has started it: else it would write what the next run makes, too."""

import os
import shlex
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).parents[3] / "workflow/scripts"
JOB = "import time, _log; _log.end_with_the_run(); print(_log.os.getpid(), flush=True); time.sleep(60)"
AT_ONCE = f"exec {shlex.quote(sys.executable)} -c {shlex.quote(JOB)}"
BEHIND_A_SHELL = f"{shlex.quote(sys.executable)} -c {shlex.quote(JOB)}; true"  # as shells do that stay
RUN = """
import os, subprocess, sys
subprocess.Popen(sys.argv[1], shell=True, env=os.environ | {"MAMMOSIM_RUN": str(os.getpid())})
input()
"""


def begin(shell: str) -> tuple[subprocess.Popen, int]:
    """A run, and the number of its job, which has begun."""
    path = os.pathsep.join([str(SCRIPTS), os.environ.get("PYTHONPATH", "")])
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    command = [sys.executable, "-c", RUN, shell]
    run = subprocess.Popen(command, env=os.environ | {"PYTHONPATH": path}, text=True, **pipes)
    return run, int(run.stdout.readline())


@pytest.fixture(params=[AT_ONCE, BEHIND_A_SHELL], ids=["at once", "behind a shell"])
def pair(request):
    """See begin: whatever shell is between the two."""
    run, job = begin(request.param)
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


def test_a_job_ends_when_its_run_is_killed(pair):
    run, job = pair
    run.kill()
    assert ends(job)


def test_a_job_leaves_ctrl_c_to_its_run_and_ends_without_a_traceback(pair):
    run, job = pair
    os.kill(job, signal.SIGINT)
    assert not ends(job, within_s=0.5)
    os.kill(job, signal.SIGTERM)
    assert ends(job)
    said, _ = run.communicate("\n")
    assert said in ("", "Terminated\n"), "the second where the shell tells of it"


def test_a_job_whose_run_is_gone_does_not_begin(tmp_path):
    gone = subprocess.Popen(["true"])
    gone.wait()
    where = {
        "PYTHONPATH": f"{SCRIPTS}{os.pathsep}{os.environ.get('PYTHONPATH', '')}",
        "MAMMOSIM_RUN": str(gone.pid),
    }
    begun = subprocess.run(
        [sys.executable, "-c", JOB], env=os.environ | where, text=True, capture_output=True
    )
    assert begun.returncode == 1
    assert begun.stdout == ""
    assert "the run that has started this job has ended" in begun.stderr


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere the thread alone looks")
def test_the_system_tells_a_job_that_is_too_busy_to_look():
    busy = JOB.replace("_log; ", "_log; _log.end_behind = lambda run: None; ")
    run, job = begin(f"exec {shlex.quote(sys.executable)} -c {shlex.quote(busy)}")
    run.kill()
    assert ends(job)
    run.communicate()


def test_a_script_that_is_started_by_hand_has_no_run(script, monkeypatch):
    monkeypatch.delenv("MAMMOSIM_RUN", raising=False)
    before = threading.active_count()
    script("_log").end_with_the_run()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    assert threading.active_count() == before


def test_a_job_that_is_done_does_not_wait_for_its_run(tmp_path):
    where = {"PYTHONPATH": f"{SCRIPTS}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"}
    where |= {"MAMMOSIM_RUN": str(os.getpid())}
    command = [sys.executable, "-c", JOB.replace("time.sleep(60)", "")]
    assert subprocess.run(command, env=os.environ | where, timeout=60, check=False).returncode == 0
