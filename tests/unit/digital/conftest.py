"""The two published volunteers, in the values of the study's configuration."""

from pathlib import Path

import pytest
import yaml

from mammosim.digital.anatomy import Anatomy, make_anatomy
from mammosim.digital.patient import VirtualPatient


@pytest.fixture(scope="session")
def women(repository: Path) -> dict:
    """Nested parameters of each volunteer."""
    return yaml.safe_load((repository / "config/default.yaml").read_text())["digital"]["women"]


@pytest.fixture(scope="session")
def patients(women: dict) -> dict[str, VirtualPatient]:
    """Each volunteer as a virtual patient."""
    return {name: VirtualPatient.read(values) for name, values in women.items()}


@pytest.fixture(scope="session")
def anatomies(patients: dict) -> dict[str, Anatomy]:
    """The anatomy of each volunteer."""
    return {name: make_anatomy(patient) for name, patient in patients.items()}


@pytest.fixture(scope="session", params=["small", "large"])
def anatomy(request: pytest.FixtureRequest, anatomies: dict[str, Anatomy]) -> Anatomy:
    """Each volunteer in turn."""
    return anatomies[request.param]
