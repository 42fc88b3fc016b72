"""A machine that cannot run the study is told what to install."""

import ctypes
import importlib.util
import runpy
import sys

import pytest


@pytest.fixture
def check_system(repository):
    spec = importlib.util.spec_from_file_location("check_system", repository / "tools/check_system.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_a_missing_library_is_named_with_its_package(check_system, monkeypatch):
    def load(name):
        if name == "libGLU.so.1":
            raise OSError(name)

    monkeypatch.setattr(ctypes, "CDLL", load)
    assert check_system.library_problem().endswith("apt-get install libglu1-mesa")


def test_an_old_python_is_rejected(check_system, monkeypatch):
    monkeypatch.setattr(sys, "version_info", (3, 10, 2))
    assert "Python 3.10.2 is too old: 3.11 or newer is needed" in check_system.python_problem()


def test_this_machine_is_fit(check_system):
    assert check_system.python_problem() is None
    assert check_system.library_problem() is None


def test_python_is_looked_at_before_the_environment_is_built_and_libraries_after(repository, monkeypatch):
    def refused(name):
        raise OSError(name)

    monkeypatch.setattr(ctypes, "CDLL", refused)
    monkeypatch.setattr(sys, "version_info", (3, 10, 2))
    for when, words in {"before": "Python 3.10.2 is too old", "after": "gmsh needs system libraries"}.items():
        monkeypatch.setattr(sys, "argv", ["check_system.py", when])
        with pytest.raises(SystemExit, match=f"cannot be installed yet. {words}"):
            runpy.run_path(str(repository / "tools/check_system.py"), run_name="__main__")
