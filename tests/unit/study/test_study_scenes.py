"""A scene refuses what cannot be asked, and says which products and effects its question has."""

import pytest

from mammosim.chain.stages import STAGES, effects_on
from mammosim.core.errors import ConfigurationError
from mammosim.study.scenes.scene import DEAR, EFFECTS, EQUIPMENT, Scene, products_of

UPRIGHT, PRESSED = {"position": "upright"}, {"strategy": "standard"}


def scene(load, asked, effects="auto", **more):
    return Scene.of("mine", {"load": load, "asked": asked, "effects": effects, **more})


@pytest.mark.parametrize(
    ("load", "asked", "effects", "words"),
    [
        (UPRIGHT, {"niple_mm": 1}, "auto", "no quantity 'niple_mm'; choose among: agd_percent, cnr_percent"),
        (UPRIGHT, {"nipple_mm": 1}, ["skn"], "no effect 'skn'; choose among: blur"),
        (UPRIGHT, {"agd_percent": 1}, "auto", "agd_percent needs a strategy in its load, such as standard"),
        (PRESSED, {"nipple_mm": 1}, "auto", "nipple_mm needs a position in its load, such as upright"),
        (PRESSED, {"cnr_percent": 1}, ["scatter"], "means nothing without quantum_noise; add it to effects"),
        (PRESSED, {"cnr_percent": 1}, [], "means nothing without quantum_noise"),
    ],
)
def test_a_question_that_cannot_be_answered_is_refused_with_what_to_write(load, asked, effects, words):
    with pytest.raises(ConfigurationError, match=f"scene mine: .*{words}"):
        scene(load, asked, effects)


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
    assert set(EFFECTS) >= EQUIPMENT | DEAR


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
