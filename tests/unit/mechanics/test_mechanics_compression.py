"""Two plates press with equal forces, do the work that the body stores, and go where they are asked."""

from dataclasses import replace

import numpy as np
import pytest
from mechanics_bodies import box

from mammosim.core.errors import EquilibriumError, MechanicsError
from mammosim.core.labels import Label
from mammosim.core.rigid import rotation
from mammosim.core.tissues import Tissue
from mammosim.core.units import MN_PER_N
from mammosim.mechanics.body import body_effects
from mammosim.mechanics.compression import Force, Plates, PressSettings, Thickness, compress, released
from mammosim.mechanics.effects import Weight
from mammosim.mechanics.equilibrium import Settings
from mammosim.mechanics.newton import NewtonSettings
from mammosim.mechanics.reference import cell_strain

TISSUES = {Label.ADIPOSE: Tissue(5.0, 0.45, 1.0)}


@pytest.fixture(scope="module")
def block():
    """A block of 30 x 24 x 30 mm that stands out along z from where it is held; pressed along y."""
    return box((3, 2, 3), (30.0, 24.0, 30.0))


def plates_for(mesh):
    points = mesh.points[mesh.points[:, 2] > 12.0]
    return Plates.covering(
        points, direction=np.array([0.0, 1.0, 0.0]), outward=np.array([0.0, 0.0, 1.0]), edge_radius_mm=6.0
    )


@pytest.fixture(scope="module")
def pressed(block):
    return compress(block, body_effects(block, TISSUES), plates=plates_for(block), control=Thickness(18.0))


def test_plates_start_at_first_contact_and_end_at_the_wanted_thickness(pressed):
    thickness = pressed.path["thickness_mm"]
    assert thickness.iloc[0] == pytest.approx(24.0)
    assert pressed.path["force_n"].iloc[0] == pytest.approx(0.0, abs=1e-9)
    assert thickness.iloc[-1] == 18.0
    assert thickness.is_monotonic_decreasing


def test_pressed_skin_lies_on_the_plates_on_average_over_parts_of_its_faces(pressed):
    stages, settings = pressed.stages, PressSettings()
    longest = np.abs(np.diff([stage.thickness for stage in stages])).max()
    assert max(stage.gap_error for stage in stages) <= settings.path_penetration * longest
    assert stages[-1].gap_error <= settings.penetration_mm
    assert pressed.path["penetration_mm"].max() < 0.25
    between = pressed.points[pressed.points[:, 2] > 20.0]
    assert np.abs(between[:, 1] - 12.0).max() <= 9.0 + 2 * pressed.path["penetration_mm"].iloc[-1]


def test_paddle_and_support_press_alike_on_a_symmetric_body(pressed):
    # The block and its plates are symmetric; its mesh is not, which leaves a difference of discretisation.
    last = pressed.path.iloc[-1]
    assert last["force_n"] == pytest.approx(last["support_force_n"], rel=0.02)
    assert pressed.path["force_n"].is_monotonic_increasing


def test_all_forces_on_the_body_are_in_balance(pressed, block):
    """Plates and the held base: the sum of all forces on a body in equilibrium is zero."""
    reaction = np.zeros_like(pressed.points)
    body_effects(block, TISSUES)[0].add_gradient(pressed.points, reaction)
    base = reaction[block.boundary_nodes("posterior")].sum(axis=0)
    on_plates = sum(contact.force for contact in pressed.contacts)
    assert np.abs(base - on_plates).max() <= 1e-6 * np.linalg.norm(pressed.contacts[0].force)


def test_the_work_of_the_plates_is_the_energy_stored(pressed):
    """dPi/dthickness is minus the force; the trapezoidal rule on 8 steps leaves about 8^-2."""
    force = (pressed.path["force_n"] + pressed.path["support_force_n"]) / 2 * MN_PER_N
    work = -np.trapezoid(force, pressed.path["thickness_mm"])
    assert work == pytest.approx(pressed.path["energy_uj"].iloc[-1], rel=0.02)


def test_pressure_is_force_over_area(pressed):
    last = pressed.path.iloc[-1]
    assert last["mean_pressure_kpa"] == pytest.approx(last["force_n"] * MN_PER_N / last["contact_area_mm2"])
    assert last["peak_pressure_kpa"] > last["mean_pressure_kpa"]


def test_pressed_tissue_is_shorter_across_the_plates(pressed, block):
    strain = cell_strain(block, pressed.points)
    middle = block.points[block.cells[:, :4]].mean(axis=1)[:, 2] > 18.0
    # 18 of 24 mm: E = (0.75^2 - 1) / 2 = -0.22 on average.
    assert strain.principal[middle, 0].mean() == pytest.approx(-0.22, abs=0.03)


def test_an_impossible_thickness_is_rejected(block):
    effects = body_effects(block, TISSUES)
    for thickness in (24.5, 0.0):
        with pytest.raises(MechanicsError, match="outside"):
            compress(block, effects, plates=plates_for(block), control=Thickness(thickness))


def test_compression_that_fails_names_the_thickness_it_reached(block):
    few = PressSettings(
        smallest_step_mm=1.0,
        path_tolerance=1e-8,
        solver=Settings(newton=NewtonSettings(max_iterations=1, trusted=0)),
    )
    with pytest.raises(EquilibriumError, match=r"compression to 18 mm stopped at (18|19|2\d)\.\d\d mm"):
        compress(
            block,
            body_effects(block, TISSUES),
            plates=plates_for(block),
            control=Thickness(18.0),
            settings=few,
        )


def test_plates_beside_the_body_are_rejected(block):
    far = Plates(np.array([200.0, 0.0, 0.0]), np.eye(3), np.array([20.0, 20.0, 10.0]), 5.0)
    with pytest.raises(MechanicsError, match="no skin node lies between the plates"):
        compress(block, body_effects(block, TISSUES), plates=far, control=Thickness(18.0))


def test_the_paddle_is_carried_by_support_and_chest(pressed):
    """All forces along the axis, each summed by itself: exact but for the residual of some hundred nodes."""
    path = pressed.path.iloc[1:]
    carried = path["support_force_n"] + path["chest_force_n"]
    left = np.abs(carried / path["force_n"] - 1)
    assert left.max() < 100 * PressSettings().path_tolerance
    assert left.iloc[-1] < 100 * PressSettings().solver.newton.tolerance


def test_unloading_returns_to_the_start(pressed, block):
    """Without friction the way back ends in the stress-free shape, with the forces of the way there."""
    back = released(block, body_effects(block, TISSUES), pressed)
    assert np.abs(back.points - block.points).max() < 1e-6
    assert back.path["force_n"].iloc[0] == pressed.path["force_n"].iloc[-1]
    assert back.path["force_n"].iloc[-1] == pytest.approx(0.0, abs=1e-9)


def test_the_force_asked_for_is_met(block, pressed):
    """And at the thickness at which a compression by thickness has that force."""
    asked = pressed.path["force_n"].iloc[-1]
    found = compress(
        block, body_effects(block, TISSUES), plates=plates_for(block), control=Force(asked, smallest_mm=10.0)
    )
    assert found.path["force_n"].iloc[-1] == pytest.approx(asked, rel=Force(asked).tolerance)
    assert found.path["readout_mm"].iloc[-1] == pytest.approx(18.0, abs=0.02)


def test_a_force_that_the_smallest_thickness_does_not_give_fails(block):
    with pytest.raises(EquilibriumError, match=r"at the smallest thickness, 22 mm, the force is .* N, less"):
        compress(
            block,
            body_effects(block, TISSUES),
            plates=plates_for(block),
            control=Force(50.0, smallest_mm=22.0),
        )


def test_a_turned_setup_has_the_same_compression(block, pressed):
    """As mediolateral oblique is to craniocaudal: body and plates turned together."""
    R, plates = rotation(np.array([20.0, -50.0, 130.0])), plates_for(block)
    turned = block.moved_to(block.points @ R.T)
    found = compress(
        turned,
        body_effects(turned, TISSUES),
        plates=replace(plates, centre=R @ plates.centre, axes=R @ plates.axes),
        control=Thickness(18.0),
    )
    assert found.points @ R == pytest.approx(pressed.points, abs=1e-6)
    for name in ("force_n", "support_force_n", "chest_force_n", "contact_area_mm2"):
        # At first contact rounding says which points do.
        there = found.path[name].to_numpy()[1:]
        assert there == pytest.approx(pressed.path[name].to_numpy()[1:], abs=1e-6)


def test_weight_acts_before_the_plates_do(block):
    """The plates start at first contact with the hanging body, and then carry or are pushed by its weight."""
    heavy = {Label.ADIPOSE: Tissue(5.0, 0.45, 1.0)}
    down = np.array([0.0, -1.0, 0.0])
    weight = Weight.of(block, heavy, down)
    found = compress(
        block, (*body_effects(block, heavy), weight), plates=plates_for(block), control=Thickness(20.0)
    )
    path = found.path
    assert path["readout_mm"].iloc[0] > 24.0
    assert path["support_force_n"].iloc[-1] > path["force_n"].iloc[-1]
    carried = path["support_force_n"] + path["chest_force_n"]
    assert carried.to_numpy() == pytest.approx(path["force_n"].to_numpy(), abs=1e-6)
