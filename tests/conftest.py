"""What all tests share: where the repository is, and where real images are, if anywhere."""

from pathlib import Path
from typing import Any

import numba
import pytest
from whole_study import finished, study  # noqa: F401  (fixtures)
from xdist.scheduler import LoadFileScheduling

REPOSITORY = Path(__file__).parents[1]
WORKFLOW = ("tests/workflow/", "tests/artefacts/")  # what shares one run of the whole chain


class OneForTheWorkflow(LoadFileScheduling):
    """Of several processes one runs the whole workflow, which they share; else each takes file by file."""

    def _split_scope(self, nodeid: str) -> str:
        return WORKFLOW[0] if nodeid.startswith(WORKFLOW) else super()._split_scope(nodeid)


def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> OneForTheWorkflow:
    """Who runs which tests, with `--numprocesses`."""
    return OneForTheWorkflow(config, log)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Among several processes, the workflow begins, since it takes longest."""
    if hasattr(config, "workerinput"):
        items.sort(key=lambda item: item.nodeid.startswith(WORKFLOW), reverse=True)


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
