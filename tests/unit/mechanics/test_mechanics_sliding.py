"""A body slides along the muscle as far as the loose tissue lets it, and never leaves it."""

import numpy as np
import pytest
from mechanics_bodies import box
from mechanics_derivatives import gradient

from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label
from mammosim.core.rigid import rotation
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import body_effects
from mammosim.mechanics.effects import EllipticCylinder, RoundedBox, Sliding, Weight
from mammosim.mechanics.equilibrium import equilibrium
from mammosim.mechanics.reference import FACE_SHAPES

FLOOR = RoundedBox(np.array([0.0, 0.0, -20.0]), np.eye(3), np.array([200.0, 200.0, 20.0]), 5.0)
ROUND = EllipticCylinder(np.array([0.0, 0.0, -100.0]), np.array([100.0, 100.0]), np.eye(3)[:, [0, 2, 1]])


@pytest.fixture(scope="module")
def mesh():
    """A block of 30 x 30 x 20 mm; its posterior face lies on the floor z = 0."""
    return box((3, 3, 2), (30.0, 30.0, 20.0))


def test_sliding_is_free_along_the_wall_and_stiff_across(mesh):
    sliding = Sliding.of(mesh, FLOOR, normal_stiffness=5.0)
    along = mesh.points + [7.0, -3.0, 0.0]
    assert sliding.energy(along) == 0.0
    assert not gradient(sliding, along).any()
    for gap in (-0.1, 0.1):
        across = mesh.points + [0.0, 0.0, gap]
        assert sliding.energy(across) == pytest.approx(5.0 / 2 * 900.0 * gap**2, rel=1e-12)


def test_sliding_around_a_round_wall_is_free(mesh):
    """About the axis of a circular cylinder every point keeps its distance, near or far from the wall."""
    sliding = Sliding.of(mesh, ROUND, normal_stiffness=5.0)
    x = (mesh.points - ROUND.centre) @ rotation(np.array([0.0, 25.0, 0.0])).T + ROUND.centre
    assert np.abs(x - mesh.points).max() > 40.0
    # Rounding of distances, 1e-13 mm each.
    assert np.abs(gradient(sliding, x)).max() <= 1e-9


def test_the_slip_under_gravity_along_the_wall_is_weight_over_stiffness(mesh):
    """k u = weight, with k = kappa A and u the mean slip: exact for a body that deforms, too."""
    tissues, kappa = {Label.ADIPOSE: Tissue(5.0, 0.45, 1.0)}, 0.1
    sliding = Sliding.of(mesh, FLOOR, normal_stiffness=50.0, tangential_stiffness=kappa)
    down = np.array([1.0, 0.0, 0.0])
    state = equilibrium(
        mesh,
        (*body_effects(mesh, tissues), sliding),
        loads=(Weight.of(mesh, tissues, down),),
        held=np.tile([False, True, False], (len(mesh.points), 1)),
    )
    slip = np.einsum("qa,ea->eq", FACE_SHAPES, (state.points - mesh.points)[sliding.faces][:, :, 0])
    mean = np.sum(sliding.areas * slip) / np.sum(sliding.areas)
    # The equilibrium leaves 1e-8 of the load.
    assert mean == pytest.approx(9.81e-3 * 20.0 / kappa, rel=1e-6)


def test_a_body_that_hangs_from_the_wall_does_not_fall(mesh):
    """Pulled off the wall by its weight, the mean gap is weight over eps A."""
    tissues = {Label.ADIPOSE: Tissue(5.0, 0.45, 1.0)}
    sliding = Sliding.of(mesh, FLOOR, normal_stiffness=50.0, tangential_stiffness=0.1)
    state = equilibrium(
        mesh,
        (*body_effects(mesh, tissues), sliding),
        loads=(Weight.of(mesh, tissues, np.array([0.0, 0.0, 1.0])),),
        held=np.tile([False, True, False], (len(mesh.points), 1)),
    )
    gap = np.einsum("qa,ea->eq", FACE_SHAPES, state.points[sliding.faces][:, :, 2])
    mean = np.sum(sliding.areas * gap) / np.sum(sliding.areas)
    assert mean == pytest.approx(9.81e-3 * 20.0 / 50.0, rel=1e-6)


def test_sliding_without_a_normal_stiffness_is_rejected(mesh):
    with pytest.raises(MechanicsError, match="eps = 0"):
        Sliding.of(mesh, FLOOR, normal_stiffness=0.0)
    with pytest.raises(MechanicsError, match="no boundary 'muscle'"):
        Sliding.of(mesh, FLOOR, normal_stiffness=1.0, boundary="muscle")
