"""Judging hard cases: nothing that differs from what was expected passes."""

import numpy as np
import pandas as pd
import pytest

from mammosim.core.errors import ConfigurationError, EquilibriumError, MechanicsError, MeshError
from mammosim.study.hard_cases.cases import HardCase, attempt, not_as_expected, numbers, row
from mammosim.study.hard_cases.judgement import Converges, Outcome, Refused, judged

ANSWER = Converges(within=0.01, because="-", quantity="apex_mm", reference={"hemisphere": {"case": "x"}})
REFUSAL = Refused("MechanicsError", ("3 cells", "inverted"))
DIAGNOSIS = Refused("EquilibriumError", ("stability",), diagnosed=True)
FAT = {"adipose": {"youngs_modulus_kpa": 1.0, "poisson_ratio": 0.45, "density_g_cm3": 1.0}}
BRICK = {"shape": "brick", "counts": [1, 1, 2], "size_mm": [10.0, 10.0, 20.0]}


def lost(**facts):
    words = f"stability is lost. To keep it, {facts.pop('advice', 'add skin')}"
    error = EquilibriumError(words, load_factor=facts.pop("load_factor", 0.5))
    error.mode = facts.pop("mode", None)
    return error


def refused(refusal, **facts):
    return Outcome("refused", refusal=refusal, **facts)


def solved(error, *, verified=True):
    return Outcome("converged", error, verified=verified)


@pytest.mark.parametrize("error", [0.011, np.inf, np.nan])
def test_a_wrong_answer_is_not_ok(error):
    ok, why = judged(ANSWER, solved(error))
    assert not ok
    assert "exceeds 0.01" in why


def test_a_right_answer_is_ok_only_when_it_was_verified():
    assert judged(ANSWER, solved(0.009)) == (True, "")
    assert not judged(ANSWER, solved(0.009, verified=False))[0]


def test_a_refusal_is_no_answer_and_an_answer_no_refusal():
    assert not judged(ANSWER, refused(MechanicsError("no")))[0]
    assert judged(REFUSAL, solved(0.0)) == (False, "solved instead of refused")


@pytest.mark.parametrize("expected", [ANSWER, REFUSAL, DIAGNOSIS])
def test_a_crash_is_never_what_was_expected(expected):
    assert not judged(expected, Outcome("crashed: ValueError", crashed=True))[0]


def test_a_refusal_must_say_why():
    assert judged(REFUSAL, refused(MechanicsError("3 cells are inverted")))[0]
    ok, why = judged(REFUSAL, refused(MechanicsError("4 cells are inverted")))
    assert not ok
    assert "'3 cells'" in why


def test_a_refusal_by_another_part_of_the_program_is_not_ok():
    assert not judged(REFUSAL, refused(MeshError("3 cells are inverted")))[0]


def test_a_loss_of_stability_needs_load_factor_mode_and_advice():
    mode = np.zeros((2, 3))
    assert judged(DIAGNOSIS, refused(lost(mode=mode)))[0]
    for lacking in ({"mode": None}, {"mode": mode, "load_factor": 1.0}, {"mode": mode, "advice": "think"}):
        ok, why = judged(DIAGNOSIS, refused(lost(**lacking)))
        assert not ok
        assert why.startswith("the diagnosis lacks")


def test_a_load_factor_must_be_that_of_its_reference():
    expected = Refused("EquilibriumError", ("stability",), load_factor={"greenhill": {}}, within=0.05)
    assert judged(expected, refused(lost(), error=0.04))[0]
    assert not judged(expected, refused(lost(), error=0.06))[0]
    assert not judged(expected, refused(lost()))[0]


def test_or_diagnosed_accepts_a_diagnosis_but_no_other_refusal():
    either = Converges(within=0.01, because="-", same_as={"turned": {}}, or_diagnosed=True)
    assert judged(either, refused(lost(mode=np.zeros((2, 3)))))[0]
    assert not judged(either, refused(EquilibriumError("40 iterations", load_factor=0.5)))[0]
    assert not judged(either, refused(MechanicsError("3 cells are inverted")))[0]


@pytest.mark.parametrize("facts", [{}, {"quantity": "apex_mm"}, {"same_as": {}, "reference": {}}])
def test_an_expectation_that_compares_nothing_is_refused(facts):
    with pytest.raises(ConfigurationError, match="same_as"):
        Converges(within=0.01, because="-", **facts)


def case(scene, expected):
    values = {"family": "test", "hard": "-", "scene": scene, "expected": expected}
    return HardCase.of("tiny", values)


def column(**reference):
    """Confined, rho g L = 0.5 mu, hanging: a tip of 0.0228 L."""
    scene = {
        "body": BRICK,
        "tissues": {"adipose": {**FAT["adipose"], "youngs_modulus_kpa": 2.9 * 9.81e-3 * 20.0 / 0.5}},
        "gravity": [0, 0, 1],
        "held": "rollers",
    }
    reference = {"column": {"nu": 0.45, "q": 0.5, "direction": "hang", **reference}}
    expected = {"quantity": "tip_ratio", "reference": reference, "within": 1e-3, "because": "-"}
    return case(scene, {"converges": expected})


def test_a_case_is_compared_with_its_reference():
    right, wrong = row(column()), row(column(direction="stand"))
    assert right["ok"]
    assert right["error"] < 1e-3
    assert not wrong["ok"]
    assert wrong["not_ok_because"].startswith("error")


def test_a_bad_input_is_refused_and_the_row_says_so():
    scene = {"body": {**BRICK, "defect": "inverted"}, "tissues": FAT, "gravity": [0, 0, 1]}
    found = row(case(scene, {"refused": {"by": "MechanicsError", "saying": ["3 cells", "inverted"]}}))
    assert found["ok"]
    assert found["outcome"].startswith("refused")


def test_a_crash_becomes_an_outcome():
    scene = {"body": {"shape": "brick", "counts": [1, 1]}, "tissues": FAT, "gravity": [0, 0, 1]}
    happened = attempt(case(scene, {"refused": {"by": "MechanicsError", "saying": ["size"]}}))
    assert happened.crashed
    assert "TypeError" in happened.words


def test_cases_that_are_not_ok_are_counted_and_named():
    table = pd.DataFrame([row(column()), row(column(direction="stand"))])
    table.loc[1, "case"] = "wrong"
    facts = numbers(table)
    assert (facts["hard_cases.total"], facts["hard_cases.not_ok"]) == (2, 1)
    assert facts["hard_cases.not_ok_names"] == "wrong"
    (line,) = not_as_expected(table)
    assert line.startswith("NOT AS EXPECTED: wrong")
