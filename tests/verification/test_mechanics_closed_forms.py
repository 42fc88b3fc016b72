"""What any finite elements must satisfy: the patch test, a manufactured solution, work that is stored."""

from dataclasses import replace

import numpy as np
import pytest
from mechanics_bodies import box
from mechanics_references import TIGHT, unit_tissue
from skfem.quadrature import get_quadrature
from skfem.refdom import RefTet

from mammosim.core.labels import Label
from mammosim.core.rng import generator
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import body_effects
from mammosim.mechanics.effects import Weight
from mammosim.mechanics.equilibrium import equilibrium
from mammosim.mechanics.reference import TETRAHEDRON, shape_functions, shape_gradients


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


# A manufactured solution: x = X + u with u vanishing where X_3 = 0, dead body forces b = -Div P, and the
# whole outside prescribed. Second derivatives of W by central differences of the printed P.
WAVE, AMPLITUDE = 0.9, 0.35
NU = 0.4


def moved(X):
    """u (n, 3) at points X (n, 3) of the cube [0, 2]^3, mm."""
    X1, X2, X3 = X.T
    return AMPLITUDE * np.stack(
        [np.sin(WAVE * X2) * X3, 0.5 * np.cos(WAVE * X1) * X3, np.sin(WAVE * (X1 + X3)) * X3 / 2], axis=1
    )


def slope(field, X, h):
    """d field_i / dX_j (n, 3, ..., 3) by central differences of step h."""
    steps = h * np.eye(3)
    return np.stack([(field(X + step) - field(X - step)) / (2 * h) for step in steps], axis=-1)


def piola(X):
    """P (n, 3, 3) over mu of the manufactured shape."""
    F = np.eye(3) + slope(moved, X, 1e-4)
    k = 2 * (1 + NU) / (3 * (1 - 2 * NU))
    J, I1 = np.linalg.det(F)[:, None, None], np.sum(F**2, axis=(1, 2))[:, None, None]
    C = J * np.swapaxes(np.linalg.inv(F), 1, 2)
    return J ** (-2 / 3) * (F - I1 / (3 * J) * C) + k * (J - 1) * C


def manufactured_errors(n):
    """L2 errors of u and of its gradient on n^3 bricks, by a quadrature of degree 6."""
    mesh = box((n, n, n), (2.0, 2.0, 2.0))
    xi, weights = get_quadrature(RefTet, 6)
    L = np.vstack([1 - xi.sum(axis=0), xi]).T
    N, dN = shape_functions(L, TETRAHEDRON), shape_gradients(L, TETRAHEDRON)
    X = mesh.points[mesh.cells]
    A = np.einsum("eai,qaj->eqij", X, dN)
    dV = np.linalg.det(A) * weights
    at = np.einsum("qa,eai->eqi", N, X)
    b = -np.einsum("nijj->ni", slope(piola, at.reshape(-1, 3), 1e-3)).reshape(at.shape)
    f = np.zeros_like(mesh.points)
    np.add.at(f, mesh.cells, np.einsum("eq,qa,eqi->eai", dV, N, b))
    outer = np.any(np.isclose(mesh.points, 0.0) | np.isclose(mesh.points, 2.0), axis=1)
    state = equilibrium(
        mesh,
        (*body_effects(mesh, unit_tissue(NU)), Weight(mesh.points, f)),
        held=np.repeat(outer[:, None], 3, axis=1),
        start=mesh.points + moved(mesh.points),
        settings=TIGHT,
    )
    u = (state.points - mesh.points)[mesh.cells]
    exact, exact_slope = moved(at.reshape(-1, 3)), slope(moved, at.reshape(-1, 3), 1e-4)
    error = np.einsum("qa,eai->eqi", N, u).reshape(-1, 3) - exact
    gradients = np.einsum("qaj,eqjk->eqak", dN, np.linalg.inv(A))
    error_slope = np.einsum("eqaj,eai->eqij", gradients, u).reshape(-1, 3, 3) - exact_slope
    return tuple(
        np.sqrt(np.sum(dV.ravel() * np.sum(e**2, axis=tuple(range(1, e.ndim))))) for e in (error, error_slope)
    )


def test_a_manufactured_solution_converges_at_the_rates_of_its_elements():
    """Stretches from 0.62 to 1.40, J from 0.75 to 1.25: h^3 in the displacement, h^2 in its gradient."""
    (coarse, coarse_slope), (fine, fine_slope) = (manufactured_errors(n) for n in (3, 6))
    assert np.log2(coarse / fine) > 2.8
    assert np.log2(coarse_slope / fine_slope) > 1.9
