"""Ligaments run from the muscle, or the chest wall, to the skin, and hold it back."""

from dataclasses import replace

import numpy as np
import pytest
from mechanics_bodies import box, sphere_part

from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import Fascia, body_effects
from mammosim.mechanics.effects import Fibres, Springs, Weight
from mammosim.mechanics.equilibrium import equilibrium
from mammosim.mechanics.ligaments import deep_faces, faces_between, ligament_directions, ligament_pairs

TISSUES = dict.fromkeys((Label.ADIPOSE, Label.MUSCLE), Tissue(0.5, 0.45, 1.0))


@pytest.fixture(scope="module")
def slab():
    """20 x 20 x 24 mm on its posterior face z = 0; the lower 8 mm are muscle; only the top is skin."""
    mesh = box((2, 2, 3), (20.0, 20.0, 24.0))
    muscle = mesh.points[mesh.cells[:, :4]][:, :, 2].max(axis=1) <= 8.0
    top = np.all(mesh.points[mesh.boundaries["skin"]][:, :, 2] == 24.0, axis=1)
    boundaries = {**mesh.boundaries, "skin": mesh.boundaries["skin"][top]}
    return replace(mesh, tissue=np.where(muscle, Label.MUSCLE, Label.ADIPOSE), boundaries=boundaries)


def test_the_face_of_the_muscle_looks_out_of_it(slab):
    faces = faces_between(slab, Label.MUSCLE)
    corners = slab.points[faces[:, :3]]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    assert areas.sum(axis=0) == pytest.approx([0.0, 0.0, 400.0])
    assert np.all(slab.points[faces][:, :, 2] == 8.0)
    assert np.array_equal(deep_faces(slab), faces)
    assert len(faces_between(slab, Label.GLANDULAR)) == 0


def test_between_planes_ligaments_are_straight_and_muscle_has_none(slab):
    directions = ligament_directions(slab)
    muscle = slab.tissue == Label.MUSCLE
    assert not directions[muscle].any()
    assert directions[~muscle] == pytest.approx(np.tile([0.0, 0.0, 1.0], (np.sum(~muscle), 1)), abs=1e-9)


def test_a_cell_with_all_its_vertices_on_the_skin_has_none():
    """phi is 1 in all of it; what rounding leaves of its gradient is no direction."""
    mesh = box((4, 4, 4), (100.0, 90.0, 80.0))
    constant = np.isin(mesh.cells[:, :4], mesh.boundaries["skin"][:, :3]).all(axis=1)
    constant &= ~np.isin(mesh.cells[:, :4], mesh.boundaries["posterior"][:, :3]).any(axis=1)
    directions = ligament_directions(mesh)
    assert constant.any()
    assert not directions[constant].any()
    inside = ~np.isin(mesh.cells[:, :4], mesh.boundaries["skin"][:, :3]).any(axis=1)
    assert np.linalg.norm(directions[inside], axis=1) == pytest.approx(1.0)


def test_in_a_half_ball_they_end_on_the_skin_at_right_angles():
    mesh = sphere_part(60.0, 15.0)
    directions = ligament_directions(mesh)
    assert np.linalg.norm(directions, axis=1) == pytest.approx(1.0)
    on_skin = np.isin(mesh.cells[:, :4], mesh.boundaries["skin"][:, :3]).sum(axis=1) == 3
    centre = mesh.points[mesh.cells[on_skin, :4]].mean(axis=1)
    high = centre[:, 2] > 30.0  # away from the rim, where skin and chest wall meet
    radial = centre[high] / np.linalg.norm(centre[high], axis=1)[:, None]
    # A face of 15 mm on a ball of 60 mm leans by up to 15 / 2 / 60 = 0.13 rad.
    assert np.sum(directions[on_skin][high] * radial, axis=1).min() > np.cos(0.15)


def test_springs_join_the_skin_to_the_nearest_deep_point_no_closer_than_asked(slab):
    pairs = ligament_pairs(slab, spacing_mm=15.0)
    along = slab.points[pairs[:, 1]] - slab.points[pairs[:, 0]]
    assert along == pytest.approx(np.tile([0.0, 0.0, 16.0], (len(pairs), 1)))
    ends = slab.points[pairs[:, 1]]
    apart = np.linalg.norm(ends[:, None] - ends, axis=2)[np.triu_indices(len(ends), 1)]
    assert apart.min() > 15.0
    assert len(ligament_pairs(slab, spacing_mm=5.0)) == 9


def test_ligaments_and_fascia_hold_the_skin_back(slab):
    weight = Weight.of(slab, TISSUES, np.array([1.0, 0.0, 0.0]))
    pairs = ligament_pairs(slab, spacing_mm=15.0)
    with_fascia = replace(slab, boundaries={**slab.boundaries, "fascia": faces_between(slab, Label.MUSCLE)})
    added = {
        "nothing": (),
        "fibres": (Fibres.of(slab, ligament_directions(slab), stiffness_kpa=0.5),),
        "springs": (Springs.between(slab.points, pairs, youngs_modulus_kpa=100.0, section_mm2=0.5),),
        "fascia": (Fascia(120.0, 0.45, 0.1).on(with_fascia),),
    }
    bulk = body_effects(slab, TISSUES)
    least = {name: equilibrium(slab, (*bulk, *more), loads=(weight,)).energy for name, more in added.items()}
    assert all(least["nothing"] < least[name] < 0 for name in ("fibres", "springs", "fascia"))


def test_ligaments_need_ends_and_a_spacing(slab):
    with pytest.raises(MechanicsError, match="spacing_mm = 0"):
        ligament_pairs(slab, spacing_mm=0.0)
    with pytest.raises(MechanicsError, match="no boundary 'skin'"):
        ligament_directions(replace(slab, boundaries={"posterior": slab.boundaries["posterior"]}))
