"""The points of a face integrate what they should, however often the face is cut."""

from math import factorial

import numpy as np
import pytest

from mammosim.core.errors import MechanicsError
from mammosim.mechanics.effects import SIX_POINTS, six_points_in_each


@pytest.mark.parametrize("parts", [1, 2, 3])
def test_polynomials_of_degree_four_are_exact(parts):
    """Integrals of L_0^i L_1^j over the unit triangle: i! j! / (i + j + 2)!"""
    rule = six_points_in_each(parts)
    assert len(rule.points) == 6 * parts**2
    assert rule.points.sum(axis=1) == pytest.approx(1.0)
    for i, j in ((0, 0), (1, 0), (2, 1), (4, 0), (2, 2)):
        found = np.sum(rule.weights * rule.points[:, 0] ** i * rule.points[:, 1] ** j)
        assert found == pytest.approx(factorial(i) * factorial(j) / factorial(i + j + 2), rel=1e-12)


def test_the_area_of_a_curved_face_is_found_by_both_rules():
    """A face on a sphere of 10 mm whose edges are arcs, as quadratic edges have them: a fraction of h^4."""
    corners = np.array([[1.0, 0.0, 0.0], [0.8, 0.6, 0.0], [0.8, 0.0, 0.6]])
    points = np.vstack([corners, (corners + np.roll(corners, -1, axis=0)) / 2])
    points *= 10.0 / np.linalg.norm(points, axis=1)[:, None]
    face = np.arange(6)[None]
    areas = [rule.areas(points, face).sum() for rule in (SIX_POINTS, six_points_in_each(2))]
    assert areas[0] == pytest.approx(areas[1], rel=1e-4)


def test_a_face_cut_into_nothing_is_rejected():
    with pytest.raises(MechanicsError, match="at least 1"):
        six_points_in_each(0)


@pytest.mark.parametrize("parts", [1, 2, 3])
def test_the_hats_are_linear_in_each_quarter_and_share_the_face(parts):
    rule = six_points_in_each(parts)
    H = rule.hats
    assert H.min() >= 0
    assert H.sum(axis=1) == pytest.approx(1.0)
    # Linear functions are those of their values at the six nodes: corners, then the middles of 01, 12, 20.
    at_nodes = np.vstack([np.eye(3), (np.eye(3) + np.roll(np.eye(3), -1, axis=0)) / 2])
    assert H @ at_nodes == pytest.approx(rule.points)


def test_each_hat_of_four_quarters_has_its_exact_integral():
    """A twelfth of the face at a corner, a quarter at the middle of an edge."""
    rule = six_points_in_each(2)
    assert rule.weights @ rule.hats == pytest.approx(np.array([1, 1, 1, 3, 3, 3]) / 24)
