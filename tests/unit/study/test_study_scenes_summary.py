"""Screened answers beside full ones: how far apart in the unit asked, and a loud word where it is too far."""

import pandas as pd
import pytest

from mammosim.study.scenes.summary import numbers, outside, rows

SCREENED = {"values": {"nipple_mm": [3.0, 4.0, 0.0], "agd_percent": 2.2}, "effects": ["skin"], "seconds": 5.0}
FULL = {
    "values": {"nipple_mm": [3.0, 0.0, 0.0], "agd_percent": 2.0},
    "effects": ["skin", "gland"],
    "seconds": 20.0,
}

ERRORS = {"nipple_mm": 6.0, "agd_percent": float("nan")}


@pytest.fixture
def table():
    return pd.DataFrame(
        rows(
            "mine", {"nipple_mm": 5.0, "agd_percent": 3.0}, SCREENED, FULL, numerical=ERRORS, screening_s=7.0
        )
    )


def test_places_differ_by_their_distance_and_doses_in_percent(table):
    assert table.difference.tolist() == pytest.approx([4.0, 10.0])
    assert table.within.tolist() == [True, False]
    assert table.screened[0] == 5.0, "a place is told by its length"
    assert (table.fraction == 0.25).all()


def test_an_answer_outside_of_its_tolerance_is_named_with_what_helps(table):
    (line,) = outside(table)
    assert line.startswith("NOT WITHIN ITS TOLERANCE: mine: agd_percent differs")
    assert "asked are 3; lower scenes.part" in line


def test_a_scene_counts_as_within_when_all_its_answers_are(table):
    decisions = pd.DataFrame({"scene": ["mine"] * 2, "effect": ["skin", "gland"], "included": [True, False]})
    found = numbers(table, decisions)
    assert (found["scenes.total"], found["scenes.within"], found["scenes.outside"]) == (
        1,
        0,
        "mine agd_percent",
    )
    assert (found["scenes.effects"], found["scenes.effects_included"]) == (2, 1)
    assert found["scenes.seconds_screening"] == 7.0
    assert found["scenes.coarse"] == "mine nipple_mm", "its mesh leaves more than the tolerance"
