import json

import numpy as np
import pandas as pd
import pytest

from mammosim import __version__
from mammosim.study.report.summary import assumptions, digest, numbers, provenance


def test_numbers_are_named_by_table_row_and_column():
    table = pd.DataFrame({"volunteer": ["small", "large"], "kpa": [0.5, 20.0], "error_mm": [1.25, np.nan]})
    found = numbers({"sweep": table}, {"sweep": ("volunteer", "kpa")})
    assert found == {"sweep.small.0.5.error_mm": 1.25, "sweep.large.20.error_mm": None}
    assert json.loads(json.dumps(found)) == found


def test_rows_that_share_a_name_are_rejected():
    table = pd.DataFrame({"volunteer": ["small", "small"], "error_mm": [1.0, 2.0]})
    with pytest.raises(ValueError, match="not told apart by volunteer"):
        numbers({"sweep": table}, {"sweep": ("volunteer",)})


def test_assumptions_are_read_with_the_lines_that_go_on():
    text = (
        "x = 1\n    # ASSUME: skin weighs nothing,\n    # and does not bend.\ny = 2\n# ASSUME: no friction.\n"
    )
    found = assumptions({"b.py": text, "a.py": "# just a comment\n"})
    assert found.assumption.tolist() == ["skin weighs nothing, and does not bend.", "no friction."]
    assert set(found.file) == {"b.py"}


def test_the_digest_of_a_configuration_depends_on_its_values_not_their_order():
    assert digest({"a": 1, "b": {"c": 2, "d": 3}}) == digest({"b": {"d": 3, "c": 2}, "a": 1})
    assert digest({"a": 1}) != digest({"a": 2})


def test_provenance_names_versions_and_can_be_written():
    found = provenance({"seed": 1}, lock="numpy==2", assumed=assumptions({}))
    assert found["packages"]["numpy"] == np.__version__
    assert found["packages"]["mammosim"] == __version__
    json.dumps(found)
