"""The lock of a cluster has what the lock of the study lacks, and nothing twice."""

import importlib.util
import re

import pytest


@pytest.fixture
def without(repository):
    spec = importlib.util.spec_from_file_location("without_pins", repository / "tools/without_pins.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.without


def names(text: str) -> set[str]:
    return set(re.findall(r"(?m)^([\w.-]+)==", text))


def test_pins_of_the_other_lock_are_left_out_with_their_hashes(without):
    lock = "a==1 \\\n    --hash=sha256:1\nb==2 \\\n    --hash=sha256:2\n"
    assert without(lock, "b==2 \\\n    --hash=sha256:2\n") == "a==1 \\\n    --hash=sha256:1\n"


def test_what_slurm_needs_stands_in_its_own_lock(repository):
    """Snakemake imports every plugin that is installed at each start, and Slurm's imports pandas."""
    cluster, study = ((repository / f"{name}.lock").read_text() for name in ("cluster", "environment"))
    assert names(cluster) == {"snakemake-executor-plugin-slurm", "snakemake-executor-plugin-slurm-jobstep"}
    assert not names(cluster) & names(study)
    assert "throttler" in names(study)
