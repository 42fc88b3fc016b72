"""Water carries what is under its surface by the weight of the water displaced (Archimedes)."""

import numpy as np
import pytest
from mechanics_bodies import box
from mechanics_derivatives import gradient

from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import body_effects
from mammosim.mechanics.effects import Buoyancy, Weight
from mammosim.mechanics.equilibrium import equilibrium

DOWN = np.array([0.0, 0.6, 0.8])
DEEP = -1000.0


@pytest.fixture(scope="module")
def mesh():
    return box((2, 2, 2), (10.0, 12.0, 9.0))


def test_the_uplift_is_the_weight_of_the_water_displaced(mesh):
    uplift = gradient(Buoyancy.of(mesh, DOWN, level_mm=DEEP), mesh.points).sum(axis=0)
    assert uplift == pytest.approx(9.81e-3 * 10 * 12 * 9 * DOWN, rel=1e-12)
    assert not gradient(Buoyancy.of(mesh, DOWN, level_mm=-DEEP), mesh.points).any()


def test_the_uplift_grows_with_the_depth_of_what_is_under_water():
    """A bar of 40 mm hanging down into water, immersed to depth h: the force is gamma A h."""
    bar, down = box((1, 1, 8), (10.0, 10.0, 40.0)), np.array([0.0, 0.0, 1.0])
    for level in (10.0, 25.0):
        water = Buoyancy.of(bar, down, level_mm=level, waterline_mm=10.0)
        # Layers of 5 mm with a few points each: the waterline of 10 mm is integrated to about 1 % of h.
        force = gradient(water, bar.points)[:, 2].sum()
        assert force == pytest.approx(9.81e-3 * 100.0 * (40.0 - level), rel=0.01)


def test_a_neutrally_buoyant_body_does_not_move(mesh):
    tissues = {Label.ADIPOSE: Tissue(0.3, 0.45, 1.0)}
    loads = (Weight.of(mesh, tissues, DOWN), Buoyancy.of(mesh, DOWN, level_mm=DEEP))
    state = equilibrium(mesh, body_effects(mesh, tissues), loads=loads)
    assert np.abs(state.points - mesh.points).max() <= 1e-9


def test_water_without_sense_is_rejected(mesh):
    with pytest.raises(MechanicsError, match="unit vector"):
        Buoyancy.of(mesh, 9.81 * DOWN, level_mm=0.0)
    with pytest.raises(MechanicsError, match="waterline"):
        Buoyancy.of(mesh, DOWN, level_mm=0.0, waterline_mm=0.0)
