"""Which job goes first, and how a run ends: by Ctrl-C, by input that is rejected, by what a cluster says."""

import os
import re
import signal
import subprocess
import sys
import time

import pytest
from whole_study import Study, cost, with_words_for_scripts

pytestmark = pytest.mark.workflow
SPECTRUM = "results/xray/spectrum.csv"
WOMEN = [f"results/truth/{name}/woman.json" for name in ("small", "large")]
# A file says that the job is at work; it does not listen to Ctrl-C, which is for its run to handle.
ENDLESS = """import time
from pathlib import Path

import _log

_log.to(snakemake.log[0])
Path("begun").touch()
time.sleep(300)
Path(snakemake.output[0]).write_text("made")
"""
REJECTING = """import _log

from mammosim.core.errors import ImageError

_log.to(snakemake.log[0])
raise ImageError("no image of a breast")
"""
# An executor that submits a job to nobody, and says of its end what Slurm's does.
LOST = '''"""A cluster that ends every job."""
from pathlib import Path

from snakemake_interface_executor_plugins.executors.base import AbstractExecutor, SubmittedJobInfo
from snakemake_interface_executor_plugins.settings import CommonSettings

common_settings = CommonSettings(non_local_exec=True, implies_no_shared_fs=False, job_deploy_sources=False)


class Executor(AbstractExecutor):
    def run_job(self, job):
        log = Path("slurm.log").absolute()
        log.write_text("slurmstepd: error: *** JOB 7 ON vm CANCELLED AT 13:30 DUE TO TIME LIMIT ***")
        submitted = SubmittedJobInfo(job=job)
        self.report_job_submission(submitted)
        self.report_job_error(submitted, msg="SLURM status is: 'FAILED'.", aux_logs=[str(log)])

    def get_exec_mode(self):
        raise NotImplementedError

    handle_job_success = handle_job_error = lambda self, job: None
    cancel = shutdown = lambda self: None
    cores = 1
'''


@pytest.fixture
def quick(study, tmp_path) -> Study:
    """The study with scripts that compute nothing."""
    return with_words_for_scripts(study, tmp_path)


def order(study: Study, *targets: str) -> list[str]:
    """The rules of the jobs in the order in which they began, on one core."""
    ended = study.snakemake("--cores", "1", *targets)
    assert ended.returncode == 0, ended.stdout[-3000:]
    return re.findall(r"^localrule (\w+):$", ended.stdout, re.M)


@pytest.mark.parametrize(("woman_s", "first"), [(900.0, "digital_woman"), (1.0, "spectrum")])
def test_the_longest_chain_of_jobs_begins_first(quick, woman_s, first):
    cost(quick, "digital_woman", woman_s)
    cost(quick, "spectrum", 30.0)
    assert order(quick, WOMEN[0], SPECTRUM)[0] == first


def test_what_has_been_learned_changes_which_job_goes_next(quick):
    """By the table a woman takes longer than the spectrum; one took a moment: the other comes last."""
    cost(quick, "digital_woman", 100.0)
    cost(quick, "spectrum", 90.0)
    assert order(quick, *WOMEN, SPECTRUM) == ["digital_woman", "spectrum", "digital_woman"]


def test_ctrl_c_ends_a_job_that_would_go_on_and_lets_none_begin(quick):
    (quick.home / "workflow/scripts/digital_woman.py").write_text(ENDLESS)
    run = begun(quick, "--keep-going", *WOMEN)
    try:
        os.killpg(run.pid, signal.SIGINT)
        said, _ = run.communicate(timeout=60)
    finally:
        run.kill()
    assert run.returncode != 0
    assert said.splitlines()[-3].startswith("Stopped as you asked; 2 jobs left")
    assert not [path for path in WOMEN if (quick.run / path).exists()]


def begun(study: Study, *arguments: str) -> subprocess.Popen[str]:
    """A run in a session of its own, as a terminal begins it, whose job is at work."""
    command = [
        *(sys.executable, "-m", "snakemake", "--snakefile", str(study.home / "workflow/Snakefile")),
        *("--directory", str(study.run), "--configfile", str(study.home / "config/smoke.yaml")),
        *("--cores", "1", "--workflow-profile", "none", *arguments),
    ]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    run = subprocess.Popen(command, text=True, start_new_session=True, **pipes)
    end = time.monotonic() + 120
    while not (study.run / "begun").exists():
        assert run.poll() is None, run.communicate()
        assert time.monotonic() < end
        time.sleep(0.05)
    return run


def test_rejected_input_ends_a_run_that_else_keeps_going(quick):
    (quick.home / "workflow/scripts/check_input.py").write_text(REJECTING)
    cost(quick, "spectrum", 0.0)  # the last of what can begin
    checked = "results/checked/small_prone.csv"
    ended = quick.snakemake("--cores", "1", "--keep-going", checked, SPECTRUM)
    assert ended.returncode != 0
    assert "ImageError: no image of a breast" in "\n".join(ended.stdout.splitlines()[-20:])
    assert not (quick.run / SPECTRUM).exists(), "it is to be mended before anything long runs"


def test_why_a_cluster_ended_a_job_is_the_reason_that_is_told(quick, tmp_path):
    plugin = tmp_path / "plugins/snakemake_executor_plugin_lost"
    plugin.mkdir(parents=True)
    (plugin / "__init__.py").write_text(LOST)
    path = os.pathsep.join([str(plugin.parent), os.environ.get("PYTHONPATH", "")])
    cluster = ("--executor", "lost", "--jobs", "2", "--retries", "0")
    ended = quick.snakemake(*cluster, SPECTRUM, env={"PYTHONPATH": path})
    assert ended.returncode != 0
    told = "  spectrum: out of time: it needed more than its runtime = 10 min"
    assert any(line.startswith(told) for line in ended.stdout.splitlines()[-12:]), ended.stdout[-3000:]
