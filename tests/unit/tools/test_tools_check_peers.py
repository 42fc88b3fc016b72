"""A program that is missing is named with the package that has it."""

import importlib.util
import shutil
import subprocess
from types import SimpleNamespace

import pytest


@pytest.fixture
def check_peers(repository):
    spec = importlib.util.spec_from_file_location("check_peers", repository / "tools/check_peers.py")
    check_peers = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(check_peers)
    return check_peers


def test_what_is_missing_is_named_with_its_package(check_peers, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    assert check_peers.missing() == [
        "CalculiX: apt-get install calculix-ccx",
        "dolfinx: apt-get install python3-dolfinx-real libopenblas0-pthread",
    ]


@pytest.mark.parametrize(("failed", "count"), [(0, 0), (1, 1)])
def test_dolfinx_is_there_where_debians_python_finds_it(check_peers, monkeypatch, failed, count):
    monkeypatch.setattr(shutil, "which", lambda name: name)
    monkeypatch.setattr(subprocess, "run", lambda command: SimpleNamespace(returncode=failed))
    found = check_peers.missing()
    assert [line.split(":")[0] for line in found] == ["dolfinx"] * count
