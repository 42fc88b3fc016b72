"""A block without gravity, and as it hangs, for the tests of what finds the one from the other."""

import pytest
from mechanics_bodies import HANGING, LIGHT, box

from mammosim.core.mesh import TetMesh


@pytest.fixture(scope="session")
def truth() -> TetMesh:
    """The stress-free block."""
    return box((2, 2, 2), (50.0, 50.0, 50.0))


@pytest.fixture(scope="session")
def measured(truth: TetMesh) -> TetMesh:
    """The block hanging under its weight."""
    return truth.moved_to(LIGHT.load(truth, HANGING).points)
