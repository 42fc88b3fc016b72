"""The last words of a run name what failed, why and where its log is, in less than a screen."""

import pytest

from mammosim.study.jobs.last_words import NO_ERROR, NO_LOG, Failure, last_words, reason

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
    assert lines[5] == "Not run, for want of what failed: 7 jobs."
    assert lines[-1].startswith(f"All the rest is there, in {tmp_path / 'results'}")


def test_many_failures_fit_on_a_screen(said):
    lines = said(40, 0)
    assert len(lines) <= 15
    assert "  and 35 other jobs" in lines
    assert "other" not in "".join(said(5, 0)), "all five are named"


def test_a_run_that_was_stopped_says_so(said):
    assert said(0, 1)[:2] == ["The run was stopped.", "Not run: 1 job."]
    rejected = said(1, 200, stopped=True)
    assert "Not run: 200 jobs." in rejected
    assert rejected[-1].startswith("What is done is there")


def test_an_old_log_is_not_taken_for_that_of_the_failure(tmp_path):
    log = tmp_path / "job.log"
    log.write_text(LOG)
    assert Failure("mesh", log).lines(since=log.stat().st_mtime + 1) == [f"  mesh: {NO_LOG}"]
    assert len(Failure("mesh", log).lines(since=log.stat().st_mtime)) == 2, "written as the run began"
    assert Failure("mesh", None).lines(since=0.0) == [f"  mesh: {NO_LOG}"]
