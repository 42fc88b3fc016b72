"""A job starts light: what its work does not need is not waited for; and it keeps to its threads."""

import os
import subprocess
import sys
from types import SimpleNamespace

import pytest


def imported_by(repository, code: str) -> set[str]:
    """The modules that are there after some lines of a script have run, in a process of its own."""
    lines = f"import sys; sys.path.append('workflow/scripts')\n{code}\nprint(*sys.modules)"
    where = os.environ | {"PYTHONPATH": str(repository / "src")}
    ran = subprocess.run(
        [sys.executable, "-c", lines], cwd=repository, env=where, text=True, capture_output=True, check=True
    )
    return set(ran.stdout.split())


def test_what_every_job_imports_has_no_compiler_in_it(repository):
    assert imported_by(repository, "import _stage").isdisjoint({"numba", "scipy", "matplotlib", "SimpleITK"})


def test_stages_of_images_read_no_dicom_and_know_no_distributions(repository):
    """pydicom is imported where a file is read; scipy.stats takes as long as all the rest."""
    found = imported_by(repository, "import mammosim.chain.images")
    assert found.isdisjoint({"pydicom", "scipy.stats", "numba", "sklearn"})


def test_a_figure_of_moduli_needs_no_mechanics(repository):
    found = imported_by(repository, "import mammosim.figures.identification")
    assert found.isdisjoint({"numba", "pypardiso", "meshio", "skfem"})


@pytest.mark.parametrize(("given", "threads", "kept"), [("4", 2, "2"), ("1", 8, "1"), (None, 3, "3")])
def test_kernels_that_come_later_keep_to_the_threads_of_the_rule(script, monkeypatch, given, threads, kept):
    monkeypatch.delitem(sys.modules, "numba", raising=False)
    monkeypatch.setenv("NUMBA_NUM_THREADS", given or "")
    script("_log").keep_to(threads)
    assert os.environ["NUMBA_NUM_THREADS"] == kept


@pytest.mark.parametrize(("threads", "kept"), [(2, 2), (8, 4)])
def test_kernels_that_are_there_keep_to_them_too(script, monkeypatch, threads, kept):
    set_to = []
    there = SimpleNamespace(config=SimpleNamespace(NUMBA_NUM_THREADS=4), set_num_threads=set_to.append)
    monkeypatch.setitem(sys.modules, "numba", there)
    script("_log").keep_to(threads)
    assert set_to == [kept]
