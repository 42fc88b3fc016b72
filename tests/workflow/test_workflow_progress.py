"""A job that fails stops its own branch only; the last lines of the terminal name it, why, and its log."""

import shutil
from dataclasses import replace

import pytest

pytestmark = pytest.mark.workflow
BRANCH = "results/truth/large/stress_free.vtu"  # needs the woman whose script is broken
BESIDE = "results/xray/spectrum.csv"


@pytest.fixture
def broken(study, tmp_path):
    """A copy of the study with a fault in the script that makes one of the two women."""
    home, run = tmp_path / "home", tmp_path / "run"
    shutil.copytree(study.home, home)
    run.mkdir()
    script = home / "workflow/scripts/digital_woman.py"
    fault = 'if "large" in out:\n        raise RuntimeError("a fault of the program")\n    '
    script.write_text(script.read_text().replace("    write_json(", f"    {fault}write_json("))
    return replace(study, home=home, run=run)


def test_a_failure_is_named_last_and_the_other_jobs_have_run(broken):
    # On one core, the longer chain begins: the other job starts when the failure is known.
    result = broken.snakemake("--keep-going", "--cores", "1", BRANCH, BESIDE)
    assert result.returncode != 0
    lines = result.stdout.splitlines()[-20:]
    log = broken.run / "results/logs/digital_woman/large.log"
    named = lines.index("  digital_woman large: RuntimeError: a fault of the program")
    assert lines[named + 1] == f"    log: {log}"
    assert "Not run, for want of what failed: 1 job." in lines
    assert lines[-1].startswith(f"All the rest is there, in {broken.run / 'results'}")
    assert "RuntimeError" in log.read_text()
    assert (broken.run / BESIDE).exists()
