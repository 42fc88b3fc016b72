"""Curved bodies against exact solutions: an inflated shell, a twisted cylinder."""

import numpy as np
import pytest
from mechanics_bodies import cylinder, shell_octant
from mechanics_references import TIGHT, forces, rows, unit_tissue

from mammosim.mechanics.body import body_effects
from mammosim.mechanics.equilibrium import equilibrium

INNER, OUTER = 1.0, 2.0


def inflated(mesh, case):
    """The inner pressure and the outer radius over 2 when the cavity has the table's radius a.

    The work of the pressure p on the cavity that grows by a unit is p pi a^2 / 2, in an octant.
    """
    X = mesh.points
    R = np.linalg.norm(X, axis=1)
    cavity = mesh.boundary_nodes("cavity")
    held = np.isclose(X, 0.0, atol=1e-9)
    held[cavity] = True
    kept_volume = np.cbrt(R**3 + case.a**3 - INNER**3)
    start = X * (kept_volume / R)[:, None]
    effects = body_effects(mesh, unit_tissue(case.nu))
    x = equilibrium(mesh, effects, held=held, start=start, settings=TIGHT).points
    work = np.sum(forces(effects, x)[cavity] * X[cavity]) / INNER
    outside = np.isclose(R, OUTER, atol=1e-6)
    return work / (np.pi * case.a**2 / 2), np.linalg.norm(x[outside], axis=1).mean() / OUTER


@pytest.fixture(scope="module")
def shells():
    return [shell_octant(INNER, OUTER, edge) for edge in (0.6, 0.3)]


@pytest.mark.parametrize("case", rows("sphere_inflation"), ids=lambda case: f"{case.nu}-{case.p}")
def test_a_shell_under_inner_pressure(shells, case):
    """The pressure, an integral of the stress, converges at fourth order: 2^4, were the meshes nested."""
    (coarse, _), (p, b) = (inflated(mesh, case) for mesh in shells)
    assert b == pytest.approx(case.b, abs=1e-4)
    assert p == pytest.approx(case.p, rel=3e-3 if case.nu < 0.49 else 1e-2)
    assert abs(p - case.p) < abs(coarse - case.p) / 4


def twisted(mesh, psi, nu):
    """Moment about the axis and axial force at the end z = 1 that is turned rigidly by psi."""
    X = mesh.points
    angle = psi * X[:, 2]
    c, s = np.cos(angle), np.sin(angle)
    start = np.stack([c * X[:, 0] - s * X[:, 1], s * X[:, 0] + c * X[:, 1], X[:, 2]], axis=1)
    top = np.isclose(X[:, 2], X[:, 2].max())
    held = np.repeat((top | np.isclose(X[:, 2], 0.0))[:, None], 3, axis=1)
    effects = body_effects(mesh, unit_tissue(nu))
    x = equilibrium(mesh, effects, held=held, start=start, settings=TIGHT).points
    g = forces(effects, x)[top]
    return np.sum(x[top, 0] * g[:, 1] - x[top, 1] * g[:, 0]), g[:, 2].sum()


@pytest.fixture(scope="module")
def cylinders():
    return [cylinder(1.0, 1.0, edge) for edge in (0.35, 0.25)]


@pytest.mark.parametrize("case", rows("torsion"), ids=lambda case: f"{case.psi:g}")
def test_a_twisted_cylinder(cylinders, case):
    """Moment of an incompressible cylinder, and its thrust (Poynting), a matter of pressure alone.

    At nu 0.499 mu / k is 0.2 %; the elements leave the square of the angle that each turns by.
    """
    (_, coarse), (moment, force) = (twisted(mesh, case.psi, 0.499) for mesh in cylinders)
    assert moment == pytest.approx(case.moment, rel=1e-3 + 2e-3 * case.psi**2)
    assert force == pytest.approx(case.axial_force, rel=0.03)
    assert abs(force - case.axial_force) < abs(coarse - case.axial_force) / 2
