"""A job that fails stops its own branch only; the last lines of the terminal name it, why, and its log."""

import re
import shutil
from dataclasses import replace

import pytest
from whole_study import cost

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


def minutes_left(said: str) -> list[int]:
    """What was said to be left, each time that a job had ended."""
    return [int(minutes) for minutes in re.findall(r"about (\d+) min left", said)]


def test_a_failure_is_named_last_and_the_other_jobs_have_run(broken):
    # On one core, the longer chain begins: the other job starts when the failure is known.
    cost(broken, "digital_body", 6000.0)
    result = broken.snakemake("--keep-going", "--cores", "1", BRANCH, BESIDE)
    assert result.returncode != 0
    lines = result.stdout.splitlines()[-20:]
    log = broken.run / "results/logs/digital_woman/large.log"
    named = lines.index("  digital_woman large: RuntimeError: a fault of the program")
    assert lines[named + 1] == f"    log: {log}"
    assert "Not run, since they need what failed: 1 job." in lines
    assert lines[-1].startswith(f"All the remaining results are in {broken.run / 'results'}")
    assert "RuntimeError" in log.read_text()
    assert (broken.run / BESIDE).exists()
    assert minutes_left(result.stdout)[-1] == 1, "what cannot run any more takes no time"


def test_what_a_job_took_is_learned_for_the_next_one_of_its_rule(study, tmp_path):
    home, run = tmp_path / "home", tmp_path / "run"
    shutil.copytree(study.home, home)
    run.mkdir()
    slow = replace(study, home=home, run=run)
    cost(slow, "digital_woman", 3600.0)
    women = [f"results/truth/{name}/woman.json" for name in ("small", "large")]
    said = slow.snakemake("--cores", "1", *women).stdout
    # The table has said 60 min, and is believed like one of two jobs, at a pace that is half learned.
    assert minutes_left(said)[0] < 20, said[-3000:]
