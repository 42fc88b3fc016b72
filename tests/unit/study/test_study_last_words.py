"""The last words of a run name what failed, why and where its log is, in less than a screen."""

import os
import subprocess

import pytest

from mammosim.io.atomic import machine
from mammosim.study.jobs.last_words import (
    NO_ERROR,
    NO_LOG,
    Failure,
    Run,
    interrupted,
    last_words,
    locked,
    reason,
)

LOG = """2026-11-29 21:00:00 mammosim steps
2026-11-29 21:00:01 root Traceback (most recent call last):
  File "compress.py", line 12, in main
    press(body)
mammosim.core.errors.EquilibriumError: no equilibrium at 45 mm
more advice
"""


def test_the_reason_is_the_last_error_of_a_log():
    assert reason(LOG) == "EquilibriumError: no equilibrium at 45 mm"
    second = LOG + "\nDuring handling\n\nTraceback (most recent call last):\n  File\nKeyError: 'x.y: z'\n"
    assert reason(second) == "KeyError: 'x.y: z'"
    assert reason("Traceback (most recent call last):\n  File\nAssertionError\n") == "AssertionError"
    assert reason("step 1\nstep 2\n") == NO_ERROR


@pytest.fixture
def said(tmp_path):
    """The last words about so many failures with a log."""

    def words(failures: int, not_run: int, *, stopped: bool = False) -> list[str]:
        log = tmp_path / "job.log"
        log.write_text(LOG)
        failed = [Failure(f"compress {i}", log) for i in range(failures)]
        folders = {"results": tmp_path / "results", "run_log": tmp_path / "run.log"}
        return last_words(failed, not_run=not_run, stopped=stopped, since=0.0, **folders).splitlines()

    return words


def test_each_failure_is_named_with_its_reason_and_its_log(said, tmp_path):
    lines = said(2, 7)
    assert lines[0] == "2 jobs failed:"
    assert lines[1] == "  compress 0: EquilibriumError: no equilibrium at 45 mm"
    assert lines[2] == f"    log: {tmp_path / 'job.log'}"
    assert lines[5] == "Not run, since they need what failed: 7 jobs."
    assert lines[-1].startswith(f"All the remaining results are in {tmp_path / 'results'}")


@pytest.mark.parametrize("text", ["step 1\n", "Traceback (most recent call last):\n  File\nMemoryError\n"])
def test_a_job_that_was_killed_or_had_no_memory_is_said_with_what_it_asks_for(tmp_path, text):
    log = tmp_path / "job.log"
    log.write_text(text)
    words = Failure("segment small prone", log, mem_mb=4000).lines(since=0.0)[0]
    assert "memory" in words.lower()
    assert "4000 MB (mem_mb)" in words
    log.write_text(LOG)
    assert "mem_mb" not in Failure("segment small prone", log, mem_mb=4000).lines(since=0.0)[0]


def test_a_run_that_a_person_ends_says_three_lines_and_how_to_go_on(tmp_path):
    lines = interrupted(left=3, results=tmp_path / "results", run_log=tmp_path / "run.log").splitlines()
    assert len(lines) == 3
    assert "3 jobs left" in lines[0]
    assert lines[-1].endswith("the same command computes only what is left.")


def test_a_lock_is_told_apart_by_whether_its_run_goes_on(tmp_path):
    file = tmp_path / ".snakemake/mammosim_run"
    Run.here().write(file)
    assert f"another run, process {os.getpid()}, is at work in {tmp_path}" in locked(Run.read(file), tmp_path)
    ended = subprocess.Popen(["true"])
    ended.wait()
    Run(ended.pid, machine()).write(file)
    for lock in (Run.read(file), Run.read(tmp_path / "nothing")):
        words = locked(lock, tmp_path)
        assert "--unlock" in words
        assert "\n" not in words
    Run(ended.pid, "elsewhere").write(file)
    assert "another run" in locked(Run.read(file), tmp_path)


def test_a_run_is_told_from_one_that_began_before_it_and_is_none_when_it_has_ended(tmp_path):
    file = tmp_path / ".snakemake/mammosim_run"
    assert Run.began(file) == ""
    Run.here().write(file)
    first = Run.began(file)
    assert first == Run.began(file) != ""
    os.utime(file, ns=(1, 1))
    assert Run.began(file) not in ("", first)
    ended = subprocess.Popen(["true"])
    ended.wait()
    Run(ended.pid, machine()).write(file)
    assert Run.began(file) == ""


def test_many_failures_fit_on_a_screen(said):
    lines = said(40, 0)
    assert len(lines) <= 15
    assert "  and 35 other jobs" in lines
    assert "other" not in "".join(said(5, 0)), "all five are named"


def test_a_run_that_was_stopped_says_so(said):
    assert said(0, 1)[:2] == ["The run was stopped.", "Not run: 1 job."]
    rejected = said(1, 200, stopped=True)
    assert "Not run: 200 jobs." in rejected
    assert rejected[-1].startswith("Finished results are in")


def test_an_old_log_is_not_taken_for_that_of_the_failure(tmp_path):
    log = tmp_path / "job.log"
    log.write_text(LOG)
    assert Failure("mesh", log).lines(since=log.stat().st_mtime + 1) == [f"  mesh: {NO_LOG}"]
    assert len(Failure("mesh", log).lines(since=log.stat().st_mtime)) == 2, "written as the run began"
    assert Failure("mesh", None).lines(since=0.0) == [f"  mesh: {NO_LOG}"]
