"""Every example runs, is short, and prints what is physically sound; every public name is there."""

import os
import re
import subprocess
import sys

import pytest

import mammosim as ms

LINES = 40
# Of each number that an example prints, in order, what it must lie between, and why.
SOUND = {
    # A cube of 30 mm at 1 kPa, a fifth of strain, and skin: newtons; it bulges less than it is pressed.
    "press_a_block": [(0.05, 2.0), (200, 900), (0.2, 6.0)],
    # 2 kPa over 50 mm: rho g h^2 / E = 12 mm would be a slab that hangs freely; the base holds a good part.
    "unload_a_hemisphere": [(1.0, 8.0), (0.0, 1e-3)],
    # At 20 keV the gland takes some 20 uGy/mAs of 1e5 photons/mm2, and less than the entrance.
    "dose_of_a_slab": [(5.0, 60.0), (0.0, 1.2), (0.1, 1.0)],
    "one_own_woman": [(0.05, 5.0), (50, 50), (0.2, 10.0), (1.0, 2000.0)],
}
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+\.?\d*(?:e[-+]?\d+)?(?![\w])")


@pytest.mark.parametrize("name", SOUND)
def test_an_example_runs_and_prints_what_is_sound(name, repository):
    path = repository / "examples" / f"{name}.py"
    assert len(path.read_text().splitlines()) <= LINES + 5
    environment = os.environ | {"PYTHONPATH": str(repository / "src")}
    ran = subprocess.run(
        [sys.executable, str(path)], capture_output=True, text=True, env=environment, check=False
    )
    assert ran.returncode == 0, ran.stderr
    found = [float(number) for number in NUMBER.findall(ran.stdout.replace("mm2", ""))]
    assert len(found) == len(SOUND[name])
    for number, (low, high) in zip(found, SOUND[name]):
        assert low <= number <= high, ran.stdout


def test_every_example_is_run(repository):
    assert {path.stem for path in (repository / "examples").glob("*.py")} == set(SOUND)


def test_the_library_needs_nothing_of_the_workflow(repository):
    """All that a public name imports comes without the packages of the extra `workflow`."""
    text = """
import sys
for name in ("snakemake", "jinja2", "jsonschema", "yaml"):
    sys.modules[name] = None
import mammosim as ms
from importlib import import_module
for name in ms.__all__:
    getattr(ms, name)
for stage in ms.STAGES.values():
    import_module(stage.module)
"""
    environment = os.environ | {"PYTHONPATH": str(repository / "src")}
    ran = subprocess.run(
        [sys.executable, "-c", text], capture_output=True, text=True, env=environment, check=False
    )
    assert ran.returncode == 0, ran.stderr


def test_every_public_name_is_there_and_documented():
    assert len(ms.__all__) >= 25
    for name in ms.__all__:
        assert getattr(ms, name) is not None
        if name not in ("__version__", "STAGES", "QUANTITIES"):
            assert getattr(ms, name).__doc__
    with pytest.raises(AttributeError, match="no attribute 'mesh_bodies'; it has"):
        ms.mesh_bodies  # noqa: B018
