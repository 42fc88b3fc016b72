"""What all tests share: where the repository is, and where real images are, if anywhere."""

from pathlib import Path

import numba
import pytest

REPOSITORY = Path(__file__).parents[1]


@pytest.fixture(scope="session")
def repository() -> Path:
    """The root of the repository."""
    return REPOSITORY


@pytest.fixture(scope="session", autouse=True)
def one_thread() -> None:
    """Bodies of tests are too small to share: on a busy machine threads wait longer than they work.

    Results are the same bits on any number of threads; the tests that show it ask for two.
    """
    numba.set_num_threads(1)
