"""What all tests share: where the repository is, and where real images are, if anywhere."""

import os
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from browser import browser, page  # noqa: F401  (fixtures)
from whole_study import finished, study  # noqa: F401  (fixtures)
from xdist.scheduler import LoadFileScheduling

REPOSITORY = Path(__file__).parents[1]
# Matrices of tests are too small to share; threads of MKL wait by spinning. Set before numpy is imported.
for library in ("OMP", "MKL", "OPENBLAS"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

RUN_ONCE = "finished"  # the fixture that runs the whole chain
WORKFLOW, ARTEFACTS = "tests/workflow/", "tests/artefacts/"


@cache
def needs_the_run(file: str) -> bool:
    """Whether a file of tests uses the one run of the whole chain."""
    return file.startswith(WORKFLOW) and RUN_ONCE in (REPOSITORY / file).read_text()


def turn(file: str) -> int:
    """Among several processes: first what begins the run of the whole chain, last what waits for it."""
    return 0 if file.startswith(ARTEFACTS) else 2 if needs_the_run(file) else 1


class FirstTheRun(LoadFileScheduling):
    """Each process takes file by file; all files that look at what the run made are one."""

    def _split_scope(self, nodeid: str) -> str:
        return RUN_ONCE if nodeid.startswith(ARTEFACTS) else super()._split_scope(nodeid)


def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> FirstTheRun:
    """Who runs which tests, with `--numprocesses`."""
    return FirstTheRun(config, log)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Among several processes, the run of the whole chain begins, since it takes longest."""
    if hasattr(config, "workerinput"):
        items.sort(key=lambda item: turn(item.nodeid.split("::")[0]))


@pytest.fixture(scope="session")
def repository() -> Path:
    """The root of the repository."""
    return REPOSITORY


@pytest.fixture(scope="session", autouse=True)
def one_thread() -> None:
    """Bodies of tests are too small to share: on a busy machine threads wait longer than they work.

    Results are the same bits on any number of threads; the tests that show it ask for two.
    """
    import numba

    numba.set_num_threads(1)
