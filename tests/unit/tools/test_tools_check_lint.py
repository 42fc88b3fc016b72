"""The workflow's lint fails on every advice but the one that the study does not follow."""

import subprocess
import sys

import pytest

ACCEPTED = """Lints for rule mesh (line 3, /study/workflow/rules/mesh.smk):
    * Specify a conda environment or container for each rule.:
      This way, the used software for each specific step is documented.
"""
OTHER = """Lints for rule dose (line 9, /study/workflow/rules/xray.smk):
    * Specify a conda environment or container for each rule.:
      This way, the used software for each specific step is documented.
    * No log directive defined:
      Without a log directive, all output will be printed to the terminal.
"""


@pytest.mark.parametrize(
    ("said", "failed", "words"),
    [
        (ACCEPTED, False, "nothing to improve"),
        ("Congratulations, your workflow is in a good condition!\n", False, "nothing to improve"),
        (f"{ACCEPTED}\n{OTHER}\n{ACCEPTED}", True, "No log directive defined"),
        ("SyntaxError in line 3\n", True, "SyntaxError in line 3"),
        ("", True, ""),
    ],
)
def test_only_the_accepted_advice_is_let_through(repository, said, failed, words):
    command = [sys.executable, str(repository / "tools/check_lint.py")]
    told = subprocess.run(command, input=said, capture_output=True, text=True, check=False)
    assert bool(told.returncode) == failed
    assert words in told.stdout
    assert "rule mesh" not in told.stdout
