"""The rigid motion of each position."""

import numpy as np
import pytest

from mammosim.core.positions import gravity_direction
from mammosim.digital.loading import gravity_in_body, motion

POSITIONS = ("prone", "supine", "supine_tilted")


def moved_to(position, stream=(3, "small")):
    return motion(position, largest_deg=4.0, largest_mm=8.0, stream=stream)


@pytest.mark.parametrize("position", POSITIONS)
def test_a_motion_and_its_inverse_cancel(position):
    points = np.random.default_rng(0).normal(scale=100, size=(50, 3))
    moved = moved_to(position)
    np.testing.assert_allclose(moved.inverse()(moved(points)), points, atol=1e-10)


@pytest.mark.parametrize("position", POSITIONS)
def test_a_motion_stays_within_its_limits(position):
    moved = moved_to(position)
    assert 2.0 <= moved.angle_deg <= 4.0 + 1e-9
    assert 4.0 <= np.linalg.norm(moved.t) <= 8.0 + 1e-9


@pytest.mark.parametrize("position", POSITIONS)
def test_gravity_is_exact_in_the_scanner(position):
    moved = moved_to(position)
    np.testing.assert_allclose(
        moved.R @ gravity_in_body(position, moved), gravity_direction(position), atol=1e-12
    )


def test_each_position_has_a_motion_of_its_own():
    angles = {moved_to(position).angle_deg for position in POSITIONS}
    assert len(angles) == 3
    assert moved_to("prone").angle_deg == moved_to("prone").angle_deg
