"""The package is found wherever the checkout lies, in any locale."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

TOOL = Path(__file__).parents[3] / "tools/link_package.py"


def test_a_path_with_blanks_and_umlauts_is_found_in_any_locale(tmp_path):
    spec = importlib.util.spec_from_file_location("link_package", TOOL)
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    source, packages = tmp_path / "eine Prüfung/src", tmp_path / "site-packages"
    source.mkdir(parents=True)
    packages.mkdir()
    (source / "probe.py").write_text("found = True\n")
    (packages / "mammosim.pth").write_text(tool.line(source), encoding="ascii")
    command = f"import site; site.addsitedir({str(packages)!r}); import probe; assert probe.found"
    for locale in ("C", "C.UTF-8"):
        subprocess.run([sys.executable, "-c", command], env=os.environ | {"LC_ALL": locale}, check=True)
