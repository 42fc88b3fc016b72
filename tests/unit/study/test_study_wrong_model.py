"""What a wrong model costs is the difference between two women who differ in nothing else."""

import json

import numpy as np
import pandas as pd
import pytest

from mammosim.study.identification.validation import costs, moduli_beside, wrong_model_numbers

REFERENCES = {"fibrous": "small"}


@pytest.fixture
def table():
    rows = [
        (v, p, p != "supine_tilted", quantity, value + worse * (v == "fibrous"))
        for p, worse in (("supine", 0.1), ("supine_tilted", 2.0))
        for v in ("fibrous", "small")
        for quantity, value in (
            ("nipple_left", 1.0),
            ("nipple_right", 1.4),
            ("marker_mean", 0.9),
            ("skin_mean", 0.5),
        )
    ]
    return pd.DataFrame(rows, columns=["volunteer", "position", "fitted", "quantity", "value_mm"])


@pytest.fixture
def moduli():
    rows = [
        (v, s, t, E)
        for v, E in (("small", 0.8), ("fibrous", 1.2))
        for s in ("left", "right")
        for t in ("adipose",)
    ]
    return pd.DataFrame(rows, columns=["volunteer", "side", "tissue", "fitted_kpa"])


def test_the_cost_is_what_the_wrong_model_adds(table):
    found = costs(table, REFERENCES)
    np.testing.assert_allclose(found.cost_mm[found.position == "supine_tilted"], 2.0)
    np.testing.assert_allclose(found.cost_mm[found.position == "supine"], 0.1)
    assert set(found.reference) == {"small"}


def test_the_page_quotes_the_worst_nipple_of_the_position_held_out(table, moduli):
    found = wrong_model_numbers(costs(table, REFERENCES), moduli_beside(moduli, REFERENCES))
    assert found["wrong_model.nipple_right_mm"] == pytest.approx(1.4)
    assert found["wrong_model.nipple_wrong_mm"] == pytest.approx(3.4)
    assert found["wrong_model.nipple_cost_fitted_mm"] == pytest.approx(0.1)
    assert found["wrong_model.adipose_times"] == pytest.approx(1.5)
    json.dumps(found)


def test_a_prediction_that_failed_has_no_cost(table, moduli):
    table.loc[table.volunteer == "fibrous", "value_mm"] = np.nan
    found = wrong_model_numbers(costs(table, REFERENCES), moduli_beside(moduli, REFERENCES))
    assert found["wrong_model.nipple_cost_mm"] is None
