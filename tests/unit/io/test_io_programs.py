"""A program in a process of its own: what it wrote, or what became of it."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from mammosim.io.programs import found_by, write_problem

ADAPTER = """
import json, os, sys
import numpy as np
case, found, *words = sys.argv[1:]
facts = json.load(open(case))
{then}
"""
ANSWERS = """
threads = os.environ["OMP_NUM_THREADS"]
np.savez(found, twice=2 * facts["x"], list=np.arange(3), outcome=words[0], threads=threads)
"""


def adapter(folder: Path, then: str) -> list[str]:
    file = folder / "adapter.py"
    file.write_text(ADAPTER.format(then=then))
    return [sys.executable, str(file)]


def test_numbers_and_words_come_back_as_such(tmp_path):
    found = found_by(adapter(tmp_path, ANSWERS), {"x": 2.5}, cpu_limit_s=20, arguments=["converged"])
    assert (found["twice"], found["outcome"], found["threads"]) == (5.0, "converged", "1")
    assert found["list"].tolist() == [0, 1, 2]


def test_a_program_without_end_is_stopped(tmp_path):
    found = found_by(adapter(tmp_path, "while True: pass"), {}, cpu_limit_s=1)
    assert found == {"outcome": "stopped after 1 s of processor time"}


def test_a_crash_is_an_outcome_and_an_error_is_raised(tmp_path):
    found = found_by(adapter(tmp_path, "os.abort()"), {}, cpu_limit_s=20)
    assert found["outcome"] == "crashed: signal 6"
    with pytest.raises(subprocess.CalledProcessError):
        found_by(adapter(tmp_path, "sys.exit(3)"), {}, cpu_limit_s=20)


def test_a_problem_reads_back_without_this_package(tmp_path):
    write_problem({"index": np.ones((2, 2), np.uint8)}, {"mm": [0.5, 1.0]}, tmp_path / "task.npz")
    with np.load(tmp_path / "task.npz") as arrays:
        assert arrays["index"].sum() == 4
        assert str(arrays["facts"]) == '{"mm": [0.5, 1.0]}'
