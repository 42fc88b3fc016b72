"""A program that is missing is named with the package that has it."""

import importlib.util
import shutil


def test_what_is_missing_is_named_with_its_package(repository, monkeypatch):
    spec = importlib.util.spec_from_file_location("check_peers", repository / "tools/check_peers.py")
    check_peers = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(check_peers)
    monkeypatch.setattr(shutil, "which", lambda name: None)
    assert check_peers.missing() == [
        "CalculiX: apt-get install calculix-ccx",
        "dolfinx: apt-get install python3-dolfinx-real libopenblas0-pthread",
    ]
