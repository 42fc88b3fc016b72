import numpy as np
import pytest

from mammosim.core.rigid import IDENTITY, RigidTransform, rotation
from mammosim.study.identification.scores import distances, registration_error, score_row, shape_error

POINTS = np.array([[0.0, 0, 0], [100, 0, 0], [0, 100, 0]])


def test_the_true_motion_has_no_error():
    fixed = RigidTransform(rotation(np.array([2.0, -1, 3])), np.array([1.0, 2, 3]))
    moving = RigidTransform(rotation(np.array([-1.0, 2, 1])), np.array([-4.0, 0, 2]))
    error = registration_error(fixed.after(moving.inverse()), moving, fixed, POINTS)
    assert error["error_max_mm"] == pytest.approx(0, abs=1e-9)
    # arccos near 1 turns rounding of 1e-16 into 1e-8 rad.
    assert error["rotation_error_deg"] == pytest.approx(0, abs=2e-6)


def test_a_shift_is_an_error_of_its_length_and_a_turn_of_its_angle():
    shifted = RigidTransform(np.eye(3), np.array([3.0, 4, 0]))
    assert registration_error(shifted, IDENTITY, IDENTITY, POINTS)["error_mean_mm"] == pytest.approx(5)
    turned = RigidTransform(rotation(np.array([0, 0, 2.0])), np.zeros(3))
    error = registration_error(turned, IDENTITY, IDENTITY, POINTS)
    assert error["rotation_error_deg"] == pytest.approx(2)
    assert error["error_max_mm"] == pytest.approx(2 * 100 * np.sin(np.radians(1)))


def test_the_shape_error_of_a_shifted_flat_side_is_the_shift_seen_in_the_frame_of_the_estimate(block):
    truth = block()
    top = truth.boundaries["skin"]
    flat = top[np.all(np.isclose(truth.points[top][..., 1], 0), axis=1)]
    only = type(truth)(truth.points, truth.cells, truth.tissue, {"skin": flat})
    motion = RigidTransform(rotation(np.array([5.0, -3, 8])), np.array([4.0, -2, 1]))
    estimate = only.moved_to(motion(only.points - [0, 1.5, 0]))
    error = shape_error(estimate, only, motion=motion)
    assert error["mean_mm"] == pytest.approx(1.5, abs=1e-9)
    assert error["max_mm"] == pytest.approx(1.5, abs=1e-9)


def test_distances_are_summed_up_by_mean_95_percent_and_largest():
    error = distances(np.arange(101.0))
    assert (error["mean_mm"], error["p95_mm"], error["max_mm"]) == (50, 95, 100)


def test_a_score_row_names_the_volunteer_and_what_was_scored():
    row = score_row("small", {"method": "fixed_point"}, {"mean_mm": 1.0})
    assert list(row.columns) == ["volunteer", "method", "mean_mm"]
