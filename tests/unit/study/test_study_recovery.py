"""Fitted moduli beside the true ones: what counts as found, and what is not counted."""

import numpy as np
import pandas as pd
import pytest

from mammosim.core.errors import ConfigurationError
from mammosim.study.identification.scores import by_tissue, numbers, scored

TISSUES = ("adipose", "glandular", "skin", "fascia", "muscle")
TRUE_KPA = {"adipose": 1.0, "glandular": 2.0, "skin": 10.0, "fascia": 0.0, "muscle": 25.0}


def truth_of(volunteer):
    rows = [(volunteer, side, tissue, TRUE_KPA[tissue]) for side in ("left", "right") for tissue in TISSUES]
    return pd.DataFrame(rows, columns=["volunteer", "side", "tissue", "true_kpa"])


def fit_of(volunteer, factor=1.1, width=1.5):
    """Each modulus too high by a factor, in an interval of a width to either side; no fascia, no muscle."""
    truth = truth_of(volunteer)
    fitted = truth.true_kpa.where(truth.tissue != "fascia", 50.0) * factor
    known = ~truth.tissue.isin(["fascia", "muscle"])
    return truth.drop(columns="true_kpa").assign(
        fitted_kpa=fitted,
        low_kpa=(fitted / width).where(known),
        high_kpa=(fitted * width).where(known),
        identifiable=known,
        reason="",
    )


def score(volunteer, seed=1, **fit):
    return scored(fit_of(volunteer, **fit), truth_of(volunteer), seed=seed, seconds=60.0 * seed)


def test_the_truth_is_inside_where_the_interval_reaches_it():
    near, far = score("made_01", factor=1.1), score("made_01", factor=2.0)
    for table, inside in ((near, True), (far, False)):
        identified = table[table.identifiable]
        assert list(identified.tissue) == ["adipose", "glandular", "skin"] * 2
        assert all(found is inside for found in identified.inside_95)
    assert near[~near.identifiable].inside_95.isna().all()


def test_rows_keep_the_order_of_the_truth_whatever_that_of_the_fit():
    shuffled = fit_of("made_01").sample(frac=1, random_state=0)
    table = scored(shuffled, truth_of("made_01"), seed=3, seconds=1.0)
    pd.testing.assert_frame_equal(table[["side", "tissue"]], truth_of("made_01")[["side", "tissue"]])
    assert set(table.seed) == {3}


def test_a_fit_of_another_volunteer_is_rejected():
    with pytest.raises(ConfigurationError, match="made_02 left adipose"):
        scored(fit_of("made_01"), truth_of("made_02"), seed=1, seconds=1.0)


@pytest.fixture
def table():
    """Two volunteers found, one whose truth is outside everywhere."""
    return pd.concat(
        [score("made_01", 1), score("made_02", 2), score("made_03", 3, factor=2.0)], ignore_index=True
    )


def test_only_identifiable_moduli_are_counted(table):
    rows = by_tissue(table).set_index(["tissue", "side"])
    assert list(rows.index.get_level_values("tissue"))[::2] == list(TISSUES)
    skin = rows.loc["skin", "left"]
    assert (skin.volunteers, skin.identifiable, skin.inside) == (3, 3, 2)
    assert skin.inside_percent == pytest.approx(200 / 3)
    assert skin.width_factor == pytest.approx(1.5**2)
    assert skin.error_percent == pytest.approx(10.0)
    assert rows.loc["muscle", "right"].identifiable == 0
    assert np.isnan(rows.loc["muscle", "right"].inside_percent)


def test_a_volunteer_counts_when_all_her_identifiable_moduli_are_inside(table):
    found = numbers(table)
    assert found["recovery.volunteers"] == 3
    assert found["recovery.volunteers_all_inside"] == 2
    assert found["recovery.all.identifiable"] == 18
    assert found["recovery.all.inside"] == 12
    assert found["recovery.adipose.inside_percent"] == pytest.approx(200 / 3)
    assert found["recovery.muscle.inside_percent"] is None
    assert found["recovery.outside"].startswith("made_03 left adipose; ")
    assert (found["recovery.moduli_checked"], found["recovery.moduli_missed"]) == (6, 6)
    assert (found["recovery.seconds_median"], found["recovery.seconds_max"]) == (120.0, 180.0)
