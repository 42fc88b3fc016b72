"""Another workflow uses the study as a module: its rules under other names, with settings of its own."""

import subprocess
import sys

import pytest
import yaml

USER = """\
configfile: "config.yaml"


module mammosim:
    snakefile:
        "{snakefile}"
    config:
        config["mammosim"]


use rule * from mammosim as mammosim_*


rule all:
    default_target: True
    input:
        "results/xray/spectrum.csv",
        "results/compression/small/left/standard_gravity.csv",
    output:
        "both.txt",
    shell:
        "cat {{input}} > {{output}}"
"""


@pytest.fixture
def used(study, tmp_path):
    """A function: what Snakemake says of a workflow that uses the study with such settings."""

    def run(settings: dict, *arguments: str) -> subprocess.CompletedProcess[str]:
        (tmp_path / "workflow").mkdir(exist_ok=True)
        snakefile = study.home / "workflow/Snakefile"
        (tmp_path / "workflow/Snakefile").write_text(USER.format(snakefile=snakefile))
        (tmp_path / "config.yaml").write_text(yaml.safe_dump({"mammosim": settings}))
        command = [sys.executable, "-m", "snakemake", "--cores", "1", *arguments]
        out = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
        return subprocess.run(command, cwd=tmp_path, text=True, check=False, **out)

    return run


def test_rules_and_settings_of_a_module(used):
    result = used({"volunteers": ["small"], "xray": {"peak_kv": 27.0}}, "--dry-run", "--jobs", "9")
    assert result.returncode == 0, result.stdout[-3000:]
    assert "mammosim_compress" in result.stdout
    assert "mammosim_spectrum" in result.stdout
    (asked,) = [
        each.split("resources: ")[1].split("\n")[0]
        for each in result.stdout.split("rule ")
        if each.startswith("mammosim_compress:")
    ]
    assert "runtime=11" in asked, "measured under its own name"


def test_a_job_of_a_module_finds_its_script_and_the_package(used, tmp_path):
    result = used({"volunteers": ["small"]}, "results/segmentation/tissues.ctbl")
    assert result.returncode == 0, result.stdout[-3000:]
    assert "glandular" in (tmp_path / "results/segmentation/tissues.ctbl").read_text()


def test_a_setting_that_cannot_be_meant_is_told(used):
    result = used({"xray": {"peak_kvp": 27.0}}, "--dry-run")
    assert result.returncode != 0
    assert "xray has no key 'peak_kvp'; did you mean 'peak_kv'?" in result.stdout
    assert "the config of the module" in result.stdout


def test_the_catalogue_finds_what_it_looks_for(repository):
    described = yaml.safe_load((repository / ".snakemake-workflow-catalog.yml").read_text())
    assert set(described["usage"]) == {"mandatory-flags", "software-stack-deployment", "report"}
    assert (repository / "workflow/Snakefile").exists()
    # One in the root that includes it would be taken first, and know neither its default target (`include`
    # forgets it) nor its profile (which is looked for beside the Snakefile): `snakemake` would do nothing.
    assert not (repository / "Snakefile").exists()
    assert (repository / "config/README.md").exists()
