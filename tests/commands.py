"""The commands of README and of the documentation, and how each is tested."""

import re
from collections.abc import Mapping
from pathlib import Path

BLOCK = re.compile(r"^( *)```sh\n(.*?)^ *```$", re.M | re.S)
SNAKEMAKE = ".venv/bin/snakemake "
# Its blocks are dry runs as a whole: tests/workflow/test_workflow_check.py.
WHOLE_BLOCKS = "config/README.md"
OWN = "--cores 2 --configfile config/own.yaml mine/mine.yaml --"

# Run by Snakemake as a dry run (tests/workflow/test_workflow_commands.py): what follows its name.
PLANNED = {
    "-n",
    "--list",
    "--cores 2",
    "--profile workflow/profiles/local",
    "--cores 2 --configfile mine/scenes.yaml -- scenes",
    "--cores 2 plan",
    "--cores 2 crate",
    "--cores 2 campaign_example",
    "--cores 2 hard_cases",
    "--cores 2 recovery",
    "--cores 2 wrong_model",
    "--cores 2 models",
    "--cores 2 softening",
    "--cores 2 scenes",
    "--cores 2 accuracy",
    "--cores 1 peers_xray",
    "--cores 1 peers",
    "--cores 2 results/study/sweep.csv",
    "--cores 2 results/study/figures/trade_off.png",
    f"{OWN} check",
    f"{OWN} results/women/ada/what.html",
    f"{OWN} results/xray/ada/left/standard_gravity_image.csv",
}
# Targets of make, and what runs the same; `make -n` is run of each.
MADE = {
    "smoke": "tests/artefacts/test_artefacts_tables.py::test_no_table_is_empty_and_no_column_is",
    "study": "tests/workflow/test_workflow_commands.py::test_commands_can_be_planned",
    "test": "",
    "lint": "tests/unit/tools/test_tools_check_lint.py",
    "docs": "tests/unit/docs/test_docs_site.py::test_the_site_is_built_without_a_warning",
    "cluster": "tests/workflow/test_workflow_cluster.py",
    "peers": "tests/unit/tools/test_tools_check_peers.py",
    "robust": "tests/unit/tools/test_tools_robust.py",
    "machines": "tests/workflow/test_workflow_machines.py",
    "test-faults": "tests/workflow/test_workflow_faults.py",
    "test-cluster": "tests/workflow/test_workflow_cluster.py",
    "lock": "tests/unit/tools/test_tools_lock.py",
}
EXAMPLES = "tests/unit/examples/test_examples.py::test_an_example_runs_and_prints_what_is_sound"
# What has been typed before the commands of that test.
TYPED = "tests/workflow/test_workflow_commands.py::test_commands_can_be_planned"
# Others, and the test that runs them.
RUN: Mapping[str, str] = {
    ".venv/bin/snakemake --profile workflow/profiles/slurm": (
        "tests/workflow/test_workflow_cluster.py::test_the_tiny_study_ends_with_its_report_and_has_a_campaign"
    ),
    "mkdir -p mine": TYPED,
    "printf 'scenes: {names: [bending]}\\n' > mine/scenes.yaml": TYPED,
    ".venv/bin/python -m pip install gecatsim==1.6.6": (
        "tests/unit/docs/test_docs_commands.py::test_packages_are_those_of_the_extras"
    ),
    ".venv/bin/python tools/check_config.py mine/mine.yaml": "tests/unit/tools/test_tools_check_config.py",
    ".venv/bin/python tools/draw_result.py results": (
        "tests/unit/tools/test_tools_draw_result.py::test_the_picture_of_a_study_is_drawn"
    ),
    ".venv/bin/python tools/draw_stages.py": "tests/unit/tools/test_tools_draw_stages.py",
    **{
        f".venv/bin/python examples/{name}.py": EXAMPLES
        for name in ("press_a_block", "unload_a_hemisphere", "dose_of_a_slab", "one_own_woman")
    },
}
# Of a page that says itself that nobody has tried them.
UNTESTED = {"workflow/container/README.md": "**Not tested**"}


def pages(home: Path) -> list[Path]:
    """Every page for people: READMEs, the pages of docs, and how to work on it."""
    found = [home / "README.md", home / "CONTRIBUTING.md", home / WHOLE_BLOCKS]
    return [*found, *sorted(home.glob("workflow/*/README.md")), *sorted(home.glob("docs/**/*.md"))]


def blocks(page: Path) -> list[str]:
    """What a page would have typed, block by block."""
    return [block for _, block in BLOCK.findall(page.read_text(encoding="utf-8"))]


def commands(page: Path) -> list[str]:
    """Line by line, without comments."""
    lines = "\n".join(blocks(page)).replace("\\\n", " ").splitlines()
    return [line for line in (re.sub(r"(^|\s)#.*", "", each).strip() for each in lines) if line]
