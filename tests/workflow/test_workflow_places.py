"""The study runs wherever it lies, and what it made stays valid when it is moved."""

import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from tiny_woman import tiny_labels
from whole_study import copy_of_the_study

from mammosim.io.images import write_labels

# What lets root write where the permissions forbid it; without it root is held to them as any other user.
PRIVILEGES = "-dac_override,-dac_read_search"


def held_to_permissions():
    """What starts a command as a user who may not write what is read-only."""
    if os.geteuid() != 0:
        return []
    if shutil.which("setpriv") is None:
        pytest.skip("root, and no setpriv to give its privileges up")
    return ["setpriv", "--bounding-set", PRIVILEGES, "--inh-caps", PRIVILEGES]


def read_only(folder):
    """Take the right to write from all in a folder."""
    for path in (folder, *folder.rglob("*")):
        path.chmod(path.stat().st_mode & ~0o222)


def own_woman(run):
    """Her labels, table and settings in the folder of a run; the file of settings."""
    mine = run / "mine"
    mine.mkdir(parents=True)
    write_labels(tiny_labels(), mine / "labels.nii.gz")
    (mine / "volunteers.tsv").write_text(
        "volunteer\tposition\tlabels\tgravity\nada\tprone\tmine/labels.nii.gz\t0 -1 0\n"
    )
    (mine / "mine.yaml").write_text("volunteers: [ada]\nvolunteer_table: mine/volunteers.tsv\n")
    return mine / "mine.yaml"


def test_a_read_only_checkout_without_a_home_or_locale_and_with_blanks_and_umlauts_in_every_path(
    repository, tmp_path
):
    """Nothing is written but in the folder of the run, which keeps compiled kernels, too."""
    start = held_to_permissions()
    checkout = copy_of_the_study(repository, tmp_path / "meine Prüfung").home
    home, run, temporary = tmp_path / "home", tmp_path / "the results", tmp_path / "a tmp"
    environment = tmp_path / "an environment"
    environment.symlink_to(Path(sys.prefix), target_is_directory=True)
    settings = own_woman(run)
    for folder in (home, temporary):
        folder.mkdir()
    for cache in list(checkout.rglob("__pycache__")):
        shutil.rmtree(cache)
    before = sorted(checkout.rglob("*"))
    read_only(checkout)
    read_only(home)
    command = [
        *(
            *start,
            str(environment / "bin/python"),
            "-m",
            "snakemake",
            "--directory",
            str(run),
            "--cores",
            "2",
        ),
        *("--snakefile", str(checkout / "workflow/Snakefile"), "--configfile"),
        *(str(checkout / "config/own.yaml"), str(checkout / "config/smoke.yaml"), str(settings)),
        *("--", "results/meshes/ada/prone.vtu"),
    ]
    names = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("XDG_", "NUMBA_CACHE", "MPL"))
    }
    names |= {"HOME": str(home), "TMPDIR": str(temporary), "LC_ALL": "C", "LANG": "C"}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    ended = subprocess.run(command, env=names, text=True, check=False, **pipes)
    assert ended.returncode == 0, ended.stdout[-3000:]
    assert (run / "results/meshes/ada/prone.vtu").exists()
    assert list((run / ".snakemake/cache").rglob("*.nbc")), "compiled once, not in every job"
    assert "ILP solver" not in ended.stdout
    assert list(home.iterdir()) == []
    assert list(temporary.iterdir()) == []
    assert sorted(checkout.rglob("*")) == before


def test_a_moved_checkout_and_its_results_are_up_to_date(finished, tmp_path):
    there = replace(finished, home=tmp_path / "home", run=tmp_path / "run")
    shutil.copytree(finished.home, there.home)
    shutil.copytree(finished.run, there.run, symlinks=True)
    assert "Nothing to be done" in there.snakemake("--dry-run").stdout
