"""The products of the small run, as a reader of the study finds them."""

from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest


@pytest.fixture(scope="session")
def results(finished) -> Path:
    """The folder of all results of the small run."""
    return finished.run / "results"


@pytest.fixture(scope="session")
def table(results) -> Callable[[str], pd.DataFrame]:
    """table(name): a table of the study; what is missing in it is NaN."""
    return lambda name: pd.read_csv(results / "study" / f"{name}.csv")
