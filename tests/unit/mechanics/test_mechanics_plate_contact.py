"""Contact by mean distances: skin lies on the plate, and what it feels does not depend on the penalty."""

import numpy as np
import pytest
from mechanics_bodies import box

from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import body_effects
from mammosim.mechanics.compression import Plates, PressSettings, Thickness, compress
from mammosim.mechanics.effects import Cushion, RigidPlate, RoundedBox, six_points_in_each
from mammosim.mechanics.reference import faces_of

RULE = six_points_in_each(2)
TISSUES = {Label.ADIPOSE: Tissue(5.0, 0.45, 1.0)}


def plate(mesh, *, above, multiplier=0.0, cushion=None):
    """A flat plate whose face is `above` mm over the top, z = 10, of a cube of 10 mm; penalty 50 kPa/mm."""
    faces = faces_of(mesh, "skin")
    centre = np.array([5.0, 5.0, 16.0 + above])
    shape = RoundedBox(centre, np.eye(3), np.array([40.0, 40.0, 6.0]), 2.0)
    return RigidPlate(faces, RULE.areas(mesh.points, faces), shape, 50.0, RULE, cushion, multiplier)


@pytest.fixture(scope="module")
def cube():
    return box((2, 2, 2), (10.0, 10.0, 10.0))


def test_with_its_own_pressures_as_multipliers_pressed_skin_may_lie_on_the_plate(cube):
    """100 mm2 under 2 kPa: 200 mN, at no depth and without energy."""
    top = plate(cube, above=0.0)
    lies = np.isclose(cube.points[top.faces][..., 2].min(axis=1), 10.0)
    contact = plate(cube, above=0.0, multiplier=np.where(lies[:, None], 2.0, 0.0) * np.ones(6))
    state = contact.state(cube.points)
    assert state.force == pytest.approx([0.0, 0.0, 200.0])
    assert state.area == pytest.approx(100.0)
    assert state.penetration == pytest.approx(0.0, abs=1e-12)
    assert contact.gap_error(cube.points) == pytest.approx(0.0, abs=1e-12)
    assert contact.energy(cube.points) == pytest.approx(0.0, abs=1e-9)


def test_a_multiplier_is_updated_by_the_depth_and_ends_where_skin_leaves_the_plate(cube):
    once = plate(cube, above=-0.1).augmented(cube.points)
    assert once.state(cube.points).force[2] == pytest.approx(2 * 50.0 * 0.1 * 100.0)
    away = plate(cube, above=0.5, multiplier=once.multiplier)
    assert away.state(cube.points).force[2] == 0.0
    # It has lost all of what was 5 kPa: 0.1 mm at 50 kPa/mm.
    assert away.gap_error(cube.points) == pytest.approx(0.1)


def test_a_cushion_holds_what_presses_it_with_the_energy_of_a_spring(cube):
    """At rest lambda = p: it yields by c p, the skin lies on it, and it stores c p^2 / 2 per area."""
    cushion = Cushion(8.0, 30.0, 0.3)
    depth = 0.4
    p = depth / cushion.mm_per_kpa
    top = plate(cube, above=0.0)
    lies = np.isclose(cube.points[top.faces][..., 2].min(axis=1), 10.0)
    pressed = np.where(lies[:, None], p, 0.0) * np.ones(6)
    contact = plate(cube, above=-depth, multiplier=pressed, cushion=cushion)
    state = contact.state(cube.points)
    assert state.force[2] == pytest.approx(100.0 * p)
    assert contact.gap_error(cube.points) == pytest.approx(0.0, abs=1e-12)
    assert contact.energy(cube.points) == pytest.approx(100.0 * cushion.mm_per_kpa * p**2 / 2)


def test_force_and_area_do_not_depend_on_the_penalty():
    block = box((3, 2, 3), (30.0, 24.0, 30.0))
    between = Plates.covering(
        block.points[block.points[:, 2] > 12.0],
        direction=np.array([0.0, 1.0, 0.0]),
        outward=np.array([0.0, 0.0, 1.0]),
        edge_radius_mm=6.0,
    )
    soft, stiff = (
        compress(
            block,
            body_effects(block, TISSUES),
            plates=between,
            control=Thickness(20.0),
            settings=PressSettings(steps=2, penalty_kpa_per_mm=penalty),
        )
        for penalty in (20.0, 500.0)
    )
    assert soft.path.force_n.iloc[-1] == pytest.approx(stiff.path.force_n.iloc[-1], rel=3e-3)
    assert soft.path.contact_area_mm2.iloc[-1] == pytest.approx(
        stiff.path.contact_area_mm2.iloc[-1], rel=0.05
    )
    assert max(stage.gap_error for stage in (soft.stages[-1], stiff.stages[-1])) <= 0.02
