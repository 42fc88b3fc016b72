"""Kills, full and read-only disks, two runs at once, files cut off: afterwards it is as if nothing had been.

`make test-faults`; MAMMOSIM_SEED and MAMMOSIM_KILLS repeat a draw, and say how many kills.
"""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path

import psutil
import pytest
from whole_study import Study

pytestmark = pytest.mark.faults
# A dozen jobs with a volume, a table, a mesh and a transform.
TARGETS = ("results/registration/small/supine.tfm", "results/truth/small/stress_free.vtu")
KILLS = int(os.environ.get("MAMMOSIM_KILLS", "20"))
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
LEFT_BEHIND_S = 10.0  # within which a job has ended behind its run
SMALL_DISK, LARGE_DISK = "2m", "500m"
IS_ROOT = os.geteuid() == 0


@dataclass(frozen=True)
class Undisturbed:
    """The study after a run that nothing disturbed: its files, and how long it took."""

    study: Study
    files: dict[str, bytes]
    seconds: float


@pytest.fixture(scope="module")
def undisturbed(study, tmp_path_factory) -> Undisturbed:
    """One run of the targets."""
    there = replace(study, run=tmp_path_factory.mktemp("undisturbed"))
    start = time.monotonic()
    finish(there)
    return Undisturbed(there, files_of(there), time.monotonic() - start)


@pytest.fixture
def new(study, tmp_path) -> Study:
    """The study in an empty folder."""
    run = tmp_path / "run"
    run.mkdir()
    return replace(study, run=run)


@pytest.fixture
def copied(undisturbed, tmp_path) -> Study:
    """The study in a copy of what the undisturbed run made."""
    shutil.copytree(undisturbed.study.run, tmp_path / "run", symlinks=True)
    return replace(undisturbed.study, run=tmp_path / "run")


def files_of(study: Study) -> dict[str, bytes]:
    """What a run made, but for what it says of itself: logs, and the seconds that jobs took."""
    results = study.run / "results"
    return {
        str(file.relative_to(results)): file.read_bytes()
        for file in sorted(results.rglob("*"))
        if file.is_file()
        and file.relative_to(results).parts[0] not in ("logs", "benchmarks")
        and "seconds" not in file.name
    }


def finish(study: Study) -> str:
    """Run to the end, behind a lock that a killed run has left, and give what was said."""
    said = ""
    if any((study.run / ".snakemake/locks").glob("*")):
        said = study.snakemake(*TARGETS).stdout
        assert "--unlock" in said
        assert "Traceback" not in said
        assert study.snakemake("--unlock", *TARGETS).returncode == 0
    ended = study.snakemake("--rerun-incomplete", "--keep-going", *TARGETS)
    assert ended.returncode == 0, ended.stdout[-4000:]
    return said + ended.stdout


def require_as_undisturbed(study: Study, undisturbed: Undisturbed) -> None:
    """The same files with the same bytes, and none that was left unfinished."""
    found = files_of(study)
    assert set(found) == set(undisturbed.files)
    assert [name for name, content in found.items() if content != undisturbed.files[name]] == []


def begin(study: Study) -> subprocess.Popen[str]:
    """A run in a session of its own, as a terminal begins it; both streams as text in stdout."""
    command = [
        *(sys.executable, "-m", "snakemake", "--snakefile", str(study.home / "workflow/Snakefile")),
        *("--directory", str(study.run), "--configfile", str(study.home / "config/smoke.yaml")),
        *("--cores", "2", "--workflow-profile", "none", "--rerun-incomplete", "--keep-going", *TARGETS),
    ]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    return subprocess.Popen(command, text=True, start_new_session=True, **pipes)


def jobs_of(study: Study) -> list[psutil.Process]:
    """The scripts that are running for this folder."""
    found = []
    for process in psutil.process_iter():
        with suppress(psutil.Error):
            if any(f"{study.run}/.snakemake/scripts" in word for word in process.cmdline()):
                found.append(process)
    return found


def wait_for_job(study: Study, run: subprocess.Popen[str], seconds: float) -> psutil.Process | None:
    """A job that is running; None where the run, or so much time, ends before."""
    end = time.monotonic() + seconds
    while time.monotonic() < end and run.poll() is None:
        if jobs := jobs_of(study):
            return jobs[0]
        time.sleep(0.05)
    return None


def kill_a_job(study: Study, run: subprocess.Popen[str], seconds: float) -> None:
    """SIGKILL to the first job that has not ended before it arrives."""
    while job := wait_for_job(study, run, seconds):
        with suppress(psutil.NoSuchProcess):
            job.kill()
            return
    raise AssertionError("no job was there to be killed")


def strike(study: Study, run: subprocess.Popen[str], number: signal.Signals, *, a_job: bool) -> None:
    """Send a signal to one job, or to the run: Ctrl-C reaches the whole group."""
    if a_job:
        job = wait_for_job(study, run, 30.0)
        if job is not None:
            with suppress(psutil.Error):
                job.send_signal(number)
    elif run.poll() is None:
        (os.killpg if number == signal.SIGINT else os.kill)(run.pid, number)


def require_no_orphans(study: Study) -> None:
    end = time.monotonic() + LEFT_BEHIND_S
    while (left := jobs_of(study)) and time.monotonic() < end:
        time.sleep(0.2)
    assert left == []


def test_kills_at_random_moments(new, undisturbed):
    seed = int(os.environ.get("MAMMOSIM_SEED", time.time_ns() % 10**6))
    draw = random.Random(seed)
    for kill in range(KILLS):
        number, a_job = draw.choice(SIGNALS), draw.random() < 0.5
        where = f"MAMMOSIM_SEED={seed}, kill {kill}: {number.name} to {'a job' if a_job else 'the run'}"
        sys.stdout.write(f"{where}\n")
        run = begin(new)
        # Half of the jobs at most, so that the next ones are disturbed, too.
        time.sleep(draw.uniform(0.1, 0.5) * undisturbed.seconds)
        strike(new, run, number, a_job=a_job)
        said, _ = run.communicate(timeout=30 * undisturbed.seconds)
        require_no_orphans(new)
        if run.returncode == 0:
            require_as_undisturbed(new, undisturbed)
            shutil.rmtree(new.run / "results")
        elif number == signal.SIGINT and not a_job:
            assert "Traceback" not in said, where
        if any((new.run / ".snakemake/locks").glob("*")):
            assert new.snakemake("--unlock", *TARGETS).returncode == 0, where
    finish(new)
    require_as_undisturbed(new, undisturbed)


def test_ctrl_c_ends_in_three_lines_of_which_the_last_says_how_to_go_on(new, undisturbed):
    run = begin(new)
    assert wait_for_job(new, run, 30 * undisturbed.seconds)
    time.sleep(3.0)
    os.killpg(run.pid, signal.SIGINT)
    said, _ = run.communicate(timeout=30 * undisturbed.seconds)
    last = said.splitlines()[-3:]
    assert last[0].startswith("Stopped as you asked")
    assert last[-1].endswith("the same command computes only what is left.")
    assert "Traceback" not in said
    assert "Error in rule" not in said
    finish(new)
    require_as_undisturbed(new, undisturbed)


def test_a_killed_run_takes_its_jobs_with_it_and_its_lock_is_told(new, undisturbed):
    run = begin(new)
    assert wait_for_job(new, run, 30 * undisturbed.seconds)
    time.sleep(2.0)
    run.kill()
    run.communicate()
    require_no_orphans(new)
    assert "was killed and has left its lock" in finish(new)
    require_as_undisturbed(new, undisturbed)


def test_a_second_run_at_once_is_told_of_the_first(new, undisturbed):
    run = begin(new)
    assert wait_for_job(new, run, 30 * undisturbed.seconds)
    second = new.snakemake(*TARGETS)
    assert second.returncode != 0
    assert f"another run, process {run.pid}, is at work" in second.stdout
    run.communicate(timeout=30 * undisturbed.seconds)
    assert run.returncode == 0
    require_as_undisturbed(new, undisturbed)


def test_a_job_that_is_killed_is_said_with_the_memory_that_it_asks_for(new, undisturbed):
    run = begin(new)
    kill_a_job(new, run, 30 * undisturbed.seconds)
    said, _ = run.communicate(timeout=30 * undisturbed.seconds)
    assert run.returncode != 0
    assert "MB (mem_mb)" in "\n".join(said.splitlines()[-20:])
    finish(new)
    require_as_undisturbed(new, undisturbed)


@contextmanager
def mounted(folder: Path, *options: str) -> Iterator[None]:
    """A disk of its own in a folder."""
    subprocess.run(["mount", *options, str(folder)], check=True)
    try:
        yield
    finally:
        subprocess.run(["umount", "--lazy", str(folder)], check=True)


@pytest.mark.skipif(not IS_ROOT, reason="only root may mount a disk")
def test_a_disk_that_is_full_is_said_and_with_room_the_run_goes_on(new, undisturbed):
    with mounted(new.run, "-t", "tmpfs", "-o", f"size={SMALL_DISK}", "none"):
        ended = new.snakemake("--keep-going", *TARGETS)
        assert ended.returncode != 0
        assert "No space left on device" in ended.stdout
        subprocess.run(["mount", "-o", f"remount,size={LARGE_DISK}", str(new.run)], check=True)
        finish(new)
        require_as_undisturbed(new, undisturbed)


@pytest.mark.skipif(not IS_ROOT, reason="only root may make a disk read-only")
def test_results_that_are_read_only_are_said_and_stay(copied, undisturbed):
    shutil.rmtree(copied.run / "results/registration")
    (copied.run / "results/registration").mkdir()
    results = copied.run / "results"
    with mounted(results, "--bind", str(results)):
        subprocess.run(["mount", "-o", "remount,ro,bind", str(results)], check=True)
        ended = copied.snakemake("--keep-going", *TARGETS)
        assert ended.returncode != 0
        assert "Read-only file system" in ended.stdout
    finish(copied)
    require_as_undisturbed(copied, undisturbed)


@pytest.mark.parametrize(
    ("cut", "reader"),
    [
        ("results/images/small/supine.nii.gz", "results/registration/small/supine.tfm"),
        ("results/fiducials/small/supine.csv", "results/registration/small/supine.tfm"),
        ("results/truth/small/supine.vtu", "results/raw/small/supine_fiducials.csv"),
        ("results/truth/small/supine_motion.tfm", "results/raw/small/supine_fiducials.csv"),
    ],
)
def test_a_file_that_was_cut_off_is_named_by_what_reads_it_and_made_again(copied, undisturbed, cut, reader):
    file = copied.run / cut
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    (copied.run / reader).unlink(missing_ok=True)
    ended = copied.snakemake("--keep-going", reader)
    log = "\n".join(each.read_text() for each in (copied.run / "results/logs").rglob("*.log"))
    assert file.name in ended.stdout + log
    assert ended.returncode != 0 or "no answer" in log
    file.unlink()
    again = copied.snakemake(reader)
    assert again.returncode == 0, again.stdout[-4000:]
    assert file.read_bytes() == undisturbed.files[cut.removeprefix("results/")]


def test_a_cache_of_kernels_that_was_cut_off_is_left_aside(new, undisturbed, tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kernels"))
    finish(new)
    for file in (tmp_path / "kernels").rglob("*.nb?"):
        file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    shutil.rmtree(new.run / "results")
    finish(new)
    require_as_undisturbed(new, undisturbed)
