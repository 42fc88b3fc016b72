"""What all tests share: where the repository is, and where real images are, if anywhere."""

from collections.abc import Generator
from pathlib import Path

import numba
import pytest

REPOSITORY = Path(__file__).parents[1]


@pytest.hookimpl(wrapper=True)  # around all others, one of which reads the groups
def pytest_collection_modifyitems(
    config: pytest.Config, items: list[pytest.Item]
) -> Generator[None, None, None]:
    """Of several processes one runs the whole workflow, which takes longest and begins; else one a file."""
    if hasattr(config, "workerinput"):
        for item in items:
            name = "workflow" if _of_workflow(item) else item.path.stem
            item.add_marker(pytest.mark.xdist_group(name))
        items.sort(key=_of_workflow, reverse=True)
    yield


def _of_workflow(item: pytest.Item) -> bool:
    return item.get_closest_marker("workflow") is not None


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
