"""The wheel has the whole package with its tables, and runs where nothing of the checkout is."""

import subprocess
import sys
import zipfile

import pytest

ASKED = """
import mammosim, pathlib
from mammosim.io.tabulated import tabulated
assert len(tabulated("label_codes")) > 0
print(pathlib.Path(mammosim.__file__).parents[1])
"""


def test_it_builds_has_every_file_and_runs_by_itself(repository, tmp_path):
    pytest.importorskip("hatchling", reason="hatchling is not installed")
    build = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", str(tmp_path)]
    subprocess.run(build, cwd=repository, check=True, capture_output=True)
    (wheel,) = tmp_path.glob("mammosim-*.whl")
    source = repository / "src"
    files = {str(path.relative_to(source)) for path in (source / "mammosim").rglob("*") if path.is_file()}
    with zipfile.ZipFile(wheel) as kept:
        assert {name for name in files if "__pycache__" not in name} <= set(kept.namelist())
        kept.extractall(tmp_path / "there")
    run = f"import sys; sys.path.insert(0, {str(tmp_path / 'there')!r})\n{ASKED}"
    ended = subprocess.run([sys.executable, "-I", "-c", run], text=True, capture_output=True, check=False)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.strip() == str(tmp_path / "there")
