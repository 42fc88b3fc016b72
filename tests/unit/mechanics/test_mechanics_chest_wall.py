"""The chest wall keeps its exact distance from everywhere, and carries what lies on it."""

import numpy as np
import pytest
from mechanics_bodies import box
from mechanics_derivatives import gradient

from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label
from mammosim.core.rigid import rotation
from mammosim.core.rng import generator
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import body_effects
from mammosim.mechanics.effects import EllipticCylinder, Weight, chest_wall_contact
from mammosim.mechanics.equilibrium import equilibrium

RIBS = EllipticCylinder(np.array([0.0, 60.0, 0.0]), np.array([140.0, 100.0]))


def around_the_ribs(heights):
    """Points at known heights over random places of RIBS, and the normals there."""
    angle = generator("ribs").uniform(0, 2 * np.pi, len(heights))
    foot = np.stack([140 * np.cos(angle), 60 + 100 * np.sin(angle), 30 * angle], axis=1)
    n = np.stack([np.cos(angle) / 140, np.sin(angle) / 100, 0 * angle], axis=1)
    n /= np.linalg.norm(n, axis=1)[:, None]
    return foot + heights[:, None] * n, n


def test_the_distance_is_the_height_over_the_nearest_point():
    # The smallest radius of curvature is b^2 / a = 71 mm: deeper points have another nearest point.
    heights = np.linspace(-60.0, 90.0, 301)
    x, n = around_the_ribs(heights)
    assert RIBS.distance(x) == pytest.approx(heights, abs=1e-11)
    assert RIBS.normal(x) == pytest.approx(n, abs=1e-12)


def test_the_distance_on_the_axes_is_exact():
    x = np.array([[150.0, 60, 7], [-120, 60, 0], [0, -50, 0], [0, 140, -9]])
    assert RIBS.distance(x) == pytest.approx([10.0, -20.0, 10.0, -20.0], abs=1e-9)


def test_the_normal_and_the_curvature_are_derivatives_of_the_distance_in_any_frame():
    R = rotation(np.array([20.0, -35.0, 50.0]))
    wall = EllipticCylinder(R @ RIBS.centre, RIBS.semi_axes, R)
    x = around_the_ribs(np.linspace(-20.0, 40.0, 61))[0] @ R.T
    v, h = generator("wall").standard_normal(x.shape), 1e-4
    slope = (wall.distance(x + h * v) - wall.distance(x - h * v)) / (2 * h)
    # Truncation is h^2 over a radius of curvature squared, rounding 1e-13 / h.
    assert np.sum(wall.normal(x) * v, axis=1) == pytest.approx(slope, abs=1e-8)
    turn = (wall.normal(x + h * v) - wall.normal(x - h * v)) / (2 * h)
    assert np.einsum("nij,nj->ni", wall.hessian(x), v) == pytest.approx(turn, abs=1e-8)


@pytest.fixture(scope="module")
def lying():
    """A block of 30 x 24 x 30 mm whose posterior face, at its highest y, lies on the sternum."""
    block = box((3, 2, 3), (30.0, 24.0, 30.0), posterior_axis=1)
    return block.moved_to(block.points * [1, -1, -1] + [-15.0, -40.0, 15.0])


def test_the_wall_feels_the_force_that_it_exerts(lying):
    contact = chest_wall_contact(lying, RIBS, boundary="posterior", penalty=3.0)
    x = lying.points + [0.0, 1.0, 0.0] + 0.3 * generator("lying").standard_normal(lying.points.shape)
    assert 0.2 < np.mean(RIBS.distance(x[lying.boundary_nodes("posterior")]) < 0) < 1.0
    assert contact.state(x).force == pytest.approx(gradient(contact, x).sum(axis=0), rel=1e-12, abs=1e-12)


def test_a_body_lying_on_the_wall_is_carried_by_its_weight(lying):
    """Nothing else holds it along y: the wall alone balances rho g V, and yields by pressure over penalty."""
    tissues = {Label.ADIPOSE: Tissue(1.0, 0.45, 1.0)}
    gravity, penalty = np.array([0.0, 1.0, 0.0]), 10.0
    contact = chest_wall_contact(lying, RIBS, boundary="posterior", penalty=penalty)
    held = np.tile([True, False, True], (len(lying.points), 1))
    # The wall falls away by 15^2 / (2 * 196) = 0.6 mm under the rim: begun 1 mm deep, all of it touches.
    state = equilibrium(
        lying,
        (*body_effects(lying, tissues), contact),
        loads=(Weight.of(lying, tissues, gravity),),
        start=lying.points + gravity,
        held=held,
    )
    on_wall = contact.state(state.points)
    weight = 9.81e-3 * 30.0 * 24.0 * 30.0
    assert on_wall.force[1] == pytest.approx(weight, rel=0.01)
    assert on_wall.penetration < 0.2


def test_a_wall_that_cannot_be_is_rejected(lying):
    with pytest.raises(MechanicsError, match="semi-axes"):
        EllipticCylinder(np.zeros(3), np.array([140.0, 0.0]))
    with pytest.raises(MechanicsError, match="orthonormal"):
        EllipticCylinder(np.zeros(3), np.array([140.0, 100.0]), 2 * np.eye(3))
    with pytest.raises(MechanicsError, match="no boundary 'back'; it has: posterior, skin"):
        chest_wall_contact(lying, RIBS, boundary="back", penalty=1.0)
