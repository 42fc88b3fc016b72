"""What a cluster is asked for: of every rule what it was measured to take, or what the user says."""

import re
import shutil
from dataclasses import replace

import pytest
import yaml

COLOURS = "results/segmentation/tissues.ctbl"
SPECTRUM = "results/xray/spectrum.csv"
CAMPAIGN = """
title: How hard does a flexible paddle press?
vary:
  load.paddle: {named: {bent: {flexible: {youngs_modulus_mpa: 2400.0, thickness_mm: 2.5}}}}
  load.tissues.glandular.youngs_modulus_kpa: {from: 0.5, to: 8, number: 20}
asked: [force_n]
"""
PROFILES = ("default", "local", "slurm")


def asked(study, *arguments: str) -> dict[str, dict[str, str]]:
    """Rule -> resources of its jobs in a dry run."""
    found, rule = {}, ""
    for line in study.snakemake("--dry-run", *arguments).stdout.splitlines():
        word, _, rest = line.strip().partition(": ")
        if named := re.fullmatch(r"(?:local)?(?:rule|checkpoint) (\w+):?", line.strip()):
            rule = named[1]
        elif word == "resources" and rule:
            found[rule] = dict(each.split("=", 1) for each in rest.split(", "))
    return found


def test_every_job_of_a_cluster_asks_for_memory_with_its_starts_and_for_time(study):
    here, there = asked(study, "--forceall"), asked(study, "--forceall", "--jobs", "9")
    assert here.keys() == there.keys()
    rules = [name for name in there if "mem_mb" in here[name]]
    assert len(rules) > 50
    assert [name for name in rules if int(there[name]["mem_mb"]) < 600] == []
    assert [name for name in rules if int(there[name]["runtime"]) < 10] == []
    # Of a digital volunteer it takes a second, of a heavy woman minutes.
    assert int(there["stress_free"]["runtime"]) > 20
    assert not any("runtime" in each for each in here.values()), "one machine needs none"


def test_a_batch_of_a_campaign_asks_for_the_time_of_its_points(study):
    (study.home / "config/campaigns/long.yaml").write_text(CAMPAIGN)
    with (study.home / "config/costs.tsv").open() as file:
        costs = dict(line.split("\t")[:2] for line in file if line.startswith("point_"))
    there = asked(study, "--jobs", "9", "campaign_long")
    seconds = 20 * float(costs["point_pressed_flexible"])
    assert int(there["campaigns_batch"]["runtime"]) > 3 * seconds / 60


def test_each_attempt_asks_for_twice_the_memory_and_time(study, tmp_path):
    home, run = tmp_path / "home", tmp_path / "run"
    shutil.copytree(study.home, home)
    run.mkdir()
    (home / "workflow/scripts/label_colours.py").write_text("raise RuntimeError\n")
    ended = replace(study, home=home, run=run).snakemake("--jobs", "9", "--retries", "2", COLOURS)
    assert ended.returncode != 0
    asked = re.findall(r"resources: .*\bmem_mb=(\d+).*\bruntime=(\d+)", ended.stdout)
    assert [int(minutes) for _, minutes in asked] == [10, 20, 40]
    assert [int(mb) / int(asked[0][0]) for mb, _ in asked] == [1, 2, 4]


def test_what_the_user_says_of_a_rule_wins(study):
    chosen = asked(study, "--jobs", "9", "--set-resources", "spectrum:mem_mb=1234", "--", SPECTRUM)
    assert chosen["spectrum"]["mem_mb"] == "1234"
    assert chosen["spectrum"]["runtime"] == "10"


@pytest.mark.parametrize("name", PROFILES)
def test_every_entry_of_a_profile_is_explained(repository, name):
    folder = repository / "workflow/profiles"
    entries = yaml.safe_load((folder / name / "config.yaml").read_text())
    told = (folder / "README.md").read_text().split(f"## `{name}`")[1].split("\n## ")[0]
    keys = [*entries, *entries.get("default-resources", {})]
    assert [key for key in keys if f"`{key}" not in told] == []
