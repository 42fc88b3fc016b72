"""A table behind a slider: its lines are the rows, in the order of what the slider moves along."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from mammosim.core.errors import ConfigurationError
from mammosim.study.report.explorer import Exploration, explorer
from mammosim.study.report.pages import heading

SHOWN = Exploration("Dose.", "thickness_mm", ("dose_mgy", "cnr"), ("volunteer", "side"))
ROWS = pd.DataFrame(
    {"volunteer": ["a", "a", "<b>", "a"], "side": "left", "thickness_mm": [60.0, 40.0, 50.0, None]}
    | {"dose_mgy": [4.0, None, 3.0, 9.0]}
)


def test_lines_are_rows_in_their_order_and_a_missing_number_is_none():
    text = explorer(ROWS, SHOWN).json(heading)
    assert "<b>" not in text
    data = json.loads(text)
    assert (data["x"], data["y"]) == ("thickness (mm)", {"dose_mgy": "dose (mGy)"})
    assert data["lines"] == [
        {"name": "a left", "x": [40.0, 60.0], "y": {"dose_mgy": [None, 4.0]}},
        {"name": "<b> left", "x": [50.0], "y": {"dose_mgy": [3.0]}},
    ]


def test_what_is_no_finite_number_is_no_point():
    """A browser reads no Infinity in JSON, and a logarithmic axis has no place for 0."""
    rows = pd.DataFrame(
        {"volunteer": "a", "side": "left", "thickness_mm": [0.0, 40.0, np.inf, 50.0, "thick", -1.0]}
        | {"dose_mgy": [1.0, np.inf, 2.0, 3.0, 4.0, 5.0], "cnr": ["x", "6", None, -np.inf, 1.0, 2.0]}
    )
    (line,) = json.loads(explorer(rows, replace(SHOWN, logarithmic=True)).json(heading))["lines"]
    assert line["x"] == [40.0, 50.0]
    assert line["y"] == {"dose_mgy": [None, 3.0], "cnr": [6.0, None]}
    assert explorer(rows[1:5], SHOWN) is not None
    assert explorer(rows[1:3], SHOWN) is None


def test_nothing_is_explored_without_two_rows_of_a_line_or_its_columns():
    assert explorer(ROWS[1:3], SHOWN) is None
    assert explorer(ROWS.drop(columns="thickness_mm"), SHOWN) is None
    assert explorer(ROWS.drop(columns="dose_mgy"), SHOWN) is None


def test_an_exploration_without_a_quantity_is_rejected():
    with pytest.raises(ConfigurationError, match="y and by name at least one column each"):
        Exploration("Dose.", "thickness_mm", (), ("side",))
