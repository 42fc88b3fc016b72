"""A network of springs is as stiff as its ligaments, E A / L, and slack ones do nothing."""

import numpy as np
import pytest
from mechanics_bodies import box
from mechanics_derivatives import (
    gradient,
    tangent,
)

from mammosim.core.errors import MechanicsError
from mammosim.mechanics.effects import Springs


@pytest.fixture(scope="module")
def mesh():
    return box((2, 2, 2), (10.0, 12.0, 9.0))


def network(mesh):
    """The edges of all cells."""
    pairs = np.unique(np.sort(mesh.cells[:, [[0, 1], [1, 2], [2, 3], [3, 0]]].reshape(-1, 2), axis=1), axis=0)
    return Springs.between(mesh.points, pairs, youngs_modulus_kpa=500.0, section_mm2=0.2)


def test_a_chain_of_springs_has_the_stiffness_of_its_length():
    """n springs in a row of total length L: E A / L between the ends once the middle is in balance."""
    points = np.zeros((5, 3))
    points[:, 0] = np.linspace(0.0, 40.0, 5)
    pairs = np.stack([np.arange(4), np.arange(1, 5)], axis=1)
    chain = Springs.between(points, pairs, youngs_modulus_kpa=500.0, section_mm2=0.2)
    x = 1.05 * points
    g = gradient(chain, x)
    assert np.abs(g[1:-1]).max() <= 1e-12
    assert g[-1] == pytest.approx([500.0 * 0.2 / 40.0 * 2.0, 0.0, 0.0], rel=1e-12)
    K = tangent(chain, x).toarray()[::3, ::3]
    ends, middle = [0, 4], [1, 2, 3]
    condensed = K[np.ix_(ends, ends)] - K[np.ix_(ends, middle)] @ np.linalg.solve(
        K[np.ix_(middle, middle)], K[np.ix_(middle, ends)]
    )
    assert condensed == pytest.approx(2.5 * np.array([[1, -1], [-1, 1]]), rel=1e-12)


def test_springs_carry_no_compression_and_may_hang_loose(mesh):
    springs = network(mesh)
    assert springs.energy(0.9 * mesh.points) == 0.0
    assert not gradient(springs, 0.9 * mesh.points).any()
    loose = Springs.between(mesh.points, springs.pairs, youngs_modulus_kpa=500.0, section_mm2=0.2, slack=1.1)
    assert loose.energy(1.05 * mesh.points) == 0.0
    assert loose.energy(1.15 * mesh.points) > 0.0


def test_a_spring_between_a_node_and_itself_is_rejected(mesh):
    with pytest.raises(MechanicsError, match="1 springs, the first 1"):
        Springs.between(mesh.points, np.array([[0, 1], [2, 2]]), youngs_modulus_kpa=500.0, section_mm2=0.2)
