"""Homogeneous deformations in closed form: they lie in the space of the elements, so they must be exact."""

from dataclasses import replace

import numpy as np
import pytest
from mechanics_bodies import box
from mechanics_references import TIGHT, forces, rollers, rows, unit_tissue

from mammosim.core.errors import EquilibriumError
from mammosim.core.labels import Label
from mammosim.mechanics.body import body_effects
from mammosim.mechanics.compression import Plates, PressSettings, Thickness, compress
from mammosim.mechanics.equilibrium import equilibrium

SIDE = 10.0
# Half a unit of the last of the tables' eight decimals, and rounding of k (J - 1).
DIGITS = 2e-8


@pytest.fixture(scope="module")
def cube():
    return box((2, 2, 2), (SIDE, SIDE, SIDE))


def at(mesh, axis, value):
    return np.isclose(mesh.points[:, axis], value)


@pytest.mark.parametrize("nu", [0.3, 0.45, 0.49, 0.495, 0.499])
def test_the_rest_state_is_free_of_stress(cube, nu):
    """With the plain I1 of the printed law it would carry the stress mu."""
    effects = body_effects(cube, unit_tissue(nu))
    k = unit_tissue(nu)[Label.ADIPOSE].bulk_modulus_kpa
    assert np.abs(forces(effects, cube.points)).max() <= 1e-12 * k * SIDE**2
    state = equilibrium(cube, effects)
    assert state.points == pytest.approx(cube.points, abs=1e-12)


def named(case):
    return f"{case.nu}-{case.stretch}"


# Compressed to half, nu 0.3 has a homogeneous equilibrium that is no minimum: volume is cheaper than shape.
STABLE = [case for case in rows("uniaxial_stress") if case.nu > 0.3 or case.stretch > 0.5]
UNSTABLE = [case for case in rows("uniaxial_stress") if case.nu == 0.3 and case.stretch <= 0.5]


@pytest.mark.parametrize("case", STABLE, ids=named)
def test_uniaxial_stress(cube, case):
    held = rollers(cube, (0, 1, 2))
    top = at(cube, 2, SIDE)
    held[top, 2] = True
    effects = body_effects(cube, unit_tissue(case.nu))
    sideways = case.stretch**-0.5  # a start that keeps the volume
    x = cube.points * [sideways, sideways, case.stretch]
    state = equilibrium(cube, effects, held=held, start=x, settings=TIGHT)
    stretches = state.points.max(axis=0) / SIDE
    assert stretches == pytest.approx([case.lateral_stretch, case.lateral_stretch, case.stretch], abs=DIGITS)
    force = forces(effects, state.points)[top, 2].sum()
    assert force / SIDE**2 == pytest.approx(case.nominal, abs=DIGITS)
    assert force / (stretches[0] * SIDE) ** 2 == pytest.approx(case.cauchy, abs=DIGITS)


@pytest.mark.parametrize("case", UNSTABLE, ids=named)
def test_uniaxial_stress_that_is_no_minimum_is_in_equilibrium_and_unstable(cube, case):
    held = rollers(cube, (0, 1, 2))
    top = at(cube, 2, SIDE)
    held[top, 2] = True
    effects = body_effects(cube, unit_tissue(case.nu))
    x = cube.points * [case.lateral_stretch, case.lateral_stretch, case.stretch]
    g = forces(effects, x) / SIDE**2
    assert (
        np.abs(g[~held]).max() <= 10 * DIGITS
    )  # the derivative of the stress by the lateral stretch is about 10
    assert g[top, 2].sum() == pytest.approx(case.nominal, abs=10 * DIGITS)
    with pytest.raises(EquilibriumError, match="unstable"):
        equilibrium(cube, effects, held=held, start=x, settings=TIGHT)


@pytest.mark.parametrize("case", rows("simple_shear"), ids=lambda case: f"{case.gamma}")
@pytest.mark.parametrize("nu", [0.3, 0.499])
def test_simple_shear(cube, case, nu):
    """Tractions of the faces whose normals stay e1, e2, e3: those of e1 turn to (1, -gamma)."""
    effects = body_effects(cube, unit_tissue(nu))
    x = cube.points + case.gamma * cube.points[:, [1]] * [1.0, 0.0, 0.0]
    g = forces(effects, x) / SIDE**2
    assert g[at(cube, 1, SIDE)].sum(axis=0) == pytest.approx([case.s12, case.s22, 0.0], abs=DIGITS)
    assert g[at(cube, 2, SIDE)].sum(axis=0) == pytest.approx([0.0, 0.0, case.s33], abs=DIGITS)
    turned = [case.s11 - case.gamma * case.s12, case.s12 - case.gamma * case.s22, 0.0]
    assert g[at(cube, 0, SIDE)].sum(axis=0) == pytest.approx(turned, abs=DIGITS)


@pytest.mark.parametrize("case", rows("confined_stretch"), ids=named)
def test_confined_stretch(cube, case):
    effects = body_effects(cube, unit_tissue(case.nu))
    g = forces(effects, cube.points * [1.0, 1.0, case.stretch]) / SIDE**2
    # The tables' k of six digits enters as k (J - 1).
    k = 2 * (1 + case.nu) / (3 * (1 - 2 * case.nu))
    tolerance = DIGITS + 1e-6 * k * abs(case.stretch - 1)
    assert g[at(cube, 2, SIDE), 2].sum() == pytest.approx(case.s33, abs=tolerance)
    assert g[at(cube, 0, SIDE), 0].sum() / case.stretch == pytest.approx(case.s11, abs=tolerance)


@pytest.mark.parametrize("nu", [0.45, 0.495])
@pytest.mark.parametrize("stretch", [0.8, 0.6])
def test_a_cube_pressed_between_plates_is_uniaxial_stress(nu, stretch):
    """Pressed skin lies on the plates, whatever the penalty: their distance is the thickness of the row."""
    (case,) = (row for row in rows("uniaxial_stress", nu=nu) if row.stretch == stretch)
    cube = box((2, 2, 2), (SIDE, SIDE, SIDE))
    faces = cube.boundaries["skin"], cube.boundaries["posterior"]
    ends = np.concatenate(faces)
    heights = cube.points[ends][:, :, 2]
    pressed = ends[np.all(heights == 0, axis=1) | np.all(heights == SIDE, axis=1)]
    cube = replace(cube, boundaries={"skin": pressed})
    held = rollers(cube, (0, 1))
    held[at(cube, 2, SIDE / 2), 2] = True  # by symmetry; the plates alone hold nothing at first contact
    half = np.array([4 * SIDE, 4 * SIDE, SIDE])
    result = compress(
        cube,
        body_effects(cube, unit_tissue(nu)),
        plates=Plates(np.array([0.0, 0.0, SIDE / 2]), np.eye(3), half, 1.0),
        control=Thickness(stretch * SIDE),
        held=held,
        settings=PressSettings(steps=4, penetration_mm=1e-7, solver=TIGHT),
    )
    last = result.path.iloc[-1]
    assert np.ptp(result.points[:, 2]) == pytest.approx(stretch * SIDE, abs=1e-6)
    assert result.points[:, 0].max() == pytest.approx(case.lateral_stretch * SIDE, abs=1e-6)
    assert 1e3 * last.force_n == pytest.approx(-case.nominal * SIDE**2, rel=1e-6)
    assert last.mean_pressure_kpa == pytest.approx(-case.cauchy, rel=1e-6)
