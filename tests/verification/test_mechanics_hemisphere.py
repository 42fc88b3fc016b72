"""The hanging hemisphere and the pressed ball against solutions that were computed independently.

R = 60 mm, 1 g/cm3, form B. Hanging: flat face held, gravity away from it; displacement of the apex in mm:
converged, from axisymmetric high-order solutions graded to the clamped edge, and on the mesh of 8 mm, where
felupe, dolfinx and CalculiX agree. Pressed: half of a ball of E = 1 kPa, nu 0.45 between plates from 120 to
60 mm.
"""

import numpy as np
import pytest
from mechanics_bodies import nearest, sphere_part
from mechanics_references import rows

from mammosim.core.errors import EquilibriumError
from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import Skin, body_effects, load
from mammosim.mechanics.effects import RigidPlate, RoundedBox
from mammosim.mechanics.equilibrium import Settings, equilibrium
from mammosim.mechanics.newton import NewtonSettings
from mammosim.mechanics.reference import face_quadrature
from mammosim.meshing.shapes import with_layer

APEX = np.array([0.0, 0.0, 60.0])
HANGING = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def coarse():
    return sphere_part(60.0, 14.0)


@pytest.fixture(scope="module")
def fine():
    return sphere_part(60.0, 8.0)


def apex_displacement(mesh, E, nu, **options):
    state = load(mesh, {Label.ADIPOSE: Tissue(E, nu, 1.0)}, HANGING, **options)
    apex = nearest(mesh, APEX)
    assert np.linalg.norm(mesh.points[apex] - APEX) < 3.0
    # The apex moves along the axis; a node beside it, as on a paraboloid, is lower by less than 0.1 %.
    return state.points[apex, 2] - mesh.points[apex, 2], state


@pytest.mark.parametrize(
    ("E", "nu", "converged", "others"),
    [(1.0, 0.45, 13.4175, 13.3872), (0.3, 0.45, 76.6884, 76.2379), (0.5, 0.495, 29.7452, 29.7069)],
)
def test_the_hanging_hemisphere_is_that_of_other_programs_and_converges(
    coarse, fine, E, nu, converged, others
):
    far, near = (apex_displacement(mesh, E, nu)[0] for mesh in (coarse, fine))
    # Another version of gmsh cuts other cells: that changes the mesh's error, 0.1 to 0.6 %, by a part of it.
    assert near == pytest.approx(others, rel=2e-3)
    assert abs(near - converged) < abs(far - converged)


@pytest.fixture(scope="module")
def bodies():
    """Elements of 14 and 11 mm: without skin, and with the outer 2 mm resolved."""
    plain = [sphere_part(60.0, edge) for edge in (14.0, 11.0)]
    inside = [sphere_part(58.0, edge) for edge in (14.0, 11.0)]
    return {0: plain, 10: [with_layer(mesh, mesh.points * 60 / 58) for mesh in inside]}


@pytest.mark.parametrize(
    "case",
    [row for row in rows("hemisphere") if row.E > 0.1],
    ids=lambda row: f"{row.skin_kpa}-{row.E}-{row.nu}",
)
def test_the_hanging_hemisphere_converges_with_and_without_a_resolved_skin(bodies, case):
    """The clamped edge, where stress is singular, leaves first order to the displacement."""
    tissues = {Label.ADIPOSE: Tissue(case.E, case.nu, 1.0), Label.SKIN: Tissue(10.0, 0.45, 1.0)}
    errors = []
    for mesh in bodies[case.skin_kpa]:
        apex = nearest(mesh, APEX)
        moved = load(mesh, tissues, HANGING).points[apex] - mesh.points[apex]
        errors.append(abs(moved[2] / case.apex - 1))
    assert errors[1] < errors[0]
    assert errors[1] < 0.025


def test_full_load_takes_few_iterations_even_near_incompressibility(coarse):
    """The predicted pressure keeps Newton from creeping: 5 to 8 iterations, where others take 15 to 34."""
    for E, nu in ((1.0, 0.45), (0.3, 0.45), (0.5, 0.495), (0.5, 0.4999)):
        _, state = apex_displacement(coarse, E, nu)
        assert state.load_factors == (0.0, 1.0)
        assert len(state.history) <= 10
        assert state.energy_imbalance < 1e-5


def test_a_skin_membrane_holds_back_as_a_resolved_skin_does(fine):
    """A resolved outer layer of 2 mm and 10 kPa leaves 23.10 mm of 76.7 at E = 0.3 kPa.

    The membrane lies at 60 mm instead of 58 to 60, and it wrinkles: within 5 %.
    """
    with_skin, _ = apex_displacement(fine, 0.3, 0.45, skin=Skin(10.0, 0.45, 2.0))
    assert with_skin == pytest.approx(23.1043, rel=0.05)


def test_gravity_towards_the_base_without_skin_loses_stability_at_the_rim(coarse):
    """E = 0.2 kPa: stable equilibria end at about four fifths of the load on this mesh, in few iterations.

    The surface next to the held base, within a fifth of the radius of it, moves over the rim.
    """
    with pytest.raises(EquilibriumError, match="stability is lost between") as caught:
        load(coarse, {Label.ADIPOSE: Tissue(0.2, 0.45, 1.0)}, -HANGING)
    lost = caught.value
    assert 0.7 < lost.load_factor < 0.9
    assert len(lost.history) < 100
    most = np.argmax(np.linalg.norm(lost.mode, axis=1))
    assert coarse.points[most, 2] < 12.0
    assert np.linalg.norm(coarse.points[most]) > 48.0


def test_a_full_load_that_passes_indefinite_tangents_is_not_believed(coarse):
    """E = 0.3 kPa towards the base: the full load is given up, and reached along the stable branch."""
    state = load(coarse, {Label.ADIPOSE: Tissue(0.3, 0.45, 1.0)}, -HANGING)
    assert len(state.load_factors) > 2
    assert any(row.negative_pivots > 0 for row in state.history)
    assert all(row.negative_pivots == 0 for row in state.history if row.step_length > 0)


def test_a_ball_pressed_to_half_its_width():
    mesh = sphere_part(60.0, 10.0, octant=True)
    faces = mesh.boundaries["skin"]
    areas = face_quadrature(mesh.points, faces).areas
    effects = body_effects(mesh, {Label.ADIPOSE: Tissue(1.0, 0.45, 1.0)})
    held = np.isclose(mesh.points, 0.0, atol=1e-6)  # three planes of symmetry
    x = mesh.points
    settings = Settings(newton=NewtonSettings(trusted=0))
    for y in np.linspace(60.0, 30.0, 9)[1:]:
        half = np.array([200.0, 20.0, 200.0])
        plate = RoundedBox(np.array([0.0, y + half[1], 0.0]), np.eye(3), half, 5.0)
        contact = RigidPlate(faces, areas, plate, 50.0)
        state = equilibrium(mesh, (*effects, contact), held=held, start=x, settings=settings)
        x = state.points
    for point, axis in ((APEX, 2), (np.array([60.0, 0.0, 0.0]), 0)):
        node = nearest(mesh, point)
        moved = x[node, axis] - mesh.points[node, axis]
        # 12.46 mm from three programs at 6 and 8 mm, which differ by 0.05 %; at 10 mm allow 0.3 %.
        assert moved == pytest.approx(12.462, rel=3e-3)
    assert contact.state(x).penetration < 0.05
