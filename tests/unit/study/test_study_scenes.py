"""A scene rejects what cannot be asked, says what its question needs, and is answered beside a full model."""

from dataclasses import asdict

import pandas as pd
import pytest

from mammosim.chain.stages import STAGES, effects_on
from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import read
from mammosim.study.scenes.answers import Answered, numbers, outside, rows
from mammosim.study.scenes.scene import EFFECTS, EQUIPMENT, EXPENSIVE, Scene, products_of

UPRIGHT, PRESSED = {"position": "upright"}, {"strategy": "standard"}


BREAST = {"volunteer": "small", "side": "left", "tissues": "layered"}


def scene(load, asked, effects="auto", **more):
    return Scene.of("mine", {**BREAST, "load": load, "asked": asked, "effects": effects, **more})


@pytest.mark.parametrize(
    ("load", "asked", "effects", "words"),
    [
        (UPRIGHT, {"niple_mm": 1}, "auto", "no quantity 'niple_mm'; choose among: agd_percent, cnr_percent"),
        (UPRIGHT, {"nipple_mm": 1}, ["skn"], "no effect 'skn'; choose among: blur"),
        (UPRIGHT, {"agd_percent": 1}, "auto", "agd_percent needs a strategy in its load, such as standard"),
        (PRESSED, {"nipple_mm": 1}, "auto", "nipple_mm needs a position in its load, such as upright"),
        (PRESSED, {"cnr_percent": 1}, ["scatter"], "means nothing without quantum_noise; add it to effects"),
        (PRESSED, {"cnr_percent": 1}, [], "means nothing without quantum_noise"),
        (UPRIGHT, {"nipple_mm": 0}, "auto", "asked.nipple_mm = 0 is outside"),
        (UPRIGHT, {"nipple_mm": float("inf")}, "auto", "asked.nipple_mm = inf is not a finite number"),
        (UPRIGHT, {"nipple_mm": "1"}, "auto", "asked.nipple_mm = '1'"),
        (UPRIGHT, {"nipple_mm": 1}, "atuo", "effects = 'atuo'"),
        (
            {"postion": "upright"},
            {"nipple_mm": 1},
            "auto",
            "load has no key 'postion'",
        ),
    ],
)
def test_a_question_that_cannot_be_answered_is_rejected_with_what_to_write(load, asked, effects, words):
    with pytest.raises(ConfigurationError, match=f"scene mine.*{words}"):
        scene(load, asked, effects)


def test_keys_that_a_scene_lacks_or_does_not_have_are_named():
    with pytest.raises(ConfigurationError, match="scene mine lacks effects; add it"):
        Scene.of("mine", {**BREAST, "load": UPRIGHT, "asked": {"nipple_mm": 1}})
    with pytest.raises(ConfigurationError, match="scene mine has no key 'efects'; did you mean 'effects'"):
        scene(UPRIGHT, {"nipple_mm": 1}, efects=[])
    with pytest.raises(ConfigurationError, match="side = 'middle': choose one of: left, right"):
        scene(UPRIGHT, {"nipple_mm": 1}, side="middle")


def test_a_scene_wants_a_preset_or_errors_and_is_the_same_behind_the_plain_values_of_a_job():
    assert scene(UPRIGHT, {"nipple_mm": 1}, accuracy="draft").wanted == "draft"
    mine = scene(UPRIGHT, {"nipple_mm": 1}, accuracy={"nipple_mm": 2})
    assert mine.wanted == {"nipple_mm": 2.0}
    assert read(Scene, asdict(mine), "scene mine") == mine


def test_beside_what_is_always_considered_there_are_a_grid_and_friction():
    with pytest.raises(ConfigurationError, match="no effect of `also` 'lens'; choose among: friction, grid"):
        scene(PRESSED, {"cnr_percent": 1}, also=["lens"])
    assert "friction" not in scene(PRESSED, {"force_n": 1}).full
    with_friction = scene(PRESSED, {"force_n": 1}, also=["friction"])
    assert "friction" in with_friction.full - with_friction.needed


def test_a_scene_has_only_effects_that_act_on_what_it_asks():
    assert scene(UPRIGHT, {"nipple_mm": 1}).full == {"gland", "muscle", "skin", "fascia", "ligaments"}
    dose = scene(PRESSED, {"agd_percent": 1}).full
    assert {"weight", "polychromatic", "paddle"} <= dose
    assert not {"scatter", "blur", "quantum_noise"} & dose


def test_a_grid_is_there_only_where_the_machine_has_one():
    assert "grid" not in scene(PRESSED, {"cnr_percent": 1}).full
    with_grid = scene(PRESSED, {"cnr_percent": 1}, also=["grid"])
    assert "grid" in with_grid.full & with_grid.needed


def test_every_effect_of_a_product_has_words_and_every_word_an_effect():
    assert effects_on(STAGES) == set(EFFECTS)
    assert set(EFFECTS) >= EQUIPMENT | EXPENSIVE


def test_a_question_without_dose_needs_no_dose():
    assert "dose" not in products_of({"mas_percent": 1, "cnr_percent": 1})
    assert not set(products_of({"nipple_mm": 1})) & {"press_setup", "pressed", "spectrum"}


def test_the_screened_effects_are_those_listed_or_those_found():
    listed = scene(UPRIGHT, {"nipple_mm": 1}, ["skin", "scatter"])
    assert listed.modelled("screened", None) == {"skin"}
    assert listed.modelled("full", None) == listed.full
    rows = [("mine", "skin", "True"), ("mine", "gland", "False"), ("other", "muscle", "True")]
    found = [dict(zip(("scene", "effect", "included"), row)) for row in rows]
    assert scene(UPRIGHT, {"nipple_mm": 1}).modelled("screened", found) == {"skin"}
    with pytest.raises(ConfigurationError, match="was not screened"):
        scene(UPRIGHT, {"nipple_mm": 1}).modelled("screened", None)


SCREENED = Answered({"nipple_mm": [3.0, 4.0, 0.0], "agd_percent": [2.2]}, ["skin"], 5.0)
FULL = Answered({"nipple_mm": [3.0, 0.0, 0.0], "agd_percent": [2.0]}, ["skin", "gland"], 20.0)

ERRORS = {"nipple_mm": 6.0, "agd_percent": float("nan")}


@pytest.fixture
def table():
    mine = scene(UPRIGHT | PRESSED, {"nipple_mm": 5.0, "agd_percent": 3.0})
    return pd.DataFrame(rows(mine, SCREENED, FULL, numerical=ERRORS, screening_s=7.0))


def test_places_differ_by_their_distance_and_doses_in_percent(table):
    assert table.difference.tolist() == pytest.approx([4.0, 10.0])
    assert table.within.tolist() == [True, False]
    assert table.screened[0] == 5.0, "a place is given as its length"
    assert (table.fraction == 0.25).all()


def test_an_answer_outside_of_its_tolerance_is_named_with_what_helps(table):
    (line,) = outside(table)
    assert line.startswith("NOT WITHIN ITS TOLERANCE: mine: agd_percent differs")
    assert "the tolerance is 3; lower scenes.part" in line


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


def test_an_answer_that_cannot_be_is_rejected_by_the_file_that_holds_it():
    given = {"values": {"nipple_mm": [1.0, "x", 0.0]}, "effects": [], "seconds": 1.0}
    with pytest.raises(ConfigurationError, match=r"mine.json.values.nipple_mm\[1\] = 'x'"):
        read(Answered, given, "mine.json")
    with pytest.raises(ConfigurationError, match="seconds = -1 is outside"):
        Answered({}, (), -1.0)
