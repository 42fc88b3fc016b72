"""A folder in which a run is at work, or was killed: no other run begins there, and who looks on may."""

import os
from dataclasses import replace

import pytest

from mammosim.study.jobs.last_words import Run

SPECTRUM = "results/xray/spectrum.csv"


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
