"""The hanging hemisphere and the pressed ball against solutions that were computed independently.

R = 60 mm, 1 g/cm3, form B. Hanging: flat face held, gravity away from it; apex displacement in mm, from axisymmetric
high-order solutions graded to the clamped edge. Pressed: half of a ball of E = 1 kPa, nu 0.45 between plates from 120 to
60 mm; three other programs give 12.460 to 12.467 mm at both free points.
"""

import numpy as np
import pytest
from mechanics_bodies import nearest, sphere_part

from mammosim.core.errors import EquilibriumError
from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import Skin, body_effects, load
from mammosim.mechanics.effects import RigidPlate, RoundedBox
from mammosim.mechanics.equilibrium import Settings, equilibrium
from mammosim.mechanics.newton import NewtonSettings
from mammosim.mechanics.reference import face_quadrature

APEX = np.array([0.0, 0.0, 60.0])
HANGING = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def coarse():
    return sphere_part(60.0, 14.0)


@pytest.fixture(scope="module")
def fine():
    return sphere_part(60.0, 9.0)


def apex_displacement(mesh, E, nu, **options):
    state = load(mesh, {Label.ADIPOSE: Tissue(E, nu, 1.0)}, HANGING, **options)
    apex = nearest(mesh, APEX)
    assert np.linalg.norm(mesh.points[apex] - APEX) < 3.0
    # The apex moves along the axis; a node beside it, as on a paraboloid, is lower by less than 0.1 %.
    return state.points[apex, 2] - mesh.points[apex, 2], state


@pytest.mark.parametrize(
    ("E", "nu", "reference", "error"),
    [(1.0, 0.45, 13.4175, 0.004), (0.3, 0.45, 76.6884, 0.01), (0.5, 0.495, 29.7452, 0.004)],
)
def test_the_hanging_hemisphere_converges_to_its_reference(coarse, fine, E, nu, reference, error):
    far, near = (abs(apex_displacement(mesh, E, nu)[0] / reference - 1) for mesh in (coarse, fine))
    # The clamped edge is singular, so the rate is low; published programs have 0.2-0.6 % at 8 mm.
    assert near < error
    assert near < far


def test_full_load_takes_few_iterations_even_near_incompressibility(coarse):
    """The pressure predicted at the integration points keeps Newton from creeping: 4 to 10, where others take 15-34."""
    for E, nu in ((1.0, 0.45), (0.3, 0.45), (0.5, 0.495), (0.5, 0.4999)):
        _, state = apex_displacement(coarse, E, nu)
        assert len(state.history) <= 12
        assert all(row.load_factor == 1.0 for row in state.history)


def test_a_skin_membrane_holds_back_as_a_resolved_skin_does(fine):
    """A resolved outer layer of 2 mm and 10 kPa leaves 23.10 mm of 76.7 at E = 0.3 kPa.

    The membrane lies at 60 mm instead of 58 to 60, and wrinkles: within 5 %, which is what a membrane may cost here.
    """
    with_skin, _ = apex_displacement(fine, 0.3, 0.45, skin=Skin(10.0, 0.45, 2.0))
    assert with_skin == pytest.approx(23.1043, rel=0.05)


def test_gravity_towards_the_base_without_skin_has_no_state_near_and_is_refused(coarse):
    with pytest.raises(EquilibriumError, match="stability") as caught:
        load(
            coarse,
            {Label.ADIPOSE: Tissue(0.3, 0.45, 1.0)},
            -HANGING,
            settings=Settings(newton=NewtonSettings(max_iterations=25), smallest_step=1 / 16),
        )
    assert 0.0 < caught.value.load_factor < 1.0


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
