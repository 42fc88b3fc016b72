"""How a computation ended: an outcome for what was computed, and none for a file that cannot be read."""

import pytest

from mammosim.chain.outcome import unsolved
from mammosim.core.errors import DamagedFile, MechanicsError


def test_a_failure_is_an_outcome_with_its_reason_and_what_was_done():
    assert unsolved(MechanicsError("no equilibrium"), "prone") == "failed: prone: no equilibrium"


def test_a_damaged_file_is_no_outcome():
    with pytest.raises(DamagedFile, match="ends early"):
        unsolved(DamagedFile("prone.vtu ends early"))
