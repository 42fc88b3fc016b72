"""What every effect must satisfy: it is a potential, knows no frame, and has the same bits on any threads."""

from dataclasses import replace

import numba
import numpy as np
import pytest
from mechanics_bodies import box
from mechanics_derivatives import (
    assert_derives_from_its_energy,
    assert_rotation_stores_nothing,
    assert_symmetric_and_projectable,
    gradient,
    tangent,
)

from mammosim.core.labels import Label
from mammosim.core.rigid import rotation
from mammosim.core.rng import generator
from mammosim.core.tissues import Tissue
from mammosim.mechanics import effects
from mammosim.mechanics.body import Fascia, Skin
from mammosim.mechanics.effects import (
    SIX_POINTS,
    Attraction,
    BentBox,
    Buoyancy,
    CoulombFriction,
    EllipticCylinder,
    Fibres,
    MixedNeoHookean,
    NeoHookean,
    RigidPlate,
    RoundedBox,
    Scaled,
    Sliding,
    SmallStrain,
    SpringNetwork,
    Springs,
    Weight,
    chest_wall_contact,
)
from mammosim.mechanics.flexible import Bending, PlateModes
from mammosim.mechanics.reference import face_quadrature

TISSUES = {Label.ADIPOSE: Tissue(1.0, 0.45, 0.95)}
NEARLY_INCOMPRESSIBLE = {Label.ADIPOSE: Tissue(1.0, 0.4999, 0.95)}
TURN = rotation(np.array([30.0, -70.0, 110.0]))
# Effects of what surrounds the body: they hold it, or weigh on it, in one place and direction.
SURROUNDINGS = (
    *("weight", "part of the weight", "water", "plate", "bent plate", "friction"),
    *("chest wall", "sliding", "attraction"),
)
ELASTIC = (
    *("bulk", "nearly incompressible bulk", "network", "skin", "fascia"),
    *("fibres", "stiffening fibres", "springs"),
)
# Linear elasticity stores energy in a rotation, which is why its increments have to be small.
NAMES = (*ELASTIC, "small strain", *SURROUNDINGS)


def body(R=None):
    """A block of 10 x 12 x 9 mm, turned by R (3, 3)."""
    mesh = box((2, 2, 2), (10.0, 12.0, 9.0))
    return mesh if R is None else mesh.moved_to(mesh.points @ R.T)


def effect(name, R=None):
    """An effect of the body and its surroundings, all turned by R (3, 3)."""
    mesh, R = body(R), np.eye(3) if R is None else R
    faces, down = mesh.boundaries["skin"], R @ [0.0, -0.6, 0.8]
    directions = generator("fibres").standard_normal((len(mesh.cells), 3)) @ R.T
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    edges = np.unique(np.sort(mesh.cells[:, [[0, 1], [1, 2], [2, 3], [3, 0]]].reshape(-1, 2), axis=1), axis=0)
    weight = Weight.of(mesh, TISSUES, down)
    ribs = EllipticCylinder(R @ [5.0, 6.0, -98.0], np.array([120.0, 100.0]), R[:, [0, 2, 1]])
    box_axes = R @ rotation(np.array([5.0, -8.0, 20.0]))
    paddle = RoundedBox(R @ [4.0, 5.0, 12.0], box_axes, np.array([4.0, 3.0, 4.0]), 2.0)
    made = {
        "bulk": lambda: NeoHookean.of(mesh, TISSUES),
        "nearly incompressible bulk": lambda: MixedNeoHookean.of(mesh, NEARLY_INCOMPRESSIBLE),
        "network": lambda: SpringNetwork.of(mesh, TISSUES),
        "small strain": lambda: SmallStrain.of(mesh, TISSUES),
        "skin": lambda: Skin(10.0, 0.45, 1.5).on(mesh),
        "fascia": lambda: Fascia(120.0, 0.45, 0.1, boundary="skin").on(mesh),
        "fibres": lambda: Fibres.of(mesh, directions, stiffness_kpa=2.0),
        "stiffening fibres": lambda: Fibres.of(mesh, directions, stiffness_kpa=2.0, exponent=1.5),
        "springs": lambda: Springs.between(mesh.points, edges, youngs_modulus_kpa=500.0, section_mm2=0.2),
        "weight": lambda: weight,
        "part of the weight": lambda: Scaled(weight, 0.3),
        "water": lambda: Buoyancy.of(mesh, down, level_mm=1.0, waterline_mm=6.0),
        "plate": lambda: RigidPlate(faces, face_quadrature(mesh.points, faces).areas, paddle, 3.0),
        "plate that has pressed": lambda: replace(
            RigidPlate(faces, SIX_POINTS.areas(mesh.points, faces), paddle, 3.0),
            multiplier=np.linspace(0.0, 2.0, 6 * len(faces)).reshape(-1, 6),
        ),
        "bent plate": lambda: RigidPlate(faces, SIX_POINTS.areas(mesh.points, faces), bent(paddle), 3.0),
        "friction": lambda: friction(faces, R),
        "chest wall": lambda: chest_wall_contact(mesh, ribs, boundary="skin", penalty=3.0),
        "attraction": lambda: attraction(faces, R),
        "sliding": lambda: Sliding.of(mesh, ribs, normal_stiffness=5.0, tangential_stiffness=0.3),
    }
    return made[name]()


def bent(paddle):
    """Two modes of a few millimetres on a plate as large as the body."""
    modes = PlateModes.of(1.0, 0.3, (8.0, 7.0), 3)
    return BentBox(paddle, Bending(modes, np.array([0.6, -0.3, 0.2])))


def friction(faces, R):
    """On places around the body, some within the slip, with normals turned by R (3, 3)."""
    rng, shape = generator("friction"), (len(faces), 6)
    normals = rng.standard_normal((*shape, 3))
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    places, load = rng.uniform(0, 12, (*shape, 3)), rng.uniform(0, 5, shape)
    return CoulombFriction(faces, SIX_POINTS, load, normals @ R.T, places @ R.T, 8.0)


def attraction(faces, R):
    """Of 30 points, some on the same face, to places and along normals turned by R (3, 3)."""
    rng, n = generator("attraction"), 30
    normals = rng.standard_normal((n, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    L = rng.dirichlet(np.ones(3), n)
    N = np.hstack([L * (2 * L - 1), 4 * L * np.roll(L, -1, axis=1)])
    face, places = rng.integers(0, len(faces) // 2, n), rng.uniform(0, 12, (n, 3))
    return Attraction(faces, face, N, places @ R.T, normals @ R.T, rng.uniform(1, 5, n), 0.2)


@pytest.fixture(scope="module")
def shape():
    """Far from the reference: skin taut here and wrinkled there, springs slack, some skin in the wall."""
    points = body().points
    return points @ np.diag([1.3, 0.8, 1.1]) + 0.2 * generator("shape").standard_normal(points.shape)


def test_the_list_of_effects_is_complete():
    made = {type(effect(name)).__name__ for name in NAMES}
    classes = {name for name in effects.__all__ if hasattr(getattr(effects, name), "add_tangent")}
    assert classes - made == {"Effect"}  # the protocol


@pytest.mark.parametrize("name", NAMES)
def test_gradient_and_tangent_derive_from_the_energy(name, shape):
    assert_derives_from_its_energy(effect(name), shape)


@pytest.mark.parametrize("name", [name for name in NAMES if "weight" not in name])
def test_the_tangent_is_symmetric_and_its_projection_positive(name, shape):
    assert_symmetric_and_projectable(effect(name), shape)


@pytest.mark.parametrize("name", ELASTIC)
def test_rigid_motion_stores_no_energy_and_causes_no_force(name):
    assert_rotation_stores_nothing(effect(name), body().points, TURN)


@pytest.mark.parametrize("name", NAMES)
def test_a_body_turned_with_its_surroundings_has_the_same_energy_and_turned_forces(name, shape):
    here, there = effect(name), effect(name, TURN)
    assert there.energy(shape @ TURN.T) == pytest.approx(here.energy(shape), rel=1e-11)
    g = gradient(here, shape)
    assert gradient(there, shape @ TURN.T) == pytest.approx(g @ TURN.T, abs=1e-10 * np.abs(g).max())


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="one thread only")
@pytest.mark.parametrize("name", NAMES)
def test_one_and_two_threads_give_the_same_bits(name, shape):
    before, results = numba.get_num_threads(), []
    made = effect(name)
    try:
        for threads in (1, 2):
            numba.set_num_threads(threads)
            tangents = [tangent(made, shape, projected=p).data for p in (False, True)]
            results.append([np.array(made.energy(shape)), gradient(made, shape), *tangents])
    finally:
        numba.set_num_threads(before)
    for one, two in zip(*results):
        assert np.array_equal(one, two)
