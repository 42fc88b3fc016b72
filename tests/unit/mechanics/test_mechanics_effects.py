"""The bulk, weight, skin and plates do what their formulas say; what all effects share stands beside."""

import numpy as np
import pytest
from mechanics_bodies import box
from mechanics_derivatives import gradient, tangent

from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label
from mammosim.core.rigid import rotation
from mammosim.core.rng import generator
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import Skin
from mammosim.mechanics.effects import NeoHookean, RigidPlate, RoundedBox, Weight
from mammosim.mechanics.reference import face_quadrature

TISSUES = {Label.ADIPOSE: Tissue(1.0, 0.45, 0.95)}
STRETCHED = np.diag([1.3, 0.8, 1.1])


@pytest.fixture(scope="module")
def mesh():
    return box((2, 2, 2), (10.0, 12.0, 9.0))


def plate(mesh, centre=(4.0, 5.0, 12.0)):
    """A plate whose flat face, edges and corner all meet the skin."""
    faces = mesh.boundaries["skin"]
    shape = RoundedBox(
        np.array(centre), rotation(np.array([5.0, -8.0, 20.0])), np.array([4.0, 3.0, 4.0]), 2.0
    )
    return RigidPlate(faces, face_quadrature(mesh.points, faces).areas, shape, 3.0)


def deformed(mesh):
    """A shape far from the reference."""
    noise = generator("effects").standard_normal(mesh.points.shape)
    return mesh.points @ STRETCHED + 0.2 * noise


def test_projection_changes_nothing_where_the_tangent_is_positive(mesh):
    bulk = NeoHookean.of(mesh, TISSUES)
    K, projected = (tangent(bulk, mesh.points, projected=p) for p in (False, True))
    assert abs(K - projected).max() <= 1e-12 * abs(K).max()


def test_the_bulk_energy_of_a_homogeneous_stretch_is_the_printed_formula(mesh):
    mu, k = TISSUES[Label.ADIPOSE].shear_modulus_kpa, TISSUES[Label.ADIPOSE].bulk_modulus_kpa
    J = np.linalg.det(STRETCHED)
    W = mu / 2 * (J ** (-2 / 3) * np.sum(STRETCHED**2) - 3) + k / 2 * (J - 1) ** 2
    assert NeoHookean.of(mesh, TISSUES).energy(mesh.points @ STRETCHED) == pytest.approx(
        1080.0 * W, rel=1e-12
    )


def test_inverted_tissue_has_infinite_energy(mesh):
    bulk = NeoHookean.of(mesh, TISSUES)
    mirrored = mesh.points * [1.0, 1.0, -1.0]
    assert bulk.energy(mirrored) == np.inf
    assert bulk.smallest_J(mirrored) == pytest.approx(-1.0)


def test_the_weight_is_density_times_volume_along_gravity(mesh):
    weight = Weight.of(mesh, TISSUES, np.array([0.0, -1.0, 0.0]))
    assert weight.forces.sum(axis=0) == pytest.approx([0.0, -9.81e-3 * 0.95 * 1080.0, 0.0], abs=1e-12)
    assert weight.energy(mesh.points + np.array([0.0, 2.0, 0.0])) == pytest.approx(
        2.0 * 9.81e-3 * 0.95 * 1080.0
    )


def test_gravity_must_be_a_direction(mesh):
    with pytest.raises(MechanicsError, match="unit vector"):
        Weight.of(mesh, TISSUES, np.array([0.0, -9.81, 0.0]))


def test_a_tissue_without_parameters_is_named(mesh):
    with pytest.raises(MechanicsError, match="'adipose'"):
        NeoHookean.of(mesh, {Label.GLANDULAR: TISSUES[Label.ADIPOSE]})


@pytest.mark.parametrize(
    ("stretch", "law"),
    [
        ((1.2, 1.1), lambda c1, c2: c1 + c2 + 1 / (c1 * c2) - 3),
        ((1.2, 0.5), lambda c1, c2: c1 + 2 / np.sqrt(c1) - 3),
        ((0.9, 0.8), lambda c1, c2: 0.0),
    ],
    ids=["taut", "wrinkled", "slack"],
)
def test_skin_is_taut_wrinkled_or_slack(stretch, law):
    flat = box((2, 2, 1), (10.0, 12.0, 1.0))
    top = np.all(flat.points[flat.boundaries["skin"]][:, :, 2] == 1.0, axis=1)
    flat = type(flat)(flat.points, flat.cells, flat.tissue, {"skin": flat.boundaries["skin"][top]})
    membrane = Skin(10.0, 0.45, 1.5).on(flat)
    energy = membrane.energy(flat.points * [*stretch, 1.0])
    mu = 10.0 / (2 * 1.45)
    assert energy == pytest.approx(120.0 * 1.5 * mu / 2 * law(stretch[0] ** 2, stretch[1] ** 2), rel=1e-12)


def test_skin_may_be_thicker_in_places(mesh):
    thickness = np.full(len(mesh.boundaries["skin"]), 1.0)
    thickness[:3] = 2.0
    x = mesh.points @ STRETCHED
    uniform, extra = Skin(10.0, 0.45, 1.0).on(mesh), Skin(10.0, 0.45, thickness).on(mesh)
    assert extra.energy(x) > uniform.energy(x)
    for impossible in (0.0, np.nan):
        with pytest.raises(MechanicsError, match="thickness_mm"):
            Skin(10.0, 0.45, impossible)


def test_the_plates_distance_is_that_of_a_rounded_box():
    shape = RoundedBox(np.zeros(3), np.eye(3), np.array([4.0, 3.0, 2.0]), 1.0)
    points = np.array([[0, 0, 5.0], [0, 0, 1.5], [6.0, 5.0, 0], [7.0, 6.0, 5.0], [0, -7.0, 0]])
    # Above the face; inside it; off an edge and a corner (from the axes of their rounding); off the side.
    expected = [3.0, -0.5, np.hypot(3, 3) - 1, np.sqrt(16 + 16 + 16) - 1, 4.0]
    assert shape.distance(points) == pytest.approx(expected)
    v, h = generator("plate").standard_normal(points.shape), 1e-6
    difference = (shape.distance(points + h * v) - shape.distance(points - h * v)) / (2 * h)
    assert np.sum(shape.normal(points) * v, axis=1) == pytest.approx(difference, abs=1e-8)


def test_a_plate_pushes_back_with_the_force_it_feels(mesh):
    contact, x = plate(mesh), deformed(mesh)
    assert contact.state(x).force == pytest.approx(gradient(contact, x).sum(axis=0), rel=1e-12)


def test_the_edge_radius_fits_the_plate():
    with pytest.raises(MechanicsError, match="edge radius 5 mm must be in"):
        RoundedBox(np.zeros(3), np.eye(3), np.array([4.0, 3.0, 2.0]), 5.0)
