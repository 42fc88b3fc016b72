"""The neo-Hookean body against closed forms and exact one-dimensional solutions, with rates."""

from dataclasses import replace

import numpy as np
import pytest
from mechanics_bodies import box

from mammosim.core.labels import Label
from mammosim.core.rng import generator
from mammosim.core.tissues import Tissue
from mammosim.core.units import KPA_PER_MM_PER_G_CM3
from mammosim.mechanics.body import body_effects
from mammosim.mechanics.effects import Weight
from mammosim.mechanics.equilibrium import Settings, equilibrium
from mammosim.mechanics.newton import NewtonSettings

# Rounding of k (J - 1) leaves residuals of about 1e-16 k / load, here up to 1e-12.
TIGHT = Settings(newton=NewtonSettings(tolerance=1e-11))

# Stretch, lateral stretch, axial Cauchy and nominal stress over mu of form B at nu = 0.45: roots of the
# lateral stress, computed independently of this project.
UNIAXIAL = [
    (0.6, 1.26103493, -1.33036189, -2.11555357),
    (0.9, 1.04872128, -0.29479383, -0.32421907),
    (1.2, 0.92181984, 0.57136338, 0.48551708),
    (1.4, 0.86163011, 1.14170189, 0.84760684),
]
# Column under its weight, no lateral strain, form B: nu, q = rho g L / mu, sign of gravity, tip
# displacement / L: exact one-dimensional solutions, computed independently.
COLUMN = [
    (0.45, 0.5, 1, 0.0228217272),
    (0.45, 0.5, -1, -0.0226267889),
    (0.45, 1.0, 1, 0.0458211951),
    (0.495, 0.5, 1, 0.0024753728),
]


def unit_tissue(nu, density=0.0):
    """mu = 1 kPa."""
    return {Label.ADIPOSE: Tissue(2 * (1 + nu), nu, density)}


def rollers(mesh, axes):
    """Held: normal components on the faces at 0 of the axes."""
    return np.stack(
        [np.isclose(mesh.points[:, i], 0.0) & (i in axes) for i in range(3)],
        axis=1,
    )


def reaction(mesh, effects, x, nodes):
    g = np.zeros_like(x)
    for effect in effects:
        effect.add_gradient(x, g)
    return g[nodes].sum(axis=0)


@pytest.mark.parametrize(("stretch", "lateral", "cauchy", "nominal"), UNIAXIAL)
def test_uniaxial_stress(stretch, lateral, cauchy, nominal):
    mesh = box((2, 2, 2), (10.0, 10.0, 10.0))
    held = rollers(mesh, (0, 1, 2))
    top = np.isclose(mesh.points[:, 2], 10.0)
    held[top, 2] = True
    effects = body_effects(mesh, unit_tissue(0.45))
    x = mesh.points * [1.0, 1.0, stretch]
    state = equilibrium(mesh, effects, held=held, start=x, settings=TIGHT)
    # The field is homogeneous, so it is in the space: exact to the digits of the table.
    assert state.points[:, :2].max() / 10.0 == pytest.approx(lateral, abs=1e-8)
    force = reaction(mesh, effects, state.points, top)[2]
    assert force / 100.0 == pytest.approx(nominal, abs=1e-8)
    assert force / (100.0 * lateral**2) == pytest.approx(cauchy, abs=2e-8)


@pytest.mark.parametrize("gamma", [0.1, 0.5, 1.0])
def test_simple_shear(gamma):
    """s12 = mu gamma, and normal stresses mu gamma^2 (2/3, -1/3, -1/3), whatever nu."""
    mesh = box((2, 2, 2), (10.0, 10.0, 10.0), posterior_axis=1)
    effects = body_effects(mesh, unit_tissue(0.45))
    x = mesh.points + gamma * mesh.points[:, [1]] * [1.0, 0.0, 0.0]
    top = np.isclose(mesh.points[:, 1], 10.0)
    traction = reaction(mesh, effects, x, top) / 100.0
    assert traction == pytest.approx([gamma, -(gamma**2) / 3, 0.0], abs=1e-12)


@pytest.mark.parametrize(
    ("stretch", "axial", "lateral"), [(0.8, -2.28145250, -1.75927375), (1.1, 1.08610404, 0.90694798)]
)
def test_confined_stretch(stretch, axial, lateral):
    """F = diag(1, 1, stretch): Cauchy stresses s33 and s11 over mu at nu = 0.45, closed form."""
    mesh = box((2, 2, 2), (10.0, 10.0, 10.0))
    effects = body_effects(mesh, unit_tissue(0.45))
    x = mesh.points * [1.0, 1.0, stretch]
    top, side = (np.isclose(mesh.points[:, i], 10.0) for i in (2, 0))
    assert reaction(mesh, effects, x, top)[2] / 100.0 == pytest.approx(axial, rel=3e-6)
    assert reaction(mesh, effects, x, side)[0] / (100.0 * stretch) == pytest.approx(lateral, rel=3e-6)


@pytest.mark.parametrize(("nu", "q", "sign", "tip"), COLUMN)
def test_column_under_its_weight(nu, q, sign, tip):
    L = 60.0
    mesh = box((1, 1, 6), (10.0, 10.0, L))
    tissue = unit_tissue(nu, density=q / (KPA_PER_MM_PER_G_CM3 * L))
    held = np.ones(mesh.points.shape, dtype=bool)
    held[:, 2] = np.isclose(mesh.points[:, 2], 0.0)
    weight = Weight.of(mesh, tissue, np.array([0.0, 0.0, float(sign)]))
    state = equilibrium(mesh, body_effects(mesh, tissue), loads=(weight,), held=held, settings=TIGHT)
    end = np.isclose(mesh.points[:, 2], L)
    # Quadratic elements of L/6: (1/6)^4 of the tip, and better, since tip values superconverge.
    assert (state.points - mesh.points)[end, 2].mean() / L == pytest.approx(tip, rel=1e-4)


def test_the_columns_field_converges_at_third_order():
    """Quadratic elements: the displacement's error in the L2 norm falls as h^3."""
    L, nu, q = 60.0, 0.45, 2.0
    tissue = unit_tissue(nu, density=q / (KPA_PER_MM_PER_G_CM3 * L))

    def profile(n):
        mesh = box((1, 1, n), (L / n, L / n, L))
        held = np.ones(mesh.points.shape, dtype=bool)
        held[:, 2] = np.isclose(mesh.points[:, 2], 0.0)
        weight = Weight.of(mesh, tissue, np.array([0.0, 0.0, 1.0]))
        state = equilibrium(mesh, body_effects(mesh, tissue), loads=(weight,), held=held, settings=TIGHT)
        on_axis = np.isclose(mesh.points[:, 0], 0.0) & np.isclose(mesh.points[:, 1], 0.0)
        order = np.argsort(mesh.points[on_axis, 2])
        return mesh.points[on_axis, 2][order], (state.points - mesh.points)[on_axis, 2][order]

    fine_z, fine_u = profile(64)
    errors = []
    for n in (2, 4, 8):
        z, u = profile(n)
        sample = np.linspace(0.0, L, 64 * 2 + 1)
        quadratic = _piecewise_quadratic(z, u, sample)
        errors.append(np.sqrt(np.mean((quadratic - np.interp(sample, fine_z, fine_u)) ** 2)))
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert rates.min() > 2.7


def _piecewise_quadratic(z, u, sample):
    """The finite-element interpolant: three nodes an edge."""
    edge = np.clip(np.searchsorted(z[::2], sample, side="right") - 1, 0, len(z) // 2 - 1)
    a, m, b = 2 * edge, 2 * edge + 1, 2 * edge + 2
    t = (sample - z[a]) / (z[b] - z[a])
    return u[a] * (1 - t) * (1 - 2 * t) + u[m] * 4 * t * (1 - t) + u[b] * t * (2 * t - 1)


def test_a_patch_of_distorted_cells_reproduces_an_affine_deformation():
    mesh = box((3, 3, 3), (10.0, 10.0, 10.0))
    outer = np.any(np.isclose(mesh.points, 0.0) | np.isclose(mesh.points, 10.0), axis=1)
    corners = np.unique(mesh.cells[:, :4])
    moved = mesh.points.copy()
    inner = corners[~outer[corners]]
    moved[inner] += 0.5 * generator("patch").uniform(-1, 1, (len(inner), 3))
    for cell_edge, (a, b) in zip(range(4, 10), ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))):
        moved[mesh.cells[:, cell_edge]] = (moved[mesh.cells[:, a]] + moved[mesh.cells[:, b]]) / 2
    mesh = mesh.moved_to(moved)
    F = np.array([[1.1, 0.2, 0.0], [-0.1, 0.9, 0.1], [0.0, 0.15, 1.05]])
    affine = mesh.points @ F.T
    held = np.repeat(outer[:, None], 3, axis=1)
    noise = 0.2 * generator("patch", "start").standard_normal(affine.shape)
    start = np.where(held, affine, affine + noise)
    state = equilibrium(mesh, body_effects(mesh, unit_tissue(0.45)), held=held, start=start, settings=TIGHT)
    assert state.points == pytest.approx(affine, abs=1e-9)


def test_the_work_of_the_weight_is_the_energy_stored():
    """W = integral of f . du along the load path; Simpson's rule on 8 steps leaves about 8^-4."""
    mesh = box((2, 2, 3), (40.0, 40.0, 60.0))
    tissue = {Label.ADIPOSE: Tissue(1.0, 0.45, 1.0)}
    effects, x = body_effects(mesh, tissue), mesh.points
    weight = Weight.of(mesh, tissue, np.array([0.0, 0.0, 1.0]))
    done = [0.0]
    for factor in np.arange(1, 9) / 8:
        part = replace(weight, forces=factor * weight.forces)
        x = equilibrium(mesh, effects, loads=(part,), start=x).points
        done.append(-weight.energy(x))
    # Work = lambda u - integral of u dlambda, with u the displacement conjugate to the load factor.
    u = np.array(done)
    simpson = (u[0] + 4 * u[1:-1:2].sum() + 2 * u[2:-1:2].sum() + u[-1]) / 24
    stored = sum(effect.energy(x) for effect in effects)
    assert u[-1] - simpson == pytest.approx(stored, rel=1e-4)
