"""A job that a cluster has ended is told by its cause, in one line, with what it had asked for."""

import pytest

from mammosim.study.jobs.cluster_words import cluster_reason
from mammosim.study.jobs.last_words import Failure

ASKED = {"mem_mb": 1300, "runtime": 10}
STATUS = "SLURM-job '7' failed, SLURM status is: '{}'. Detailed failure reason unavailable."
TRACEBACK = "Traceback (most recent call last):\n  File\nValueError: wrong\n"


@pytest.mark.parametrize(
    ("log", "status", "words"),
    [
        ("slurmstepd: error: *** JOB 7 ON vm CANCELLED AT 13:30 DUE TO TIME LIMIT ***", "FAILED", "= 10 min"),
        ("", "TIMEOUT", "out of time"),
        ("slurmstepd: error: Detected 1 oom_kill event in StepId=7.0.", "FAILED", "mem_mb = 1300"),
        ("slurmstepd-vm: error: Step 7 exceeded memory limit (14 > 13)", "CANCELLED", "= 1300"),
        ("slurmstepd: error: StepId=7.0 exceeded memory limit (1 > 0)", "FAILED", "out of memory"),
        ("", "OUT_OF_MEMORY", "out of memory"),
        ("slurmstepd: error: Some of the step tasks have been OOM Killed.", "FAILED", "out of memory"),
        ("slurmstepd: error: *** JOB 7 ON vm CANCELLED AT 2026-11-30T13:30:00 ***", "CANCELLED", "cancelled"),
        ("", "CANCELLED", "cancelled on the cluster"),
        ("srun: error: slow\nsrun: error: vm: no such node", "FAILED", "says: vm: no such node"),
        ("srun: error: vm: task 0: Segmentation fault", "FAILED", "says: vm: task 0: Segmentation fault"),
        (f"{TRACEBACK}srun: error: vm: task 0: Exited with exit code 1", "FAILED", "ValueError: wrong"),
        ("", "NODE_FAIL", "NODE_FAIL"),
    ],
)  # fmt: skip
def test_the_cause_is_named_in_one_line(log, status, words):
    reason = cluster_reason(f"Building DAG of jobs...\n{log}\nmore", STATUS.format(status), ASKED)
    assert words in reason
    assert "\n" not in reason


def test_of_what_the_cluster_says_of_an_end_the_first_line_is_the_reason():
    assert cluster_reason("", "the node is gone\nand more", ASKED) == "the node is gone"
    assert cluster_reason("", "", ASKED) == "the cluster gives no reason"


def test_a_submission_that_is_refused_is_told_by_its_error():
    status = "SLURM sbatch failed. The error message was 'sbatch: error: invalid partition specified: x\n'.\n"
    assert "invalid partition" in cluster_reason("", status, {})


def test_the_job_s_own_error_is_nearer_than_what_the_cluster_says(tmp_path):
    log = tmp_path / "job.log"
    log.write_text(TRACEBACK)
    assert (
        Failure("compress small", log, cluster="out of time").lines(0.0)[0]
        == "  compress small: ValueError: wrong"
    )
    log.write_text("step 1\n")
    assert (
        Failure("compress small", log, cluster="out of time").lines(0.0)[0] == "  compress small: out of time"
    )
    told = Failure("compress small", log, mem_mb=4000, cluster="MemoryError of a node").lines(0.0)[0]
    assert told == "  compress small: MemoryError of a node", "fewer jobs at once leave no more on a cluster"
    assert Failure("compress small", None, cluster="out of time").lines(0.0) == [
        "  compress small: out of time"
    ]
