"""A machine that cannot run the study gets what is missing, or is told the one line to type."""

import ast
import ctypes
import importlib.util
import os
import platform
import shutil
import subprocess
import sys

import pytest


@pytest.fixture
def check_system(repository):
    spec = importlib.util.spec_from_file_location("check_system", repository / "tools/check_system.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def without_a_library(check_system, monkeypatch):
    """GLU is missing; `programs` says what installs packages, `user` who asks."""

    def load(name):
        if name == "libGLU.so.1":
            raise OSError(name)

    def here(programs, user):
        monkeypatch.setattr(ctypes, "CDLL", load)
        monkeypatch.setattr(shutil, "which", lambda name: f"/usr/bin/{name}" if name in programs else None)
        monkeypatch.setattr(os, "geteuid", lambda: user)

    return here


@pytest.mark.parametrize(
    ("program", "line"),
    [
        ("apt-get", "sudo apt-get install libglu1-mesa"),
        ("dnf", "sudo dnf install 'libGLU.so.1()(64bit)'"),
        ("zypper", "sudo zypper install 'libGLU.so.1()(64bit)'"),
        ("pacman", "sudo pacman -S glu"),
        ("brew", "install them with what installs packages here"),
    ],
)
def test_an_ordinary_user_is_told_the_line_to_type(check_system, without_a_library, program, line):
    without_a_library({program}, user=1000)
    assert check_system.system_problem() == f"The system lacks libGLU.so.1: {line}"


def test_root_elsewhere_is_told_the_line_without_sudo(check_system, without_a_library):
    without_a_library({"dnf"}, user=0)
    assert check_system.system_problem().endswith(": dnf install 'libGLU.so.1()(64bit)'")


def run(repository, tmp_path, *, apt_get, user=0, when="before"):
    """What the tool does where one library is missing and apt-get is a script, which logs its arguments."""
    programs = tmp_path / "bin"
    programs.mkdir()
    log = tmp_path / "log"
    (programs / "apt-get").write_text(f'#!/bin/sh\necho "$DEBIAN_FRONTEND $*" >> "{log}"\n{apt_get}\n')
    (programs / "apt-get").chmod(0o755)
    start = f"""
import ctypes, os, pathlib, runpy, sys
real = ctypes.CDLL
def load(name, *more):
    if name == "libGLU.so.1" and not pathlib.Path({str(tmp_path / "installed")!r}).exists():
        raise OSError(name)
ctypes.CDLL = load
os.geteuid = lambda: {user}
sys.argv = ["check_system.py", {when!r}]
runpy.run_path({str(repository / "tools/check_system.py")!r}, run_name="__main__")
"""
    ended = subprocess.run(
        [sys.executable, "-c", start],
        env={"PATH": str(programs)},
        capture_output=True,
        text=True,
        check=False,
    )
    return ended, log.read_text().splitlines() if log.exists() else []


def test_root_on_debian_gets_what_is_missing(repository, tmp_path):
    apt_get = f'for last; do :; done; [ "$last" != libglu1-mesa ] || : > "{tmp_path / "installed"}"'
    ended, log = run(repository, tmp_path, apt_get=apt_get)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ended.stdout == "installing with apt-get: libglu1-mesa\n"
    update, install = log
    assert update == "noninteractive --quiet --quiet update"
    assert install.startswith("noninteractive ")
    assert install.endswith("--yes --no-install-recommends install libglu1-mesa")


def test_root_whose_packages_cannot_be_had_is_told_the_line(repository, tmp_path):
    ended, log = run(repository, tmp_path, apt_get="exit 100")
    assert len(log) == 2
    assert ended.returncode == 1
    assert ended.stderr == (
        "mammosim cannot be installed yet. The system lacks libGLU.so.1: apt-get install libglu1-mesa\n"
    )


def test_an_ordinary_user_installs_nothing(repository, tmp_path):
    ended, log = run(repository, tmp_path, apt_get="exit 1", user=1000)
    assert log == []
    assert ended.stderr.endswith("The system lacks libGLU.so.1: sudo apt-get install libglu1-mesa\n")


def test_a_python_without_venv_is_mended_like_a_library(check_system, without_a_library, monkeypatch):
    without_a_library({"apt-get"}, user=1000)
    monkeypatch.setattr(ctypes, "CDLL", lambda name: None)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    package = f"python3.{sys.version_info[1]}-venv"
    assert check_system.system_problem().endswith(f"lacks ensurepip: sudo apt-get install {package}")


def test_gmsh_is_the_system_s_where_it_has_no_wheel(check_system, monkeypatch, tmp_path):
    monkeypatch.setattr(platform, "machine", lambda: "aarch64")
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(sys, "base_prefix", str(tmp_path))
    monkeypatch.setattr(check_system, "DEBIAN_MODULES", tmp_path)
    assert check_system.missing() == ["gmsh"]
    module = tmp_path / "gmsh.py"
    for version, told in {"4.8.0": f"gmsh 4.8 ({module}) is too old", "4.13.1": ""}.items():
        module.write_text(f'GMSH_API_VERSION = "{version}"\n')
        assert check_system.missing() == []
        assert (check_system.system_problem() or "").startswith(told)
        assert bool(check_system.system_problem()) == bool(told)
    monkeypatch.setattr(platform, "machine", lambda: "x86_64")
    assert not check_system.needs_gmsh()


def test_an_old_python_is_rejected(check_system, monkeypatch):
    monkeypatch.setattr(sys, "version_info", (3, 10, 2))
    assert "Python 3.10.2 is too old: 3.11 or newer is needed" in check_system.python_problem()


def test_this_machine_is_fit(check_system):
    assert check_system.python_problem() is None
    assert check_system.missing() == []
    assert check_system.gmsh_problem() is None


def test_a_python_that_is_too_old_can_read_the_tool(repository):
    source = (repository / "tools/check_system.py").read_text()
    ast.parse(source, feature_version=(3, 8))
    assert "from __future__ import annotations" in source, "str | None is evaluated otherwise"
