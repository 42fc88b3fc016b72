"""Problems for several programs: plain numpy arrays and facts in one file (.npz)."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from mammosim.io.atomic import replacing


def write_problem(arrays: Mapping[str, np.ndarray], facts: Mapping[str, Any], path: str | Path) -> None:
    """Write the arrays by name, and beside them `facts`: nested plain values as JSON."""
    with replacing(path) as temporary, open(temporary, "wb") as file:
        np.savez(file, allow_pickle=False, facts=np.array(json.dumps(facts)), **arrays)
