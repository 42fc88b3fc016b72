"""Upright, a soft breast folds onto the chest wall: without contact it would hang through the ribs."""

import numpy as np
import pytest
from mechanics_bodies import sphere_part

from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import body_effects
from mammosim.mechanics.effects import RoundedBox, Weight, chest_wall_contact
from mammosim.mechanics.equilibrium import equilibrium

PENALTY = 5.0
RADIUS = 60.0


@pytest.fixture(scope="module")
def states():
    """A half ball of E = 0.3 kPa on the plane z = 0 under gravity along it, without and with the wall."""
    mesh = sphere_part(RADIUS, 14.0)
    tissues = {Label.ADIPOSE: Tissue(0.3, 0.45, 1.0)}
    wall = RoundedBox(np.array([0.0, 0.0, -50.0]), np.eye(3), np.array([300.0, 300.0, 50.0]), 10.0)
    contact = chest_wall_contact(mesh, wall, boundary="skin", penalty=PENALTY)
    bulk = body_effects(mesh, tissues)
    weight = Weight.of(mesh, tissues, np.array([1.0, 0.0, 0.0]))
    through, lying = (
        equilibrium(mesh, effects, loads=(weight,)).points for effects in (bulk, (*bulk, contact))
    )
    return through, lying, contact.state(lying)


def test_without_the_wall_tissue_hangs_through_it(states):
    through, _, _ = states
    assert through[:, 2].min() < -10.0


def test_the_wall_stops_it_but_for_the_penalty(states):
    _, _, on_wall = states
    # Pressure is at most that of a column of the whole diameter; penetration is pressure over penalty.
    assert 0 < on_wall.penetration < 9.81e-3 * 2 * RADIUS / PENALTY
    assert on_wall.area > 100.0


def test_the_wall_is_pushed_straight_in(states):
    """Without friction the force is along the normal, -z."""
    _, _, on_wall = states
    assert on_wall.force[2] < 0
    assert np.abs(on_wall.force[:2]).max() <= 1e-12 * abs(on_wall.force[2])
