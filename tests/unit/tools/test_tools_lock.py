"""What `environment.lock` installs on each processor: on arm64 nothing that is made for x86-64 alone."""

import re
import sys
import tomllib

import pytest
from packaging.requirements import Requirement

# Compiled for x86-64 alone, on Linux: MKL with what it is run by, and gmsh.
X86 = {"gmsh", "intel-cmplr-lib-ur", "intel-openmp", "mkl", "pypardiso", "tbb", "tcmlib", "umf"}
PIN = re.compile(r"^(?P<pin>[\w.-]+==[^\s\\]+(?: ; [^\\]+)?)", re.MULTILINE)


def machine(processor, python):
    """What markers ask of a Linux on this processor."""
    return {
        "platform_machine": processor,
        "sys_platform": "linux",
        "platform_system": "Linux",
        "os_name": "posix",
        "implementation_name": "cpython",
        "platform_python_implementation": "CPython",
        "python_version": python,
        "python_full_version": f"{python}.1",
    }


def holds(requirement, environment, extra=""):
    return requirement.marker is None or requirement.marker.evaluate(environment | {"extra": extra})


@pytest.fixture(params=["3.11", "3.12", "3.13"])
def python(request):
    return request.param


def pinned(repository, processor, python):
    """Name -> version of what the lock installs there."""
    text = (repository / "environment.lock").read_text()
    pins = [Requirement(found["pin"]) for found in PIN.finditer(text)]
    here = [pin for pin in pins if holds(pin, machine(processor, python))]
    versions = {pin.name: str(pin.specifier).removeprefix("==") for pin in here}
    assert len(versions) == len(here), "one version of each"
    return versions


def test_arm64_installs_all_but_what_is_made_for_x86(repository, python):
    arm, x86 = (pinned(repository, processor, python) for processor in ("aarch64", "x86_64"))
    assert set(x86) - set(arm) == X86
    assert "rslab" in arm, "which factorises in the place of MKL"
    assert arm.items() <= x86.items()


@pytest.mark.parametrize("processor", ["x86_64", "aarch64"])
def test_the_lock_has_what_the_package_asks_for(repository, processor, python):
    project = tomllib.loads((repository / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    asked = [Requirement(line) for line in project["dependencies"]]
    asked += [Requirement(line) for extra in ("workflow", "crate", "docs", "dev") for line in extras[extra]]
    versions = pinned(repository, processor, python)
    for requirement in asked:
        if holds(requirement, machine(processor, python)):
            assert requirement.specifier.contains(versions[requirement.name.lower()]), requirement


def test_this_python_is_one_that_the_package_names(repository):
    project = tomllib.loads((repository / "pyproject.toml").read_text())["project"]
    assert f"Programming Language :: Python :: 3.{sys.version_info[1]}" in project["classifiers"]
