"""Hard cases of compression: plates anywhere, bodies of any shape and stuff, closed forms, equal problems."""

import numpy as np
import pytest

from mammosim.core.errors import ConfigurationError
from mammosim.core.labels import Label
from mammosim.core.settings import read
from mammosim.meshing.quality import quality
from mammosim.study.hard_cases.bodies import Ball, Brick, Lump, Slot, Staircase, middles_of
from mammosim.study.hard_cases.cases import relative_error
from mammosim.study.hard_cases.invariance import INVARIANCE_TESTS, changed
from mammosim.study.hard_cases.materials import Scatter, TissueValues, tissues_of
from mammosim.study.hard_cases.overlap import faces_inside
from mammosim.study.hard_cases.presses import PressValues
from mammosim.study.hard_cases.problems import ProblemSettings
from mammosim.study.hard_cases.quantities import QUANTITIES
from mammosim.study.hard_cases.references import (
    ConfinedBlock,
    FreeBlock,
    Hertz,
    Part,
    nominal_stresses,
)

SIDE = 20.0
FAT = {"youngs_modulus_kpa": 2.0, "poisson_ratio": 0.45, "density_g_cm3": 1.0}
BRICK = {"shape": "brick", "counts": [2, 2, 2], "size_mm": [SIDE, SIDE, SIDE]}
PRESS = {"edge_radius_mm": 5.0, "chest_edge_mm": -50.0, "offset_mm": [SIDE / 2, SIDE / 2]}
BLOCK = {
    "body": BRICK,
    "tissues": {"adipose": FAT},
    "held": "free_sides",
    "press": {**PRESS, "thickness_mm": 14.0, "steps": 2},
}
# Of a body held all over its base, which is nowhere homogeneous.
LEANING = {
    "body": {**BRICK, "leaning": [0.2, 0.0]},
    "tissues": {"adipose": FAT},
    "scatter": {"seed": 1, "sigma": 0.5},
    "press": {**PRESS, "chest_edge_mm": 8.0, "thickness_mm": 16.0, "turned_degrees": [0, 0, 15], "steps": 2},
}
CHANGES = {
    "turned": {"degrees": [20, 40, -70]},
    "mirrored": {"across": "y"},
    "shifted": {"mm": [100, 0, -50]},
    "scaled": {"length": 3.0, "stiffness": 7.0},
    "renumbered": {"seed": 3},
    "pressed_in": {"steps": 4},
    "by_its_force": {},
}


def problem_of(values):
    return read(ProblemSettings, values, "problem").problem()


def part(**changes):
    values = {"area_mm2": SIDE**2, "youngs_modulus_kpa": 2.0, "poisson_ratio": 0.45} | changes
    return Part(**values)


def stresses(tissue, stretches):
    """Of W by central differences, for nominal_stresses."""
    mu, k = tissue.shear_modulus_kpa, tissue.bulk_modulus_kpa

    def W(stretches):
        J = np.prod(stretches)
        return mu / 2 * (J ** (-2 / 3) * np.sum(stretches**2) - 3) + k / 2 * (J - 1) ** 2

    h = 1e-6 * np.eye(3)
    return np.array([(W(stretches + d) - W(stretches - d)) / 2e-6 for d in h])


def test_nominal_stresses_are_the_slope_of_the_energy():
    stretches = np.array([1.3, 0.6, 1.1])
    assert nominal_stresses(part().tissue(), stretches) == pytest.approx(
        stresses(part().tissue(), stretches), rel=1e-6
    )


def test_blocks_are_pressed_as_small_strain_has_it():
    """Free: F = E A e; confined: F = E (1 - nu) / ((1 + nu) (1 - 2 nu)) A e; 1 N is 1000 mN."""
    e, E, nu = 1e-5, 2.0, 0.45
    free = FreeBlock(1 - e, part())
    assert free.value() == pytest.approx(E * SIDE**2 * e / 1000, rel=1e-3)
    assert FreeBlock(1 - e, part(), width_mm=SIDE).value() == pytest.approx(nu * e * SIDE, rel=1e-3)
    confined = ConfinedBlock(1 - e, (part(), part()))
    modulus = E * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    assert confined.value() == pytest.approx(2 * modulus * SIDE**2 * e / 1000, rel=1e-3)


def test_hertz_in_its_three_numbers():
    """F = 4/3 E* R^(1/2) d^(3/2) and A = pi R d; E* = 4/3 for E = 1, nu = 1/2."""
    values = {"radius_mm": 4.0, "depth_mm": 1.0, "youngs_modulus_kpa": 1.0, "poisson_ratio": 0.5}
    force, area, pressure = (
        Hertz(of=name, **values).value() for name in ("force_n", "contact_area_mm2", "pressure_kpa")
    )
    assert force == pytest.approx(32 / 9 / 1000)
    assert area == pytest.approx(4 * np.pi)
    assert pressure == pytest.approx(1000 * force / area)
    quarter = Hertz(of="force_n", modelled=0.25, **values)
    assert quarter.value() == pytest.approx(force / 4)


@pytest.fixture(scope="module")
def block():
    return problem_of(BLOCK).solution()


def test_a_block_has_force_area_pressure_and_widening_of_its_closed_form(block):
    """But for skin at most 0.1 mm inside each plate, a stretch off by 0.01, with slopes of 4.8 and 3.4."""
    force = FreeBlock(0.7, part()).value()
    widening = FreeBlock(0.7, part(), width_mm=SIDE).value()
    assert QUANTITIES["force_n"](block) == pytest.approx(force, rel=0.048)
    assert QUANTITIES["width_mm"](block) == pytest.approx(widening, rel=0.034)
    area = (SIDE + widening) ** 2
    assert QUANTITIES["contact_area_mm2"](block) == pytest.approx(area, rel=0.01)
    assert QUANTITIES["pressure_kpa"](block) == pytest.approx(1000 * force / area, rel=0.05)
    assert QUANTITIES["height_mm"](block) == pytest.approx(widening, rel=0.034)


def test_a_quantity_of_plates_needs_plates():
    alone = {"body": BRICK, "tissues": {"adipose": FAT}, "gravity": [0, 0, 1]}
    with pytest.raises(ConfigurationError, match="needs plates; add press"):
        QUANTITIES["force_n"](problem_of(alone).solution())


@pytest.fixture(scope="module")
def leaning():
    return problem_of(LEANING).solution()


@pytest.mark.parametrize("name", CHANGES)
def test_a_press_seen_otherwise_has_the_same_shape(leaning, name):
    """To its force it goes with a tolerance of 1e-4, and in other steps the penalty may differ."""
    other = changed(leaning.problem, [INVARIANCE_TESTS.kinds[name](**CHANGES[name])]).shape()
    within = 0.01 if name in ("pressed_in", "by_its_force") else 1e-6
    assert np.abs(other - leaning.x).max() <= within * np.abs(leaning.displacements).max()


@pytest.mark.parametrize("name", ["pressed_in", "by_its_force"])
def test_what_changes_a_press_needs_one(name):
    alone = problem_of({"body": BRICK, "tissues": {"adipose": FAT}, "gravity": [0, 0, 1]})
    with pytest.raises(ConfigurationError, match="add press"):
        changed(alone, [INVARIANCE_TESTS.kinds[name](**CHANGES[name])])


def test_a_paddle_that_bends_is_not_scaled():
    flexible = {"flexible": {"thickness_mm": 2.5, "youngs_modulus_mpa": 2300}}
    problem = problem_of({**LEANING, "press": {**LEANING["press"], "paddle": flexible}})
    with pytest.raises(ConfigurationError, match="that bends is not scaled"):
        changed(problem, [INVARIANCE_TESTS.kinds["scaled"](length=2.0, stiffness=1.0)])


def test_every_change_is_tried():
    """Those of the loads in test_study_hard_cases.py, those of presses here."""
    assert set(INVARIANCE_TESTS.kinds) - set(CHANGES) == {"stepwise", "by_way_of"}


def test_plates_stand_where_they_are_told():
    """Turned about z by 90 degrees they press along x; about x by 30 they look out by that much."""
    values = {"edge_radius_mm": 5.0, "chest_edge_mm": 10.0, "thickness_mm": 20.0, "half_depth_mm": 30.0}
    plates = PressValues(**values, offset_mm=(3.0, -4.0), turned_degrees=(0.0, 0.0, 90.0)).setup().plates
    assert plates.centre == pytest.approx([3, -4, 40])
    assert np.abs(plates.axes[:, 2]) == pytest.approx([1, 0, 0])
    assert plates.axes[:, 0] == pytest.approx([0, 0, 1])
    assert np.linalg.det(plates.axes) == pytest.approx(1)
    tilted = PressValues(**values, turned_degrees=(30.0, 0.0, 0.0)).setup().plates
    assert tilted.axes[:, 2] @ [0, 1, 0] == pytest.approx(np.cos(np.pi / 6))


def test_a_body_leans_with_its_height_and_keeps_its_volume():
    upright, leaning = Brick(**_brick()).mesh(), Brick(**_brick(), leaning=(0.5, -0.2)).mesh()
    assert leaning.points - upright.points == pytest.approx(upright.points[:, 2:] * [0.5, -0.2, 0])
    assert quality(leaning).volume_mm3.sum() == pytest.approx(SIDE**3)


def test_muscle_lies_below_and_lumps_in_their_balls():
    lumps = (Lump((15.0, 15.0, 15.0), 9.0),)
    mesh = Brick(**_brick(), muscle_mm=10.0, lumps=lumps).mesh()
    middles = middles_of(mesh)
    assert np.array_equal(mesh.tissue == Label.LESION, lumps[0].holds(middles))
    assert np.array_equal(mesh.tissue == Label.MUSCLE, (middles[:, 2] < 10) & ~lumps[0].holds(middles))
    assert set(mesh.tissue) == {Label.LESION, Label.MUSCLE, Label.ADIPOSE}


def _brick():
    return {"counts": (4, 4, 4), "size_mm": (SIDE, SIDE, SIDE)}


@pytest.mark.parametrize(
    ("carved", "bricks"), [(Slot((5.0, 0.0, 5.0), (15.0, 20.0, 20.0)), 64 - 2 * 4 * 3), (Staircase(), 32)]
)
def test_what_is_carved_is_whole_bricks_with_a_closed_skin(carved, bricks):
    """The areas of a closed surface, with their normals, sum to zero."""
    mesh = Brick(**_brick(), carved=carved).mesh()
    assert quality(mesh).volume_mm3.sum() == pytest.approx(bricks * 5.0**3)
    faces = np.vstack(list(mesh.boundaries.values()))
    a, b, c = mesh.points[faces[:, :3]].transpose(1, 0, 2)
    assert np.cross(b - a, c - a).sum(axis=0) == pytest.approx(0, abs=1e-9)
    assert np.allclose(mesh.points[mesh.boundaries["posterior"]][..., 2], 0)
    with pytest.raises(ConfigurationError, match="finer bricks carve another body"):
        Brick(**_brick(), carved=carved).refined(2.0)


def test_refined_bodies_have_smaller_elements_of_the_same_volume():
    assert Brick(**_brick()).refined(3.0).counts == (7, 7, 7)
    assert Ball(radius_mm=60, edge_mm=20).refined(10).edge_mm == 10


def test_moduli_at_random_have_their_spread_and_their_correlation():
    mesh = Brick(counts=(8, 8, 8), size_mm=(80.0, 80.0, 80.0)).mesh()
    z = np.log(Scatter(seed=1, sigma=0.7).factors(mesh))
    assert (z.mean(), z.std()) == pytest.approx((0, 0.7), abs=4 * 0.7 / np.sqrt(len(z)))
    smooth = np.log(Scatter(seed=1, sigma=0.7, correlation_mm=400.0).factors(mesh))
    assert smooth.std() < 0.2, "over a fifth of its length a field hardly varies"
    assert np.array_equal(z, np.log(Scatter(seed=1, sigma=0.7).factors(mesh)))
    assert not np.array_equal(z, np.log(Scatter(seed=2, sigma=0.7).factors(mesh)))


def test_a_field_of_moduli_depends_on_the_place_alone():
    scatter = Scatter(seed=3, sigma=1.0, correlation_mm=10.0)
    mesh = Brick(**_brick()).mesh()
    values = {"adipose": TissueValues(**FAT)}
    whole = tissues_of(mesh, values, scatter).youngs_modulus_kpa
    other = Brick(**_brick(), carved=Slot((0.0, 0.0, 0.0), (10.0, 20.0, 20.0))).mesh()
    half = tissues_of(other, values, scatter).youngs_modulus_kpa
    at = {tuple(np.round(place, 6)): E for place, E in zip(middles_of(mesh), whole)}
    assert half == pytest.approx([at[tuple(np.round(place, 6))] for place in middles_of(other)])


def test_faces_that_lie_in_other_cells_are_found_and_others_are_not():
    """Two prongs 5 mm apart, one moved into the other."""
    slot = Slot((5.0, 0.0, 5.0), (10.0, 20.0, 20.0))
    mesh = Brick(**_brick(), carved=slot).mesh()
    assert len(faces_inside(mesh, mesh.points)) == 0
    prong = (mesh.points[:, 0] < 5.1) & (mesh.points[:, 2] > 5.1)
    moved = mesh.points + np.where(prong, 4.0, 0.0)[:, None] * [1.0, 0.0, 0.0]
    assert len(faces_inside(mesh, moved)) == 0
    through = mesh.points + np.where(prong, 8.0, 0.0)[:, None] * [1.0, 0.0, 0.0]
    assert len(faces_inside(mesh, through)) > 0


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"body": {**BRICK, "carved": {"slots": {}}}}, r"carved\.slots: 'slots' is unknown; choose one of"),
        ({"body": {**BRICK, "leaning": [1]}}, r"leaning has 1 values; write 2"),
        ({"body": {**BRICK, "lumps": [{"centre_mm": [0, 0, 0]}]}}, r"lumps\[0\] lacks radius_mm; add it"),
        ({"scatter": {"seed": 1, "sigma": 0}}, r"scatter\.sigma = 0 is outside \(0"),
        ({"scatter": {"seed": 1, "sigma": 1, "correlation": 5}}, "did you mean 'correlation_mm'"),
        ({"press": {**PRESS, "thickness_mm": 10, "turned_degrees": [1]}}, r"turned_degrees has 1 values"),
        ({"press": {**PRESS, "thickness_mm": 10, "steps": 0}}, r"press\.steps = 0 is outside"),
        ({"held": "posterior_along_w"}, "choose one of: posterior"),
    ],
)
def test_what_cannot_be_meant_is_rejected_with_its_key(changes, message):
    with pytest.raises(ConfigurationError, match=message):
        read(ProblemSettings, BLOCK | changes, "problem")


def test_a_force_in_place_of_none_is_wrong_without_bound():
    """The plates have lost the body: its reference is zero."""
    assert relative_error(0.1, 0.0) == np.inf
    assert relative_error(0.9, 1.0) == pytest.approx(0.1)
