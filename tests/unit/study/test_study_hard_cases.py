"""Hard cases: nothing but the expected outcome passes, what is spoilt is spoilt, what should be equal is."""

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import brentq
from scipy.special import jv

from mammosim.core.errors import ConfigurationError, EquilibriumError, MechanicsError, MeshError
from mammosim.core.settings import read
from mammosim.meshing.quality import quality
from mammosim.study.hard_cases.bodies import DEFECTS, Ball
from mammosim.study.hard_cases.cases import HardCase, attempt, numbers, row, unexpected
from mammosim.study.hard_cases.invariance import INVARIANCE_TESTS, Turned, changed
from mammosim.study.hard_cases.problems import ProblemSettings
from mammosim.study.hard_cases.references import Column, Greenhill, Hemisphere, Laminate, Layer
from mammosim.study.hard_cases.verdict import Converges, Failed, Outcome, Rejected, Unstable, verdict

ANSWER = Converges(within=0.01, because="-", quantity="apex_mm", reference=Hemisphere("x"))
REJECTION = Rejected("MechanicsError", ("3 cells", "inverted"))
DIAGNOSIS = Unstable()
FAT = {"adipose": {"youngs_modulus_kpa": 1.0, "poisson_ratio": 0.45, "density_g_cm3": 1.0}}
BRICK = {"shape": "brick", "counts": [1, 1, 2], "size_mm": [10.0, 10.0, 20.0]}
BALL = {"shape": "ball", "radius_mm": 60.0, "edge_mm": 25.0}
PROBLEM = {
    "body": BALL,
    "tissues": {"adipose": {"youngs_modulus_kpa": 3.0, "poisson_ratio": 0.45, "density_g_cm3": 1.0}},
    "gravity": [0.6, 0.0, 0.8],
    "skin": {"youngs_modulus_kpa": 10.0, "poisson_ratio": 0.45, "thickness_mm": 1.0},
    "wall": {"shape": "plane"},
    "contact_kpa_mm": 5.0,
}
CHANGES = {
    "turned": {"degrees": [20, 40, -70]},
    "mirrored": {"across": "x"},
    "shifted": {"mm": [100, 0, -50]},
    "scaled": {"length": 3.0, "stiffness": 7.0},
    "renumbered": {"seed": 3},
    "stepwise": {"load_steps": 2},
    "by_way_of": {"gravity": [[0, 0, 1]]},
}


def lost(**facts):
    words = f"stability is lost. To keep it, {facts.pop('advice', 'add skin')}"
    error = EquilibriumError(words, load_factor=facts.pop("load_factor", 0.5))
    error.mode = facts.pop("mode", np.zeros((2, 3)))
    return error


def solved(error, *, verified=True):
    return Outcome("converged", error, verified=verified)


@pytest.mark.parametrize("error", [0.011, np.inf, np.nan])
def test_a_wrong_answer_is_not_ok(error):
    ok, why = verdict(ANSWER, solved(error))
    assert not ok
    assert "exceeds 0.01" in why


def test_a_right_answer_is_ok_only_when_it_was_verified():
    assert verdict(ANSWER, solved(0.009)) == (True, "")
    assert not verdict(ANSWER, solved(0.009, verified=False))[0]


@pytest.mark.parametrize(
    ("error", "outcome"),
    [(MechanicsError("no"), "rejected"), (EquilibriumError("no"), "failed"), (lost(), "unstable")],
)
def test_an_error_is_of_one_kind_and_none_is_an_answer(error, outcome):
    happened = Outcome.of(error)
    assert str(happened) == f"{outcome}: {error}"
    assert verdict(ANSWER, happened) == (False, f"{outcome} instead of converged")


@pytest.mark.parametrize("expected", [REJECTION, DIAGNOSIS, Failed(("no",))])
def test_an_answer_is_no_error(expected):
    ok, why = verdict(expected, solved(0.0))
    assert not ok
    assert why.startswith("converged instead of")


@pytest.mark.parametrize("expected", [ANSWER, REJECTION, DIAGNOSIS, Failed(("no",))])
def test_a_crash_is_never_expected(expected):
    assert not verdict(expected, Outcome("crashed", why="ValueError: no"))[0]


def test_a_rejection_must_say_why():
    assert verdict(REJECTION, Outcome.of(MechanicsError("3 cells are inverted")))[0]
    ok, why = verdict(REJECTION, Outcome.of(MechanicsError("4 cells are inverted")))
    assert not ok
    assert "'3 cells'" in why


def test_a_rejection_by_another_part_of_the_program_is_not_ok():
    assert not verdict(REJECTION, Outcome.of(MeshError("3 cells are inverted")))[0]


def test_a_body_that_passes_through_itself_is_no_answer():
    ok, why = verdict(ANSWER, Outcome("converged", 0.0, verified=True, overlapping=3))
    assert not ok
    assert why == "the body passes through itself: 3 faces of its skin lie inside it"


def test_a_failure_must_say_why_and_is_no_rejection():
    expected = Failed(("less than 20 N",))
    assert verdict(expected, Outcome.of(EquilibriumError("the force is 3 N, less than 20 N")))[0]
    assert not verdict(expected, Outcome.of(EquilibriumError("40 iterations")))[0]
    assert not verdict(expected, Outcome.of(MechanicsError("less than 20 N")))[0]


def test_a_loss_of_stability_needs_load_factor_mode_and_advice():
    assert verdict(DIAGNOSIS, Outcome.of(lost()))[0]
    assert not verdict(DIAGNOSIS, Outcome.of(lost(mode=None)))[0]
    for lacking in ({"load_factor": 1.0}, {"advice": "think"}):
        ok, why = verdict(DIAGNOSIS, Outcome.of(lost(**lacking)))
        assert not ok
        assert why.startswith("the diagnosis lacks")


def test_a_load_factor_must_be_that_of_its_reference():
    expected = Unstable(load_factor=Greenhill(1.0, 1.0, 10.0, 1.0), within=0.05)
    assert verdict(expected, Outcome.of(lost(), 0.04))[0]
    assert not verdict(expected, Outcome.of(lost(), 0.06))[0]
    assert not verdict(expected, Outcome.of(lost()))[0]


def test_or_unstable_accepts_a_diagnosis_but_no_other_error():
    either = Converges(within=0.01, because="-", same_as=(Turned((0, 0, 1)),), or_unstable=True)
    assert verdict(either, Outcome.of(lost()))[0]
    assert not verdict(either, Outcome.of(EquilibriumError("40 iterations", load_factor=0.5)))[0]
    assert not verdict(either, Outcome.of(MechanicsError("3 cells are inverted")))[0]


@pytest.mark.parametrize(
    "facts",
    [{}, {"quantity": "apex_mm"}, {"same_as": (Turned((0, 0, 1)),), "reference": Hemisphere("x")}],
)
def test_an_expectation_that_compares_nothing_is_rejected(facts):
    with pytest.raises(ConfigurationError, match="same_as"):
        Converges(within=0.01, because="-", **facts)


def case(problem, expected):
    values = {"family": "test", "hard": "-", "problem": problem, "expected": expected}
    return HardCase.of("tiny", values)


def column(**reference):
    """Confined, rho g L = 0.5 mu, hanging: a tip of 0.0228 L."""
    problem = {
        "body": BRICK,
        "tissues": {"adipose": {**FAT["adipose"], "youngs_modulus_kpa": 2.9 * 9.81e-3 * 20.0 / 0.5}},
        "gravity": [0, 0, 1],
        "held": "rollers",
    }
    reference = {"column": {"nu": 0.45, "q": 0.5, "direction": "hang", **reference}}
    expected = {"quantity": "tip_ratio", "reference": reference, "within": 1e-3, "because": "-"}
    return case(problem, {"converges": expected})


def test_a_case_is_compared_with_its_reference():
    right, wrong = row(column()), row(column(direction="stand"))
    assert right["ok"]
    assert right["error"] < 1e-3
    assert not wrong["ok"]
    assert wrong["not_ok_because"].startswith("error")


def test_a_bad_input_is_rejected_and_the_row_says_so():
    problem = {"body": {**BRICK, "defect": "inverted"}, "tissues": FAT, "gravity": [0, 0, 1]}
    found = row(case(problem, {"rejected": {"by": "MechanicsError", "saying": ["3 cells", "inverted"]}}))
    assert found["ok"]
    assert found["outcome"].startswith("rejected: 3 cells are inverted")


def test_a_crash_becomes_an_outcome():
    happened = attempt(column(nu=0.123))  # a reference that its table does not have
    assert happened.kind == "crashed"
    assert "KeyError" in str(happened)


def test_cases_that_are_not_ok_are_counted_and_named():
    table = pd.DataFrame([row(column()), row(column(direction="stand"))])
    table.loc[1, "case"] = "wrong"
    facts = numbers(table)
    counts = [facts[f"hard_cases.{name}"] for name in ("total", "converged", "rejected", "unexpected")]
    assert counts == [2, 2, 0, 1]
    assert facts["hard_cases.unexpected_names"] == "wrong"
    (line,) = unexpected(table)
    assert line.startswith("UNEXPECTED OUTCOME: wrong")


def wrong(**changes):
    problem = {"body": BALL, "tissues": FAT} | changes
    return {"family": "test", "hard": "-", "problem": problem, "expected": {"unstable": {}}}


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (
            wrong(body={**BALL, "radius": 60}),
            r"tiny\.problem\.body has no key 'radius'; did you mean 'radius_mm'",
        ),
        (wrong(body={"shape": "ball", "edge_mm": 9}), r"problem\.body lacks radius_mm; add it"),
        (wrong(body={**BALL, "shape": "cone"}), "'cone' is unknown; choose one of: ball, brick"),
        (wrong(body={**BALL, "edge_mm": "9"}), r"body\.edge_mm = '9' is of type str; write a number"),
        (wrong(body={**BALL, "edge_mm": np.nan}), r"body\.edge_mm = nan is not a finite number"),
        (wrong(body={**BALL, "radius_mm": -60}), r"radius_mm = -60 is outside \(0, 1000\]; in mm"),
        (wrong(body={**BALL, "defect": "flatt"}), "problem.body: unknown defect 'flatt'; choose one of"),
        (wrong(gravity=[0, 0]), r"problem\.gravity has 2 values; write 3"),
        (wrong(gravity=9.81), r"problem\.gravity = 9.81 is no list"),
        (wrong(held="glue"), r"problem\.held = 'glue': choose one of: posterior"),
        (wrong(tissues={"bone": FAT["adipose"]}), "choose one of: adipose, skin, muscle, lesion"),
        (wrong(contact_kpa_mm=5), "are of a wall; add one"),
        (wrong(press={"edge_radius_mm": 5, "chest_edge_mm": 7}), "problem.press: .* give exactly one"),
        (
            wrong() | {"expected": {"refused": {}}},
            r"expected\.refused: 'refused' is unknown; choose one of: conv",
        ),
        (wrong() | {"expected": {}}, r"expected has 0 keys; give one of: converges"),
        ({"family": "test"}, "cases.tiny lacks hard, problem, expected"),
    ],
)
def test_what_cannot_be_meant_is_rejected_with_its_key(values, message):
    with pytest.raises(ConfigurationError, match=message):
        HardCase.of("tiny", values)


def test_a_tissue_that_cannot_be_is_for_the_mechanics_to_reject():
    tissue = {**FAT["adipose"], "youngs_modulus_kpa": np.nan}
    happened = attempt(HardCase.of("tiny", wrong(tissues={"adipose": tissue})))
    assert str(happened).startswith("rejected: youngs_modulus_kpa = nan")


def test_squeezed_elements_are_slivers_and_nothing_is_inverted():
    mesh = read(
        Ball, {"radius_mm": 60, "edge_mm": 15, "slivers": {"count": 5, "height": 0.008}}, "body"
    ).mesh()
    table = quality(mesh)
    assert (table.aspect_ratio > 50).sum() >= 5
    assert table.smallest_J.min() > 0
    assert table.volume_mm3.sum() == pytest.approx(2 / 3 * np.pi * 60**3, rel=1e-3)


def problem_of(values):
    return read(ProblemSettings, values, "problem").problem()


@pytest.mark.parametrize("defect", DEFECTS)
def test_every_defect_is_rejected(defect):
    with pytest.raises((MechanicsError, MeshError)) as rejected:
        problem_of({**PROBLEM, "body": {**BALL, "edge_mm": 15.0, "defect": defect}}).solution()
    assert not isinstance(rejected.value, EquilibriumError)


def test_a_layer_lies_inside_the_radius_and_is_of_skin():
    mesh = Ball(radius_mm=60, edge_mm=25, layer_mm=2).mesh()
    assert np.linalg.norm(mesh.points, axis=1).max() == pytest.approx(60.0)
    assert set(np.unique(mesh.tissue)) == {1, 3}


@pytest.fixture(scope="module")
def there():
    found = problem_of(PROBLEM)
    return found, found.solution().x


def changes_of(*names):
    return [INVARIANCE_TESTS.kinds[name](**CHANGES[name]) for name in names]


@pytest.mark.parametrize("name", CHANGES)
def test_a_changed_problem_has_the_same_answer(there, name):
    found, x = there
    other = changed(found, changes_of(name)).shape()
    assert np.abs(other - x).max() <= 1e-6 * np.abs(x - found.mesh.points).max()


def test_changes_add_up(there):
    found, x = there
    both = changed(found, changes_of("scaled", "renumbered", "turned", "shifted"))
    assert np.abs(both.shape() - x).max() <= 1e-6 * np.abs(x - found.mesh.points).max()


def test_a_layer_stretched_alone_thins_as_small_strain_has_it():
    """Plane strain: e_z = - nu / (1 - nu) e_x."""
    thinned = Laminate(1 + 1e-5, (Layer(2.0, 5.0, 0.45),)).value()
    assert thinned == pytest.approx(-2.0 * 1e-5 * 0.45 / 0.55, rel=1e-4)


def test_the_column_bends_at_the_first_zero_of_the_bessel_function():
    zero = brentq(lambda z: jv(-1 / 3, z), 1.5, 2.5)
    factor = Greenhill(youngs_modulus_kpa=1.0, density_g_cm3=1.0, height_mm=10.0, side_mm=1.0).value()
    assert factor == pytest.approx(9 / 4 * zero**2 / (12 * 9.81e-3 * 1000), rel=1e-4)


def test_references_come_from_their_tables():
    assert Hemisphere("E1_nu0.45").value() == 13.4175
    assert Column(nu=0.45, q=0.5, direction="hang").value() == 0.0228217272
