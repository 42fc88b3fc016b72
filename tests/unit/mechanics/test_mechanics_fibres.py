"""Fibres pull when they are stretched, by a closed form, and store nothing when they are shortened."""

import numpy as np
import pytest
from mechanics_bodies import box
from mechanics_derivatives import (
    gradient,
)

from mammosim.core.errors import MechanicsError
from mammosim.mechanics.effects import Fibres

VOLUME = 1080.0


@pytest.fixture(scope="module")
def mesh():
    return box((2, 2, 2), (10.0, 12.0, 9.0))


def along(mesh, direction):
    return np.tile(np.asarray(direction, dtype=float), (len(mesh.cells), 1))


def test_a_shortened_fibre_stores_nothing(mesh):
    fibres = Fibres.of(mesh, along(mesh, [1, 0, 0]), stiffness_kpa=2.0)
    x = mesh.points * [0.7, 1.4, 1.2]
    assert fibres.energy(x) == 0.0
    assert not gradient(fibres, x).any()


@pytest.mark.parametrize(("k1", "k2"), [(2.0, 0.0), (2.0, 1.5)])
def test_a_stretched_fibre_pulls_with_the_uniaxial_closed_form(mesh, k1, k2):
    """W = k1/(2 k2) (exp(k2 e^2) - 1), e = s^2 - 1; nominal stress dW/ds = 2 s k1 e exp(k2 e^2)."""
    stretch = 1.2
    e = stretch**2 - 1
    fibres = Fibres.of(mesh, along(mesh, [1, 0, 0]), stiffness_kpa=k1, exponent=k2)
    x = mesh.points * [stretch, 1.0, 1.0]
    W = (np.exp(k2 * e**2) - 1) * k1 / (2 * k2) if k2 else k1 / 2 * e**2
    assert fibres.energy(x) == pytest.approx(VOLUME * W, rel=1e-12)
    pull = gradient(fibres, x)[mesh.points[:, 0] == 10.0].sum(axis=0)
    stress = 2 * stretch * k1 * e * np.exp(k2 * e**2)
    assert pull == pytest.approx([stress * 12 * 9, 0.0, 0.0], rel=1e-12, abs=1e-9)


def test_cells_of_direction_zero_have_no_fibres(mesh):
    directions = along(mesh, [1, 0, 0])
    directions[mesh.points[mesh.cells[:, :4]].mean(axis=1)[:, 1] > 6.0] = 0.0
    half, whole = (
        Fibres.of(mesh, a, stiffness_kpa=2.0).energy(mesh.points * [1.2, 1.0, 1.0])
        for a in (directions, along(mesh, [1, 0, 0]))
    )
    assert half == pytest.approx(whole / 2, rel=1e-12)


def test_directions_that_are_no_unit_vectors_are_rejected(mesh):
    with pytest.raises(MechanicsError, match="48 of length neither 0 nor 1"):
        Fibres.of(mesh, along(mesh, [1, 1, 0]), stiffness_kpa=2.0)
    with pytest.raises(MechanicsError, match="fibre directions"):
        Fibres.of(mesh, np.eye(3), stiffness_kpa=2.0)
    with pytest.raises(MechanicsError, match="at least 0"):
        Fibres.of(mesh, along(mesh, [1, 0, 0]), stiffness_kpa=-2.0)
