"""The study through a Slurm of one host: what it asks for, what it says of failures, and the tiny study."""

import os
import shutil
import subprocess
import sys
from dataclasses import replace
from functools import partial

import pandas as pd
import pytest
from one_host_slurm import lacking, one_host_slurm
from whole_study import Study

from mammosim.study.jobs.requests import STARTS_MB

pytestmark = [pytest.mark.cluster, pytest.mark.skipif(bool(lacking()), reason=lacking() or "there is one")]
IN_A_JOB, HERE = "results/xray/spectrum.csv", "results/segmentation/tissues.ctbl"
CAMPAIGN = """
title: How much exposure does the machine choose?
vary: {xray.peak_kv: {from: 26, to: 34, number: 5}}
asked: [exposure_mas]
"""
WOMAN = "results/truth/small/stress_free.vtu"  # needs two jobs, the first of which is run here


@pytest.fixture(scope="module")
def slurm(tmp_path_factory):
    """A running Slurm with the cores of this host; memory is not what limits it."""
    with one_host_slurm(
        tmp_path_factory.mktemp("slurm"), cpus=os.cpu_count() or 1, memory_mb=16000
    ) as running:
        yield running


def submitted(study: Study, slurm, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run snakemake by the profile, as a user does: with no number of cores."""
    command = [
        *(sys.executable, "-m", "snakemake", "--snakefile", str(study.home / "workflow/Snakefile")),
        *("--directory", str(study.run), "--configfile", str(study.home / "config/smoke.yaml")),
        *("--profile", str(study.home / "workflow/profiles/slurm"), "--workflow-profile", "none"),
        *("--slurm-status-command", "squeue", "--slurm-init-seconds-before-status-checks", "3"),
        *arguments,
    ]
    out = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    return subprocess.run(command, env=slurm.environment, text=True, check=False, **out)


def last_job(slurm) -> int:
    """The number of the job that was submitted last."""
    return max((job.number for job in slurm.jobs()), default=0)


@pytest.fixture
def on_cluster(study, slurm, tmp_path):
    """Run targets in an empty folder."""
    return partial(submitted, replace(study, run=tmp_path), slurm)


def test_a_job_says_its_rule_and_asks_for_what_was_measured(on_cluster, slurm, tmp_path):
    before = last_job(slurm)
    result = on_cluster(IN_A_JOB, HERE)
    assert result.returncode == 0, result.stdout[-3000:]
    assert (tmp_path / IN_A_JOB).exists()
    assert (tmp_path / HERE).exists()
    (job,) = slurm.jobs(since=before)  # the other one is too short for a job of its own
    assert job.state == "COMPLETED"
    assert job.comment == "rule_spectrum"
    assert STARTS_MB + 200 <= job.memory_mb < 1500
    assert job.partition == "main"


def test_wildcards_partition_and_resources_are_as_the_user_says(on_cluster, slurm):
    before = last_job(slurm)
    chosen = ("--default-resources", "slurm_partition=long", "--set-resources", "digital_body:mem_mb=1234")
    result = on_cluster(WOMAN, *chosen)
    assert result.returncode == 0, result.stdout[-3000:]
    (job,) = slurm.jobs(since=before)
    assert job.comment == "rule_digital_body_wildcards_small"
    assert (job.memory_mb, job.partition) == (1234, "long")


def test_a_failed_job_is_named_last_with_its_reason_and_its_log(study, slurm, tmp_path):
    home, run = tmp_path / "home", tmp_path / "run"
    shutil.copytree(study.home, home)
    run.mkdir()
    script = home / "workflow/scripts/digital_body.py"
    script.write_text(f"raise RuntimeError('a fault of the program')\n{script.read_text()}")
    broken = replace(study, home=home, run=run)
    result = submitted(broken, slurm, WOMAN, "--retries", "0")
    assert result.returncode != 0
    lines = result.stdout.splitlines()[-12:]
    assert "  digital_body small: RuntimeError: a fault of the program" in lines, result.stdout[-3000:]
    assert any(line.endswith("results/logs/digital_body/small.log") for line in lines)


def test_a_job_without_memory_enough_is_tried_again_and_then_told_in_words(on_cluster, slurm):
    before = last_job(slurm)
    result = on_cluster(IN_A_JOB, "--set-resources", "spectrum:mem_mb=40", "--retries", "1")
    assert result.returncode != 0
    (told,) = [line for line in result.stdout.splitlines()[-12:] if line.startswith("  spectrum")]
    assert "out of memory: it needed more than its mem_mb = 40" in told
    assert len(slurm.jobs(since=before)) == 2


def test_the_tiny_study_ends_with_its_report_and_has_a_campaign(on_cluster, slurm, tmp_path):
    result = on_cluster()
    assert result.returncode == 0, result.stdout[-6000:]
    assert (tmp_path / "results/study/report.html").exists()
    assert (tmp_path / "results/study/missing.csv").read_text().count("\n") == 1, "a header and no row"
    # Its name stands in the comment of a job and in the path of its log.
    file = tmp_path / "config/campaigns/exposure (größe 1).yaml"
    file.parent.mkdir(parents=True)
    file.write_text(CAMPAIGN, encoding="utf-8")
    before = last_job(slurm)
    result = on_cluster("--", f"campaign_{file.stem}")
    assert result.returncode == 0, result.stdout[-6000:]
    batch, page = slurm.jobs(since=before)  # the table is too short for a job of its own
    assert batch.comment.startswith(f"rule_campaigns_batch_wildcards_{file.stem}_small_left_")
    assert page.state == "COMPLETED"
    table = pd.read_csv(tmp_path / f"results/campaigns/{file.stem}.csv")
    assert table.outcome.tolist() == ["converged"] * 5
    assert (table.exposure_mas.diff().dropna() < 0).all(), "harder photons need less exposure"
