"""The thickness map of a body that is known."""

import numpy as np
import pytest

from mammosim.chain.plates import thickness_map
from mammosim.core.errors import MeshError
from mammosim.core.rigid import rotation
from mammosim.mechanics.paddles import Plates

FORWARD_UP = np.column_stack([[0.0, -1, 0], [1.0, 0, 0], [0.0, 0, 1]])


def plates(centre, half_sizes, axes=FORWARD_UP):
    return Plates(np.asarray(centre, float), axes, np.asarray(half_sizes, float), 2.0)


def test_a_cube_is_as_thick_as_its_edge_and_nothing_lies_beside_it(block):
    found = thickness_map(block(), plates([15.0, 15.0, 15.0], [20.0, 30.0, 5.0]))
    assert np.allclose(found.thickness_mm, 30.0)
    # 30 mm of the 40 by 60 mm under the plates, in places 2 mm apart.
    assert len(found) == 15 * 15
    assert found.outward_mm.min() == pytest.approx(5.0, abs=1.01)
    assert found.across_mm.abs().max() == pytest.approx(15.0, abs=1.01)


def test_a_wedge_grows_from_its_edge(block):
    mesh = block()
    x = mesh.points.copy()
    x[:, 2] *= 1 + (30.0 - x[:, 1]) / 60.0  # 30 mm at the chest, 45 mm at the front
    found = thickness_map(mesh.moved_to(x), plates([15.0, 15.0, 15.0], [15.0, 15.0, 5.0]))
    np.testing.assert_allclose(found.thickness_mm, 30.0 + found.outward_mm / 2, atol=1e-9)


def test_the_map_turns_with_the_plates(block):
    mesh, R = block(), rotation(np.array([0.0, 40.0, 0.0]))
    turned = thickness_map(
        mesh.moved_to(mesh.points @ R.T), plates(R @ [15.0, 15, 15], [15.0, 15, 5], R @ FORWARD_UP)
    )
    assert np.allclose(turned.thickness_mm, 30.0)


def test_plates_beside_the_body_are_rejected(block):
    with pytest.raises(MeshError, match="no tissue lies between the plates"):
        thickness_map(block(), plates([200.0, 0, 0], [10.0, 10, 5]))
