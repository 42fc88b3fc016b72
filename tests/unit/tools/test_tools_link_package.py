"""The package is found wherever the checkout lies, in any locale."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

TOOL = Path(__file__).parents[3] / "tools/link_package.py"


def tool():
    spec = importlib.util.spec_from_file_location("link_package", TOOL)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_one_module_of_the_system_is_linked_and_nothing_beside_it(tmp_path):
    system, packages = tmp_path / "dist-packages", tmp_path / "site-packages"
    for folder in (system, packages):
        folder.mkdir()
    for name in ("gmsh", "numpy"):
        (system / f"{name}.py").write_text("")
    for _ in range(2):
        tool().link(system / "gmsh.py", packages)
    assert [path.name for path in packages.iterdir()] == ["gmsh.py"]
    assert (packages / "gmsh.py").resolve() == system / "gmsh.py", "gmsh looks for its library beside itself"


def test_a_path_with_blanks_and_umlauts_is_found_in_any_locale(tmp_path):
    source, packages = tmp_path / "eine Prüfung/src", tmp_path / "site-packages"
    source.mkdir(parents=True)
    packages.mkdir()
    (source / "probe.py").write_text("found = True\n")
    (packages / "mammosim.pth").write_text(tool().line(source), encoding="ascii")
    command = f"import site; site.addsitedir({str(packages)!r}); import probe; assert probe.found"
    for locale in ("C", "C.UTF-8"):
        subprocess.run([sys.executable, "-c", command], env=os.environ | {"LC_ALL": locale}, check=True)
