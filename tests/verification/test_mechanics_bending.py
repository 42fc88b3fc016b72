"""Bending against independent solutions: Cook's membrane, and a slender beam under its weight."""

import numpy as np
import pytest
from mechanics_bodies import box, nearest
from mechanics_references import rows

from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.core.units import KPA_PER_MM_PER_G_CM3
from mammosim.mechanics.body import body_effects
from mammosim.mechanics.effects import Weight
from mammosim.mechanics.equilibrium import equilibrium
from mammosim.mechanics.reference import FACE_SHAPES, face_quadrature

MU_KPA, TRACTION_KPA = 422.5, 1000.0 / 16  # 0.4225 N/mm2, and 1 N per mm of thickness on 16 mm


def cook(nu, n):
    """Displacement of the corner and of the middle of the loaded edge (2, 3) mm, on n x n bricks."""
    mesh = box((n, n, 1), (1.0, 1.0, 1 / n), posterior_axis=0)
    s, t, z = mesh.points.T
    X = np.stack([48 * s, 44 * s + t * (44 - 28 * s), 10 * z], axis=1)
    mesh = mesh.moved_to(X)
    held = np.isclose(X[:, [0, 0, 0]], 0.0)
    held[:, 2] = True  # plane strain
    faces = mesh.boundaries["skin"]
    edge = faces[np.isclose(X[faces][:, :, 0], 48.0).all(axis=1)]
    shares = face_quadrature(X, edge).areas @ FACE_SHAPES
    f = np.zeros_like(X)
    np.add.at(f[:, 1], edge, TRACTION_KPA * shares)
    tissue = {Label.ADIPOSE: Tissue(2 * (1 + nu) * MU_KPA, nu, 0.0)}
    state = equilibrium(mesh, body_effects(mesh, tissue), loads=(Weight(X, f),), held=held)
    look = [nearest(mesh, np.array([48.0, height, 0.0])) for height in (60.0, 52.0)]
    return (state.points - X)[look]


def test_cooks_membrane():
    """The wide angle at its clamped edge leaves less than second order: a third of the error."""
    reference = rows("cook_membrane", nu=0.3, elements=32)[0]
    expected = [[reference.ux_corner, reference.uy_corner], [reference.ux_mid, reference.uy_mid]]
    coarse, fine = (cook(0.3, n)[:, :2] for n in (8, 16))
    # The reference itself moved by 0.02 % in uy and 0.2 % in ux from 16 to 32 elements.
    assert fine[:, 1] == pytest.approx(np.array(expected)[:, 1], rel=1.5e-3)
    assert fine[:, 0] == pytest.approx(np.array(expected)[:, 0], rel=4e-3)
    assert abs(coarse - expected)[0, 1] > 3 * abs(fine - expected)[0, 1]


def test_cooks_membrane_near_incompressibility():
    """At nu 0.49 the references still rise with refinement, 11.35, 11.51, 11.57 mm on 8, 16, 32 elements."""
    references = [row.uy_corner for row in rows("cook_membrane", nu=0.49)]
    coarse, fine = (cook(0.49, n)[0, 1] for n in (8, 16))
    limit = references[-1] + (references[-1] - references[-2])  # halving steps: the last one again
    assert coarse < fine < limit
    assert fine > references[0]
    assert limit - fine < 0.6 * (limit - coarse)


SLENDER = (10, 20)  # length over thickness


def beam(G, slenderness):
    """The tip (x, z) over L of a square beam clamped at x = 0, G = 12 rho g L^3 / (E h^2), nu = 0."""
    L, E = 60.0, 1000.0
    h = L / slenderness
    weight_density = G * E * h**2 / (12 * L**3)
    mesh = box((slenderness, 1, 1), (L, h, h), posterior_axis=0)
    mesh = mesh.moved_to(mesh.points - [0, h / 2, h / 2])
    tissue = {Label.ADIPOSE: Tissue(E, 0.0, weight_density / KPA_PER_MM_PER_G_CM3)}
    weight = Weight.of(mesh, tissue, np.array([0.0, 0.0, -1.0]))
    state = equilibrium(mesh, body_effects(mesh, tissue), loads=(weight,))
    return state.points[nearest(mesh, np.array([L, 0.0, 0.0]))][[0, 2]] / L


@pytest.mark.parametrize(
    "case", [row for row in rows("elastica") if row.G <= 8], ids=lambda row: f"{row.G:g}"
)
def test_a_slender_beam_tends_to_the_elastica(case):
    """Shear and stretch, which an elastica has not, fade as the square of thickness over length."""
    expected = np.array([case.tip_x, -case.tip_drop])
    thick, thin = (beam(case.G, slenderness) for slenderness in SLENDER)
    assert thin[1] == pytest.approx(expected[1], rel=5e-3)
    assert (thick - expected)[1] / (thin - expected)[1] == pytest.approx(4.0, rel=0.05)
    # What is left is of fourth order, (1/20)^4 of some units, and the tables' digits.
    assert (4 * thin - thick) / 3 == pytest.approx(expected, abs=2e-4)
