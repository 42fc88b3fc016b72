"""The study runs wherever it lies: blanks and umlauts in the paths of checkout, environment and results."""

import shutil
import subprocess
import sys
from pathlib import Path


def test_blanks_and_umlauts_in_every_path(study, tmp_path):
    home, run = tmp_path / "meine Prüfung", tmp_path / "the results"
    shutil.copytree(study.home, home)
    run.mkdir()
    environment = tmp_path / "an environment"
    environment.symlink_to(Path(sys.prefix), target_is_directory=True)
    command = [
        *(str(environment / "bin/python"), "-m", "snakemake", "--snakefile", str(home / "Snakefile")),
        *("--directory", str(run), "--configfile", str(home / "config/smoke.yaml"), "--cores", "2"),
        *("--workflow-profile", "none", "results/truth/small/stress_free.vtu"),
    ]
    ended = subprocess.run(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    assert ended.returncode == 0, ended.stdout[-3000:]
    assert (run / "results/truth/small/stress_free.vtu").exists()
