"""Paddles that tilt and bend are in balance, lie where they say, and bend as plate theory has it."""

import numpy as np
import pytest
from mechanics_bodies import box

from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.core.units import MN_PER_N
from mammosim.mechanics.body import body_effects
from mammosim.mechanics.compression import compress
from mammosim.mechanics.flexible import Flexible, PlateModes
from mammosim.mechanics.paddles import Friction, Plates, Rigid, Tilting
from mammosim.mechanics.press import PADDLE_TOLERANCE
from mammosim.mechanics.stage import Thickness

TISSUES = {Label.ADIPOSE: Tissue(5.0, 0.45, 1.0)}
# The first axis, from the chest outward, is z; the plates press along y.
AXES = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).T
TILTING, FLEXIBLE = Tilting(2e3, hinge=-0.4), Flexible(2400.0, 1.0, modes=3)


def pressed(paddle):
    """A block beside the middle of its plates, 24 mm high, to 20 mm."""
    mesh = box((3, 2, 3), (30.0, 24.0, 30.0))
    plates = Plates(np.array([18.0, 12.0, 42.0]), AXES, np.array([32.0, 32.0, 8.0]), 6.0, paddle)
    effects = body_effects(mesh, TISSUES)
    return compress(mesh, effects, plates=plates, control=Thickness(20.0))


@pytest.fixture(scope="module")
def tilted():
    return pressed(TILTING)


@pytest.fixture(scope="module")
def bent():
    return pressed(FLEXIBLE)


def pressing(found):
    """Where the skin presses on the paddle (n, 3), and the forces there on the paddle (n, 3), mN."""
    contact = found.plates[0]
    y, p = contact.pressures(found.points)
    y, load = y[p > 0], (contact.areas * p)[p > 0]
    return y, -load[:, None] * contact.obstacle.normal(y)


def test_the_moment_of_the_contact_is_that_of_the_hinge(tilted):
    stage, plates = tilted.stages[-1], tilted.between
    face = plates.centre + stage.thickness / 2 * plates.axes[:, 2]
    hinge = face + TILTING.hinge * plates.half_sizes[0] * plates.axes[:, 0]
    y, forces = pressing(tilted)
    moment = np.cross(y - hinge, forces).sum(axis=0) @ plates.axes[:, 1]
    spring = MN_PER_N * TILTING.stiffness_n_mm_per_rad * stage.q[0]
    assert spring > 0  # the block lies at the chest edge, so that the paddle opens there
    levers = np.linalg.norm(forces.sum(axis=0)) * plates.half_sizes[0] * 1.4
    assert moment == pytest.approx(spring, abs=2 * PADDLE_TOLERANCE * levers)


def test_the_pressure_on_each_mode_is_that_of_the_bent_plate(bent):
    stage, plates = bent.stages[-1], bent.between
    y, forces = pressing(bent)
    modes = FLEXIBLE._modes(plates.half_sizes)
    w, _, _ = modes.at(((y - plates.centre) @ plates.axes)[:, :2])
    along = forces @ plates.axes[:, 2]
    scale = np.abs(along).sum()
    assert w.T @ along == pytest.approx(modes.stiffness * stage.q, abs=2 * PADDLE_TOLERANCE * scale)
    assert bent.path["deflection_mm"].iloc[-1] > 0.1


@pytest.mark.parametrize("paddle", ["tilted", "bent"])
def test_the_gap_is_the_distance_between_the_faces(paddle, request):
    found = request.getfixturevalue(paddle)
    plates = found.between
    across = np.array([[-20.0, -15.0], [0.0, 0.0], [22.0, 11.0]])
    on_support = plates.centre + np.column_stack([across, [-found.stages[-1].thickness / 2] * 3]) @ AXES.T
    gap = found.gap(on_support)
    assert np.ptp(gap) > 0.01
    on_paddle = on_support + gap[:, None] * plates.axes[:, 2]
    assert found.plates[0].obstacle.distance(on_paddle) == pytest.approx(0.0, abs=1e-9)
    assert np.isnan(found.gap(plates.centre[None] + 40.0 * AXES[:, 0])).all()


@pytest.mark.parametrize("paddle", ["tilted", "bent"])
def test_the_work_of_the_plates_is_stored_in_body_and_paddle(paddle, request):
    """Trapezoids of steps of an eighth of the way are off by half the square of that, and by their kinks."""
    path = request.getfixturevalue(paddle).path
    assert path["work_uj"].iloc[-1] == pytest.approx(path["energy_uj"].iloc[-1], rel=0.02)
    carried = path["support_force_n"] + path["chest_force_n"]
    assert carried.to_numpy() == pytest.approx(path["force_n"].to_numpy(), abs=1e-6)


def test_a_paddle_that_hardly_yields_is_a_rigid_one():
    rigid, stiff = (pressed(paddle).path["force_n"].iloc[-1] for paddle in (Rigid(), Tilting(1e8)))
    # The tilt of a stiff hinge is moment / stiffness, some 1e-6 rad: 1e-5 of the compression.
    assert stiff == pytest.approx(rigid, rel=1e-4)


def levy(a, b, nu, terms=3):
    """w D / (q a^4) in the middle of the free edge y = b of a plate whose other edges are supported.

    w = sum of sin(alpha x) (p + A cosh + B t sinh + C sinh + E t cosh), t = alpha y, in Levy's way.
    """
    w = 0.0
    for m in range(1, 2 * terms, 2):
        alpha, p = m * np.pi / a, 4 * a**4 / (np.pi * m) ** 5
        t = alpha * b
        sh, ch = np.sinh(t), np.cosh(t)
        # At y = 0: w = 0 and w'' = 0; at y = b no moment and no shear.
        rows = [
            [1, 0, 0, 0],
            [1, 2, 0, 0],
            [(1 - nu) * ch, 2 * ch + (1 - nu) * t * sh, (1 - nu) * sh, 2 * sh + (1 - nu) * t * ch],
            [
                -(1 - nu) * sh,
                (1 + nu) * sh - (1 - nu) * t * ch,
                -(1 - nu) * ch,
                (1 + nu) * ch - (1 - nu) * t * sh,
            ],
        ]
        A, B, C, E = np.linalg.solve(np.array(rows, dtype=float), [-p, 0, nu * p, 0])
        w += (p + A * ch + B * t * sh + C * sh + E * t * ch) * np.sin(m * np.pi / 2)
    return w / a**4


def deflection(a, b, nu, count):
    """The same by the modes, under one unit of pressure."""
    modes = PlateModes.of(1.0, nu, (b / 2, a / 2), count)
    points, weights = np.polynomial.legendre.leggauss(20)
    y = np.stack(np.meshgrid(points * b / 2, points * a / 2, indexing="ij"), axis=-1).reshape(-1, 2)
    load = np.outer(weights, weights).ravel() * a * b / 4 @ modes.at(y)[0]
    at_edge = modes.at(np.array([[-b / 2, 0.0]]))[0][0]
    return at_edge @ (load / modes.stiffness) / a**4


def test_a_plate_bends_as_plate_theory_has_it():
    """Three edges supported, one free, uniform pressure: 0.01286 q a^4 / D for a square of nu 0.3."""
    assert levy(1.0, 1.0, 0.3) == pytest.approx(0.01286, abs=1e-5)
    # The next wave across, of five half waves, has 5^-5 of the first.
    assert deflection(1.0, 1.0, 0.3, 9) == pytest.approx(levy(1.0, 1.0, 0.3), rel=3e-3)
    # Along a plate longer than wide a cubic does not follow the layer at its ends.
    assert deflection(110.0, 160.0, 0.37, 9) == pytest.approx(levy(110.0, 160.0, 0.37), rel=0.02)
    # Four modes leave out the steeper ones, whose stiffness grows as the fourth power of the wave number.
    assert deflection(110.0, 160.0, 0.37, 4) == pytest.approx(levy(110.0, 160.0, 0.37), rel=0.02)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Tilting(0.0),
        lambda: Tilting(1.0, hinge=1.5),
        lambda: Flexible(0.0, 2.0),
        lambda: Flexible(2400.0, 2.0, modes=10),
        lambda: Friction(-0.1),
        lambda: Friction(0.3, slip_mm=0.0),
        lambda: Thickness(0.0),
    ],
)
def test_impossible_plates_are_rejected(wrong):
    with pytest.raises(MechanicsError):
        wrong()
