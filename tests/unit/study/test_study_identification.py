"""Moduli found again from two positions of a small body whose moduli are known."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from mammosim.chain.points import MaterialPoints
from mammosim.core.errors import FiducialError, IdentificationError, MechanicsError, MeshError
from mammosim.core.fiducials import Fiducials
from mammosim.core.labels import Label
from mammosim.core.rigid import RigidTransform
from mammosim.core.settings import read
from mammosim.io.tables import write_table
from mammosim.mechanics.analysis import shared_analysis
from mammosim.meshing.shapes import ball_part, box
from mammosim.study.identification import pair as pairs
from mammosim.study.identification.diagnosis import chest_motion, require_explained, require_one_body
from mammosim.study.identification.fit import _gauss_newton, fitted, grid_table
from mammosim.study.identification.moduli import KEYS, Materials, Moduli
from mammosim.study.identification.pair import Pair, Position, left_by_registration
from mammosim.study.identification.posterior import covariance, draws, is_resolved, moduli_table
from mammosim.study.identification.problem import N_MODULI, Problem
from mammosim.study.identification.settings import Errors, FitSettings, Grid, Prior

NU = 0.45
ASSUMED = read(
    Materials,
    {
        "tissues": {
            name: {"youngs_modulus_kpa": 1.0, "poisson_ratio": NU, "density_g_cm3": 1.0}
            for name in ("adipose", "glandular", "muscle")
        },
        "skin": {"youngs_modulus_kpa": 10.0, "poisson_ratio": NU, "thickness_mm": 1.5},
    },
    "tissues",
)
LEFT = {"adipose": 1.0, "glandular": 2.5, "skin": 9.0, "muscle": 30.0}
RIGHT = {"adipose": 1.4, "glandular": 2.0, "skin": 13.0, "muscle": 30.0}
TRUE = {(side, tissue): E for side, of in (("left", LEFT), ("right", RIGHT)) for tissue, E in of.items()}
PRIOR = Prior(
    {"adipose": 1.2, "glandular": 2.0, "skin": 10.0, "muscle": 30.0},
    {"adipose": 3.0, "glandular": 3.0, "skin": 2.5, "muscle": 2.0},
    (NU, 0.002),
    0.1,
    0.05,
)
ERRORS = Errors(skin_mm=0.01, marker_mm=0.05)


@pytest.fixture(scope="module")
def rest():
    """Half a ball on the plane z = 0, its inner part gland, with cells of both tissues between."""
    ball = ball_part(50.0, 22.0)
    middle = ball.points[ball.cells[:, :4]].mean(axis=1)
    gland = np.clip((27 - np.linalg.norm(middle - [0, 0, middle[:, 2].mean()], axis=1)) / 10, 0, 1)
    shares = np.zeros((len(gland), len(Label)))
    shares[:, Label.GLANDULAR], shares[:, Label.ADIPOSE] = gland, 1 - gland
    return replace(ball, tissue=shares.argmax(axis=1).astype(np.uint8), shares=shares)


@pytest.fixture(scope="module")
def pair(rest):
    body = Moduli(TRUE).body(rest, ASSUMED, middle_mm=0.0)
    away = np.array([0.0, 0.0, 1.0 if rest.points[:, 2].max() > 1 else -1.0])
    skin = rest.points[rest.boundary_nodes("skin")]
    given = skin[:: len(skin) // 8]
    held = MaterialPoints.on(rest, given)
    with shared_analysis():
        prone, supine = (body.load(rest, g).points for g in (away, -away))
    chest = np.array([[40.0, 40, 0], [-40, 40, 0], [40, -40, 0], [-40, -40, 0]])

    def position(x, gravity):
        markers = held.carry(x)
        names = [f"breast_{i}" for i in range(len(markers))] + [f"chest_{i}" for i in range(4)]
        kinds = ["breast"] * len(markers) + ["chest"] * 4
        return Position(
            rest.moved_to(x), Fiducials(tuple(names), tuple(kinds), np.vstack([markers, chest])), gravity
        )

    return Pair(position(prone, away), position(supine, -away))


@pytest.fixture(scope="module")
def problem(pair):
    return Problem(pair, ASSUMED, PRIOR)


@pytest.fixture(scope="module")
def fit(problem):
    return fitted(problem, settings=FitSettings(errors=ERRORS))


def true_theta():
    return np.array([*Moduli(TRUE).logarithms(), NU, *[0.0] * 6])


def test_the_true_moduli_leave_nothing(problem):
    state = problem.predicted(true_theta())
    r = problem.residual(state, Errors(1.0, 1.0))
    # The goal's skin is flat pieces of c = 22 / 4 mm, with a sagitta of c^2 / (8 R); R is 20 mm at the rim.
    assert np.abs(r).max() < (22 / 4) ** 2 / (8 * 20)


def test_derivatives_are_those_of_whole_solutions(problem):
    theta = true_theta()
    with shared_analysis():
        slopes = problem.sensitivities(problem.predicted(theta))
        for j, h in ((0, 0.01), (2, 0.05), (N_MODULI, 0.002)):
            step = h * np.eye(len(theta))[j]
            high, low = problem.predicted(theta + step), problem.predicted(theta - step)
            central = (high.x - low.x) / (2 * h)
            # Sensitivities are solved to 5 %.
            assert np.linalg.norm(slopes.x[j] - central) < 0.06 * np.linalg.norm(central)


def test_moduli_are_found_again_left_and_right_apart(fit):
    """Within three standard deviations, which are far less than the sides differ by."""
    deviation = np.sqrt(np.diag(fit.covariance))
    apart = np.log(TRUE["right", "adipose"] / TRUE["left", "adipose"])
    for j in (KEYS.index(("left", "adipose")), KEYS.index(("right", "adipose"))):
        assert abs(fit.state.theta[j] - np.log(TRUE[KEYS[j]])) < 3 * deviation[j]
        assert 3 * deviation[j] < apart


def test_a_short_step_that_lowers_nothing_ends_the_fit_and_widens_it_and_a_long_one_is_named(
    problem, fit, monkeypatch
):
    """Phi has kinks where nearest points change: begun beside the end, as if no part of the step helped."""
    monkeypatch.setattr("mammosim.study.identification.fit._improved", lambda *given: None)
    beside = fit.state.theta + 0.3 * np.sqrt(np.diag(fit.covariance))
    settled = FitSettings(errors=fit.errors, settled=0, tolerance=1e-3, stalled=2.0)
    ended = fitted(problem, start=beside, settings=settled)
    np.testing.assert_array_equal(ended.state.theta, beside)
    # The interval reaches from where the fit stopped to where it would have gone.
    missed = np.abs(fit.state.theta - beside)
    assert np.all(missed[:N_MODULI] < 2 * np.sqrt(np.diag(ended.covariance))[:N_MODULI])
    with pytest.raises(MechanicsError, match="standard deviations long"):
        fitted(problem, start=beside, settings=replace(settled, stalled=1e-3))


def test_the_truth_lies_within_the_intervals(problem, fit):
    table = moduli_table("made", problem, fit, fascia_mm=0.1).set_index(["side", "tissue"])
    for key, E in TRUE.items():
        assert table.low_kpa[key] <= E <= table.high_kpa[key], key


def test_what_the_body_does_not_have_is_not_identifiable(problem, fit):
    table = moduli_table("made", problem, fit, fascia_mm=0.1).set_index(["side", "tissue"])
    for side in ("left", "right"):
        assert not table.identifiable[side, "muscle"]
        assert "assumed" in table.reason[side, "muscle"]
        assert not table.identifiable[side, "fascia"]


def test_a_muscle_thinner_than_two_elements_keeps_the_interval_that_was_assumed(problem, fit):
    mesh = problem.pair.start.mesh
    beside = np.isin(mesh.cells, mesh.boundary_nodes("posterior")).any(axis=1)
    tissue = np.where(beside, Label.MUSCLE, Label.ADIPOSE).astype(np.uint8)
    layered = replace(problem.pair.start, mesh=replace(mesh, tissue=tissue, shares=None))
    layered_problem = replace(problem, pair=Pair(layered, problem.pair.goal))
    table = moduli_table("made", layered_problem, fit, fascia_mm=0.1).set_index(["side", "tissue"])
    muscle = table.loc["left", "muscle"]
    assert not muscle.identifiable
    assert muscle.low_kpa <= 30.0 / 2.0**1.96
    assert muscle.high_kpa >= 30.0 * 2.0**1.96


def test_the_models_error_widens_both_sides_alike(problem, fit):
    wider = covariance(replace(problem, model_error={"adipose": 0.3}), fit) - fit.covariance
    left, right = KEYS.index(("left", "adipose")), KEYS.index(("right", "adipose"))
    assert wider[left, left] == wider[right, right] == wider[left, right] == pytest.approx(0.09)
    assert np.count_nonzero(wider) == 4


def test_an_unsure_registration_widens_the_intervals(problem):
    """By how much depends on what the data say of the motion themselves: here, of 0.01 mm, almost all."""
    state = problem.predicted(true_theta())
    with shared_analysis():
        slopes = problem.sensitivities(state)
    unsure = replace(problem, prior=PRIOR.widened(shift_mm=0.5, turn_deg=0.3))
    sure, wide = (
        np.sqrt(np.diag(_gauss_newton(each, state, slopes, ERRORS)[1]))[:N_MODULI]
        for each in (problem, unsure)
    )
    assert np.all(wide >= sure)
    assert wide[0] > sure[0], "of fat, on the left"
    same = PRIOR.widened(shift_mm=float("nan"), turn_deg=float("nan"))
    assert same == PRIOR, "where a registration by markers states nothing"
    assert PRIOR.widened(shift_mm=0.01, turn_deg=0.01) == PRIOR, "never narrower than what is assumed"


def test_what_a_registration_leaves_is_read_from_its_steps(tmp_path):
    """Of the step that was used; Student's quantile of 7 degrees of freedom is 2.365."""
    steps = pd.DataFrame(
        {
            "step": ["surface", "image"],
            "used": [False, True],
            "error_95_mm": [9.0, 3.0],
            "error_95_deg": [9, 1.5],
        }
    )
    write_table(steps, tmp_path / "steps.csv")
    left = left_by_registration(tmp_path / "steps.csv")
    assert left == pytest.approx(
        {"shift_mm": 3 / (2.365 * 3**0.5), "turn_deg": 1.5 / (2.365 * 3**0.5)}, rel=1e-3
    )
    write_table(steps.assign(error_95_mm=np.nan, error_95_deg=np.nan), tmp_path / "marked.csv")
    write_table(steps.iloc[:0], tmp_path / "still.csv")
    for name in ("marked", "still"):
        assert np.isnan(list(left_by_registration(tmp_path / f"{name}.csv").values())).all()


def test_a_layer_of_one_element_is_not_resolved_and_one_of_three_is(rest):
    for layers, resolved in ((1, False), (3, True)):
        block = box((6, 6, 6), (60.0, 60.0, 60.0))
        low = block.points[block.cells[:, :4], 2].mean(axis=1) < 10.0 * layers
        tissue = np.where(low, Label.MUSCLE, Label.ADIPOSE).astype(np.uint8)
        assert is_resolved(replace(block, tissue=tissue), Label.MUSCLE) == resolved
    assert is_resolved(rest, Label.MUSCLE)  # has none


def test_draws_have_the_posteriors_spread_and_begin_with_the_fit(problem, fit):
    table = draws(problem, fit, 400, stream=("test",))
    first = Moduli.of_draw(table.iloc[0])
    assert first.kpa == pytest.approx(Moduli.of_logarithms(fit.state.theta[:N_MODULI]).kpa)
    spread = np.log(table.left_adipose_kpa[1:]).std()
    # The standard deviation of 399 draws is known to 1 / sqrt(2 * 399) = 3.5 %, three of which are allowed.
    assert spread == pytest.approx(np.sqrt(fit.covariance[0, 0]), rel=0.11)


def test_the_search_by_hand_is_lowest_near_the_truth_and_says_what_failed(problem):
    table = grid_table(problem, Grid(breast_kpa=[0.01, 1.5, 6.0], skin_kpa=[10.0]))
    assert table.breast_kpa[table.skin_rms_mm.idxmin()] == 1.5
    assert table.outcome[0].startswith(("failed: ", "unstable: "))


def test_without_breast_markers_the_skin_alone_is_explained(problem):
    """And chest markers are not asked for: what the registration left is not seen by them."""
    pair = problem.pair
    bare = Fiducials((), (), np.empty((0, 3)))
    unmarked = Pair(pair.start, replace(pair.goal, fiducials=bare))
    require_one_body(unmarked)
    table = grid_table(replace(problem, pair=unmarked), Grid(breast_kpa=[1.5, 6.0], skin_kpa=[10.0]))
    assert table.breast_kpa[table.skin_rms_mm.idxmin()] == 1.5
    assert table.marker_rms_mm.isna().all()
    others = Fiducials(("breast_x",), ("breast",), np.zeros((1, 3)))
    with pytest.raises(FiducialError, match="share no breast marker"):
        Pair(pair.start, replace(pair.goal, fiducials=others))


def test_swapped_sides_are_named(pair):
    goal = pair.goal.fiducials
    mirrored = Fiducials(goal.names, goal.kinds, goal.points * [-1, 1, 1])
    with pytest.raises(IdentificationError, match="left and right are swapped"):
        require_one_body(Pair(pair.start, replace(pair.goal, fiducials=mirrored)))


def test_a_rigid_motion_that_was_left_in_is_named(pair):
    angle = np.radians(6.0)
    R = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
    motion = RigidTransform(R, np.array([0.0, 5.0, 0.0]))
    goal = pair.goal.fiducials
    moved = Pair(
        pair.start, replace(pair.goal, fiducials=Fiducials(goal.names, goal.kinds, motion(goal.points)))
    )
    assert chest_motion(moved) == (pytest.approx(5.0, rel=1e-6), pytest.approx(6.0, rel=1e-6))
    with pytest.raises(
        IdentificationError, match=r"rigid motion of 5\.0 mm and 6\.0 degrees was not removed"
    ):
        require_one_body(moved)


def test_another_woman_is_named(pair):
    require_one_body(pair)
    larger = replace(pair.goal, mesh=pair.goal.mesh.moved_to(1.2 * pair.goal.mesh.points))
    with pytest.raises(IdentificationError, match="these are probably two women"):
        require_one_body(Pair(pair.start, larger))


def test_what_no_moduli_explain_is_rejected(fit):
    worse = replace(fit, history=(*fit.history[:-1], fit.history[-1]._replace(skin_rms_mm=5.0)))
    require_explained(fit)
    with pytest.raises(IdentificationError, match=r"the best leave 5\.0 mm of the skin"):
        require_explained(worse)


def test_a_body_without_breasts_is_rejected(pair, monkeypatch):
    monkeypatch.setattr(pairs, "DEPTH_MM", 500.0)
    with pytest.raises(MeshError, match="no breast is seen"):
        Pair(pair.start, pair.goal)
