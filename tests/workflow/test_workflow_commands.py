"""The commands of README and of the documentation can be planned, as they are typed."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from commands import PLANNED
from tiny_woman import tiny_labels

from mammosim.io.images import write_labels

pytestmark = pytest.mark.workflow
EXTEND = Path(__file__).parents[2] / "docs/extend.md"

# The scene of docs/extend.md.
SCENE = re.findall(r"^```yaml\n(.*?)^```$", EXTEND.read_text(encoding="utf-8"), flags=re.M | re.S)[0]
# What a page has written before: her table and settings, and a scene with its settings.
GIVEN = {
    "mine/volunteers.tsv": "volunteer\tposition\tlabels\tgravity\nada\tprone\tmine/labels.nii.gz\t0 -1 0\n",
    "mine/mine.yaml": "volunteers: [ada]\nvolunteer_table: mine/volunteers.tsv\n",
    "mine/scenes.yaml": "scenes: {names: [bending]}\n",
    "config/scenes/bending.yaml": SCENE,
}


def grouped(planned: set[str]) -> dict[str, list[str]]:
    """Options -> targets: one dry run of all that have the same options, of which cores are none."""
    groups: dict[str, list[str]] = {}
    for line in sorted(planned):
        words = shlex.split(line)
        words = words[2:] if words[0] == "--cores" else words
        first = next((k for k, word in enumerate(words) if word[0] != "-"), len(words))
        split = words.index("--") if "--" in words else len(words) if "--profile" in words else first
        options, targets = words[:split], [word for word in words[split:] if word != "--"]
        groups.setdefault(shlex.join(options), []).extend(targets)
    return groups


GROUPS = grouped(PLANNED)


def test_every_command_is_in_a_group():
    assert {"", "-n", "--list", "--profile workflow/profiles/local"} < set(GROUPS)
    assert {"plan", "peers", "results/study/sweep.csv"} < set(GROUPS[""])


@pytest.mark.parametrize("options", GROUPS)
def test_commands_can_be_planned(options, study, tmp_path):
    os.symlink(study.home / "workflow", tmp_path / "workflow")
    shutil.copytree(study.home / "config", tmp_path / "config")
    for name, text in GIVEN.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    write_labels(tiny_labels(8.0), tmp_path / "mine/labels.nii.gz")
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(study.home / "workflow/Snakefile")]
    command += ["--workflow-profile", "none", "--quiet", "rules", *shlex.split(options)]
    command += [] if options == "--list" else ["--dry-run", "--cores", "2"]
    ran = run(command + (["--", *GROUPS[options]] if GROUPS[options] else []), tmp_path)
    assert ran.returncode == 0, ran.stdout[-3000:]
    assert "mammogram" in ran.stdout or "scene" in ran.stdout or "check_page" in ran.stdout


def run(command: list[str], folder: Path) -> "subprocess.CompletedProcess[str]":
    """Both streams as text in stdout."""
    return subprocess.run(
        command, cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False
    )
