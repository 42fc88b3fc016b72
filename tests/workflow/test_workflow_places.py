"""The study runs wherever it lies, and what it made stays valid when it is moved."""

import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path


def test_blanks_and_umlauts_in_every_path_and_no_locale(study, tmp_path):
    home, run = tmp_path / "meine Prüfung", tmp_path / "the results"
    shutil.copytree(study.home, home)
    run.mkdir()
    environment = tmp_path / "an environment"
    environment.symlink_to(Path(sys.prefix), target_is_directory=True)
    command = [
        *(
            str(environment / "bin/python"),
            "-m",
            "snakemake",
            "--snakefile",
            str(home / "workflow/Snakefile"),
        ),
        *("--directory", str(run), "--configfile", str(home / "config/smoke.yaml"), "--cores", "2"),
        *("--workflow-profile", "none", "results/truth/small/stress_free.vtu"),
    ]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    locale = {"LC_ALL": "C", "LANG": "C"}
    ended = subprocess.run(command, env=os.environ | locale, text=True, check=False, **pipes)
    assert ended.returncode == 0, ended.stdout[-3000:]
    assert (run / "results/truth/small/stress_free.vtu").exists()


def test_a_moved_checkout_and_its_results_are_up_to_date(finished, tmp_path):
    there = replace(finished, home=tmp_path / "home", run=tmp_path / "run")
    shutil.copytree(finished.home, there.home)
    shutil.copytree(finished.run, there.run, symlinks=True)
    assert "Nothing to be done" in there.snakemake("--dry-run").stdout
