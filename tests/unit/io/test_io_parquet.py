"""A table as Parquet has the same columns and values, each of its kind, and null where one is missing."""

import numpy as np
import pandas as pd
import pytest

from mammosim.io.parquet import write_parquet


def test_columns_keep_their_kinds_and_missing_values_are_null(tmp_path):
    arro3 = pytest.importorskip("arro3.io")
    table = pd.DataFrame(
        {
            "tissues.skin.youngs_modulus_kpa": [1.5, np.nan],
            "steps": [4, 8],
            "within": [True, False],
            "paddle": ["flexible", None],
            "mixed": [1, "rigid"],
            "either": [1, 2.5],
            "nothing": [None, None],
            "huge": [1, 10**23],  # more than 64 bits
        }
    )
    write_parquet(table, tmp_path / "table.parquet")
    read = arro3.read_parquet(tmp_path / "table.parquet").read_all()
    found = {name: read[name].to_pylist() for name in read.column_names}
    assert found == {
        "tissues.skin.youngs_modulus_kpa": [1.5, None],
        "steps": [4, 8],
        "within": [True, False],
        "paddle": ["flexible", None],
        "mixed": ["1", "rigid"],
        "either": [1.0, 2.5],
        "nothing": [None, None],
        "huge": [1.0, 1e23],
    }
    assert [path.name for path in tmp_path.iterdir()] == ["table.parquet"]
