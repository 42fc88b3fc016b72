"""Paddles by description: shapes have exact derivatives, and their limits are the plates known before."""

from dataclasses import replace

import numpy as np
import pytest
from mechanics_bodies import box
from mechanics_derivatives import assert_derives_from_its_energy

from mammosim.core.errors import ConfigurationError, MechanicsError
from mammosim.core.labels import Label
from mammosim.core.rng import generator
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import body_effects
from mammosim.mechanics.compression import PressSettings, compress
from mammosim.mechanics.described import Described, Size, Sloped
from mammosim.mechanics.effects import (
    SIX_POINTS,
    Cushion,
    RigidPlate,
    RoundedBox,
)
from mammosim.mechanics.flexible import Flexible
from mammosim.mechanics.paddles import Friction, Plates, Rigid, Tilting
from mammosim.mechanics.plate_shapes import Curved, FromFunction, Function
from mammosim.mechanics.reference import faces_of
from mammosim.mechanics.stage import Force, Thickness

TISSUES = {Label.ADIPOSE: Tissue(5.0, 0.45, 1.0)}
# The first axis, from the chest outward, is z; the plates press along y.
AXES = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).T
FLAT = Plates(np.array([15.0, 12.0, 42.0]), AXES, np.array([32.0, 32.0, 8.0]), 6.0)
DOME = Curved(outward_radius_mm=90.0, across_radius_mm=60.0)
WAVE = FromFunction(lambda outward, across: 2 * np.sin(outward / 15) * np.cos(across / 20) - 1.0)
SHAPES = {
    "dome": (DOME,),
    "hollow": (Curved(across_radius_mm=-70.0),),
    "wave": (WAVE,),
    "both": (DOME, Function("across * outward / 200")),
}


def plates(**parts):
    return replace(FLAT, paddle=Described(**parts))


def pressed(between, to=20.0, **settings):
    """A block 24 mm high between plates, to 20 mm."""
    mesh = box((3, 2, 3), (30.0, 24.0, 30.0))
    effects = body_effects(mesh, TISSUES)
    control = Thickness(to) if isinstance(to, float) else to
    return compress(mesh, effects, plates=between, control=control, settings=PressSettings(**settings))


@pytest.fixture(scope="module")
def flat():
    return pressed(FLAT)


@pytest.fixture(scope="module")
def domed():
    return pressed(replace(plates(shapes=(DOME,)), support=Described(Rigid(), Sloped(2.0))))


@pytest.mark.parametrize("shapes", SHAPES.values(), ids=SHAPES)
def test_a_shape_has_the_derivatives_of_its_height(shapes):
    y, h = generator("places").uniform(-30.0, 30.0, (200, 2)), 1e-4
    w = replace(FLAT, paddle=Described(shapes=shapes)).at(20.0)[0].deflection
    _, slope, second = w.at(y)
    for k, e in enumerate(h * np.eye(2)):
        (ahead, slope_ahead, _), (behind, slope_behind, _) = w.at(y + e), w.at(y - e)
        # Rounding 1e-16 * 10 mm / h, truncation h^2.
        assert slope[:, k] == pytest.approx((ahead - behind) / (2 * h), abs=1e-9)
        assert second[:, k] == pytest.approx((slope_ahead - slope_behind) / (2 * h), abs=1e-9)


@pytest.mark.parametrize("shapes", SHAPES.values(), ids=SHAPES)
@pytest.mark.parametrize("yields", [Rigid(), Tilting(2e3), Flexible(2400.0, 1.0, modes=3)])
@pytest.mark.parametrize("cushion", [None, Cushion(4.0, 30.0)])
def test_contact_with_a_shaped_plate_derives_from_its_energy(shapes, yields, cushion):
    mesh = box((2, 2, 2), (30.0, 24.0, 30.0))
    paddle = Described(yields, Sloped(4.0), shapes)
    q = 0.02 * np.arange(1.0, 1.0 + paddle.unknowns)
    face = replace(FLAT, paddle=paddle).at(14.0, q)[0]
    faces = faces_of(mesh, "skin")
    areas = SIX_POINTS.areas(mesh.points, faces)
    contact = RigidPlate(faces, areas, face, 30.0, cushion=cushion)
    assert contact.state(mesh.points).area > 0
    assert_derives_from_its_energy(contact, mesh.points + 0.0123)


def test_the_spline_of_a_function_is_the_function():
    y = generator("places").uniform(-32.0, 32.0, (300, 2))
    (shape,) = SHAPES["wave"]
    found = shape.over((32.0, 32.0), 6.0).at(y)[0]
    # Of fourth order: (2 mm / 15 mm)^4 times 2 mm over 384, and what the mirrored ends leave.
    assert found == pytest.approx(shape.rise_mm(y[:, 0] + 32.0, y[:, 1]), abs=1e-3)


def test_a_described_plate_without_parts_is_the_flat_one_to_the_last_digit(flat):
    nothing = replace(plates(), support=Described(Rigid(), Sloped(0.0)))
    found = pressed(replace(nothing, paddle=Described(slope=Sloped(0.0), size=Size(width_mm=64.0))))
    np.testing.assert_array_equal(found.points, flat.points)
    columns = flat.path.columns.drop("seconds")
    np.testing.assert_array_equal(found.path[columns], flat.path[columns])


def test_a_face_of_height_nothing_is_flat_to_the_last_digit(flat):
    found = pressed(replace(plates(shapes=(Function("0 * across"),))))
    np.testing.assert_array_equal(found.points, flat.points)


def test_an_arc_of_large_radius_is_flat(flat):
    """At 15 mm from the middle it rises by 225 / 2 r: 1e-4 mm, of 4 mm of compression."""
    found = pressed(plates(shapes=(Curved(across_radius_mm=1e6),)))
    assert found.path.force_n.iloc[-1] == pytest.approx(flat.path.force_n.iloc[-1], rel=1e-4)
    assert np.abs(found.points - flat.points).max() < 2e-4


@pytest.mark.parametrize("hinge", [-0.4, 0.0, 1.0])
def test_a_sloped_plate_is_a_tilting_one_that_stands_at_that_angle(hinge):
    sloped = replace(FLAT, paddle=Described(slope=Sloped(3.0, hinge)))
    tilting = replace(FLAT, paddle=Tilting(1.0, hinge))
    q = np.array([np.radians(3.0)])
    x = FLAT.centre + generator("points").uniform(-25.0, 25.0, (400, 3))
    one, other = sloped.at(20.0)[0], tilting.at(20.0, q)[0]
    np.testing.assert_array_equal(one.distance(x), other.distance(x))
    np.testing.assert_array_equal(one.normal(x), other.normal(x))
    inside = sloped.gap(x, 20.0, np.zeros(0))
    assert inside == pytest.approx(tilting.gap(x, 20.0, q), abs=1e-9)
    assert sloped.paddle.tilt_deg(np.zeros(0)) == pytest.approx(tilting.paddle.tilt_deg(q))


def test_the_slope_of_a_tilting_plate_is_added_to_its_angle():
    both = replace(FLAT, paddle=Described(Tilting(1.0, 0.3), Sloped(2.0, 0.3)))
    once = replace(FLAT, paddle=Tilting(1.0, 0.3))
    x = FLAT.centre + generator("points").uniform(-25.0, 25.0, (100, 3))
    found = both.at(20.0, np.radians([1.0]))[0].distance(x)
    assert found == pytest.approx(once.at(20.0, np.radians([3.0]))[0].distance(x), abs=1e-12)


def test_a_support_is_described_as_a_paddle_is_and_faces_it():
    """Seen from the middle, paddle and support of one description are mirror images."""
    parts = Described(Rigid(), Sloped(3.0), (DOME, Function("outward * across / 300")))
    both = replace(FLAT, paddle=parts, support=parts)
    y = generator("points").uniform(-25.0, 25.0, (200, 3))
    above, below = (FLAT.centre + (y * [1, 1, side]) @ AXES.T for side in (1, -1))
    paddle, support = both.at(20.0)
    assert paddle.distance(above) == pytest.approx(support.distance(below), abs=1e-12)


@pytest.mark.parametrize("shapes", SHAPES.values(), ids=SHAPES)
def test_the_gap_is_the_distance_between_the_faces_along_a_ray(shapes):
    q = np.array([0.03])
    between = replace(
        FLAT,
        paddle=Described(Tilting(1e3), Sloped(3.0), shapes),
        support=Described(shapes=(Curved(outward_radius_mm=80.0),)),
    )
    across = generator("rays").uniform(-24.0, 24.0, (50, 2))
    ray = FLAT.centre + across @ AXES[:, :2].T
    gap = between.gap(ray, 20.0, q)
    _, (up, down) = between._rises(ray, q)
    paddle, support = between.at(20.0, q)
    on_paddle, on_support = (ray + side[:, None] * AXES[:, 2] for side in (10.0 + up, -10.0 - down))
    assert paddle.distance(on_paddle) == pytest.approx(0.0, abs=1e-9)
    assert support.distance(on_support) == pytest.approx(0.0, abs=1e-9)
    assert gap == pytest.approx((on_paddle - on_support) @ AXES[:, 2], abs=1e-12)


def test_beside_a_small_paddle_there_is_no_gap_and_the_skin_is_what_is_as_high():
    small = plates(size=Size(width_mm=30.0, depth_mm=24.0, edge_radius_mm=3.0, across_mm=5.0))
    y = np.array([[-20.0, 5.0, 10.0], [-7.0, 5.0, 10.0], [-31.0, 19.0, 10.0], [-31.0, 21.0, 13.0]])
    gap = small.gap(FLAT.centre + y @ AXES.T, 20.0, np.zeros(0))
    assert gap[[0, 2]].tolist() == [20.0, 20.0]  # from the chest edge at -32 mm to 24 mm behind it
    assert np.isnan(gap[[1, 3]]).all()
    assert small.room(FLAT.centre + y @ AXES.T, 20.0, np.zeros(0)) == (3.0, 0.0)
    assert (small.middle - FLAT.centre) @ AXES == pytest.approx([-20.0, 5.0, 0.0])
    face = small.at(20.0)[0]
    assert face.half_sizes.tolist() == [12.0, 15.0, 8.0]
    assert face.radius == 3.0


def test_the_work_of_shaped_plates_is_stored(domed):
    """Trapezoids of steps of an eighth of the way, whose contact grows from a point: 5 %."""
    path = domed.path
    assert path.work_uj.iloc[-1] == pytest.approx(path.energy_uj.iloc[-1], rel=0.05)
    carried = path.support_force_n + path.chest_force_n
    assert carried.to_numpy() == pytest.approx(path.force_n.to_numpy(), abs=1e-6)


def test_the_deflection_of_shaped_plates_is_that_from_flat_ones():
    """An arc of 60 mm rises by 60 - sqrt(60^2 - 32^2) mm at 32 mm, one of 90 mm by 5.88 mm."""
    rest = np.zeros(0)
    arcs = 60 - np.sqrt(60**2 - 32**2) + 90 - np.sqrt(90**2 - 32**2)
    assert plates(shapes=(DOME,)).deflection_mm(rest) == pytest.approx(arcs)
    below = replace(FLAT, support=Described(slope=Sloped(4.0)))
    assert below.deflection_mm(rest) == pytest.approx(32 * np.tan(np.radians(4.0)))
    assert FLAT.deflection_mm(rest) == 0.0


def test_the_pressures_on_a_shaped_plate_add_up_to_its_force(domed):
    contact, state = domed.plates[0], domed.contacts[0]
    y, _ = contact.at_points(domed.points)
    n = contact.obstacle.normal(y.reshape(-1, 3)).reshape(y.shape)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    deformed = contact.rule.areas(domed.points, contact.faces)
    force = -np.einsum("eq,eqi->i", state.pressure * deformed, n)
    assert force == pytest.approx(state.force, rel=1e-9)


WEDGE = replace(plates(slope=Sloped(25.0)), support=Described(slope=Sloped(25.0)))
# Cushions: 8 mm of 30 kPa under a block of 5 kPa.
SOFT = Cushion(8.0, 30.0, 0.3)


def test_a_cushion_is_a_confined_layer_in_series_with_the_contact():
    """M = 30 * 0.7 / (1.3 * 0.4) kPa."""
    assert SOFT.mm_per_kpa == pytest.approx(8.0 * 1.3 * 0.4 / (30.0 * 0.7))
    mesh = box((1, 1, 1), (10.0, 10.0, 10.0))
    faces = faces_of(mesh, "skin")
    top = RoundedBox(np.array([5.0, 5.0, 15.0]), np.eye(3), np.array([40.0, 40.0, 6.0]), 2.0)
    plate = RigidPlate(faces, SIX_POINTS.areas(mesh.points, faces), top, 50.0, cushion=SOFT)
    state, depth = plate.state(mesh.points), 1.0
    p = depth / (1 / 50.0 + SOFT.mm_per_kpa)
    assert state.pressure.max() == pytest.approx(p)
    assert state.penetration == pytest.approx(p / 50.0)
    y, yielded = plate.indentation(mesh.points)
    assert np.abs(yielded[y[:, 2] > 9.99] - p * SOFT.mm_per_kpa).max() < 1e-9
    assert state.penetration + yielded.max() == pytest.approx(depth)


def test_a_cushion_that_is_stiff_is_none(flat):
    stiff = pressed(replace(FLAT, cushions=(Cushion(1.0, 1e9), Cushion(1.0, 1e9))))
    assert np.abs(stiff.points - flat.points).max() < 1e-6
    assert stiff.path.force_n.iloc[-1] == pytest.approx(flat.path.force_n.iloc[-1], rel=1e-6)


def test_a_cushion_yields_is_counted_in_thickness_and_stores_its_work(flat):
    found = pressed(replace(FLAT, cushions=(SOFT, None)))
    path = found.path
    assert path.force_n.iloc[-1] < 0.95 * flat.path.force_n.iloc[-1]
    assert path.work_uj.iloc[-1] == pytest.approx(path.energy_uj.iloc[-1], rel=0.02)
    assert found.stages[-1].gap_error <= 0.02
    under = FLAT.centre + np.array([[-25.0, 0.0, 10.0]]) @ AXES.T
    assert found.gap(under)[0] > 20.2
    # Beside the block nothing presses on the cushion.
    assert found.gap(FLAT.centre + np.array([[20.0, 0.0, 10.0]]) @ AXES.T)[0] == 20.0
    room = found.room(found.points[np.unique(found.plates[0].faces)])
    assert room[0] > 0.2
    assert room[1] == 0.0


def test_a_shaped_cushioned_paddle_on_a_hinge_holds_a_force_and_yields_as_its_spring():
    parts = Described(Tilting(2e3), Sloped(2.0), (Curved(across_radius_mm=150.0),))
    found = pressed(replace(FLAT, paddle=parts, cushions=(SOFT, None)), Force(0.3, smallest_mm=16.0), steps=3)
    last = found.path.iloc[-1]
    assert last.force_n == pytest.approx(0.3, rel=1e-3)
    # It opens at the chest, where the block is: by no more than the force at the chest edge would turn it.
    assert 2.0 < last.tilt_deg < 2.0 + np.degrees(0.3 * 32.0 / 2e3)


def test_friction_on_a_cushion_is_of_its_own_normal_force():
    found = pressed(replace(FLAT, cushions=(SOFT, SOFT), friction=Friction(0.3)))
    contact = found.plates[0]
    state = found.stages[-1].friction_states[0].lagged(contact, found.points)
    assert state.load.sum() * contact.cushion.mm_per_kpa == pytest.approx(
        np.sum(contact.areas[contact.pressures(found.points)[1] > 0] * contact.indentation(found.points)[1])
    )


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (lambda: Sloped(40.0), r"a slope of 40 degrees \(at most 30\)"),
        (lambda: Curved(), "give one of them or both"),
        (lambda: Curved(0.0, 100.0), "give one of them or both"),
        (lambda: Size(width_mm=-1.0), "above 0"),
        (lambda: Cushion(5.0, 30.0, 0.5), r"a cushion of 5 mm, 30 kPa, nu 0\.5"),
        (lambda: replace(FLAT, support=Tilting(1.0)), "a support does not yield"),
        (lambda: Function("across.real"), "is not understood; a formula has outward, across"),
    ],
)
def test_what_cannot_be_meant_is_rejected(wrong, words):
    with pytest.raises((MechanicsError, ConfigurationError), match=words):
        wrong()


@pytest.mark.parametrize(
    ("between", "words"),
    [
        (plates(shapes=(Curved(across_radius_mm=40.0),)), "come back on itself: a plate of 64 mm asks"),
        (WEDGE, r"the paddle meets the support: at 20\.0 mm"),
        (plates(shapes=(Function("-22 + 0.02 * across**2"),)), "the paddle meets the support"),
        (plates(shapes=(Function("2 * abs(across)"),)), r"the paddle's face is as steep as [67]\d degrees"),
        (plates(shapes=(Function("1 / (across - across)"),)), "rise_mm has no finite value -10 mm outward"),
        (plates(size=Size(width_mm=80.0)), "a plate of width 80 .* does not lie within 64 x 64 mm"),
        (plates(size=Size(width_mm=8.0)), "edge radius 6 mm must be in"),
        (
            replace(
                plates(size=Size(width_mm=20.0, across_mm=-20.0, edge_radius_mm=2.0)),
                support=Described(size=Size(width_mm=20.0, across_mm=20.0, edge_radius_mm=2.0)),
            ),
            "paddle and support lie beside each other",
        ),
    ],
)  # fmt: skip
def test_plates_that_cannot_be_are_rejected_before_anything_is_solved(between, words):
    with pytest.raises(MechanicsError, match=words):
        pressed(between)


def test_a_cushion_that_is_pressed_through_is_rejected():
    with pytest.raises(
        MechanicsError, match=r"a cushion of 1 mm is pressed by \d\.\d mm, through to its plate"
    ):
        pressed(replace(FLAT, cushions=(Cushion(1.0, 0.5), None)), 20.0)
