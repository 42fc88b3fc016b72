"""The mixed law of nearly incompressible tissue: a potential, taken where it is needed."""

import numpy as np
import pytest
from mechanics_bodies import box
from mechanics_derivatives import (
    assert_derives_from_its_energy,
    assert_symmetric_and_projectable,
    gradient,
    tangent,
)

from mammosim.core.errors import MechanicsError
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.rng import generator
from mammosim.core.tissues import Tissue
from mammosim.mechanics import solvers
from mammosim.mechanics.effects import MixedNeoHookean, NeoHookean, Weight, bulk_tissue
from mammosim.mechanics.equilibrium import equilibrium
from mammosim.mechanics.pattern import Tangent, pattern_of, upper_rows

STRETCHED = np.diag([1.3, 0.8, 1.1])


def tissue(nu, E=1.0):
    return Tissue(E, nu, 0.95)


def two_tissues():
    """A box whose upper half is glandular."""
    mesh = box((2, 2, 2), (10.0, 12.0, 9.0))
    upper = mesh.points[mesh.cells[:, :4]].mean(axis=1)[:, 2] > 4.5
    labels = np.where(upper, int(Label.GLANDULAR), int(Label.ADIPOSE))
    return TetMesh(mesh.points, mesh.cells, labels, mesh.boundaries)


@pytest.fixture(scope="module")
def mesh():
    return two_tissues()


MIXTURES = {
    "nearly incompressible": {Label.ADIPOSE: tissue(0.4999), Label.GLANDULAR: tissue(0.49, 5.0)},
    "in part": {Label.ADIPOSE: tissue(0.45), Label.GLANDULAR: tissue(0.4999)},
}


def deformed(mesh):
    return mesh.points @ STRETCHED + 0.2 * generator("mixed").standard_normal(mesh.points.shape)


@pytest.mark.parametrize("name", MIXTURES)
def test_gradient_and_tangent_derive_from_the_energy(mesh, name):
    assert_derives_from_its_energy(MixedNeoHookean.of(mesh, MIXTURES[name]), deformed(mesh))


@pytest.mark.parametrize("name", MIXTURES)
def test_the_tangent_is_symmetric_and_its_projection_has_no_negative_eigenvalue(mesh, name):
    assert_symmetric_and_projectable(MixedNeoHookean.of(mesh, MIXTURES[name]), deformed(mesh))


def test_projection_changes_nothing_where_the_tangent_is_positive(mesh):
    effect = MixedNeoHookean.of(mesh, MIXTURES["nearly incompressible"])
    K, projected = (tangent(effect, mesh.points, projected=p) for p in (False, True))
    assert abs(K - projected).max() <= 1e-12 * abs(K).max()


def test_a_homogeneous_change_of_volume_costs_what_the_law_says(mesh):
    """J is constant, so Pi J = J: both laws store the same."""
    for tissues in MIXTURES.values():
        mixed, plain = MixedNeoHookean.of(mesh, tissues), NeoHookean.of(mesh, tissues)
        x = mesh.points @ STRETCHED
        assert mixed.energy(x) == pytest.approx(plain.energy(x), rel=1e-12)
        assert gradient(mixed, x) == pytest.approx(gradient(plain, x), rel=1e-9, abs=1e-9)


def test_pressure_jumps_where_the_tissue_changes(mesh):
    """Each tissue has pressures of its own on the surface they share."""
    effect = MixedNeoHookean.of(mesh, MIXTURES["nearly incompressible"])
    shared = np.isclose(mesh.points[np.unique(mesh.cells[:, :4]), 2], 4.5).sum()
    assert effect.space.M.shape[0] == len(np.unique(mesh.cells[:, :4])) + shared


def test_the_prediction_is_the_pressure_that_the_step_changes_linearly(mesh):
    effect, x = MixedNeoHookean.of(mesh, MIXTURES["nearly incompressible"]), deformed(mesh)
    v = generator("step").standard_normal(x.shape)
    at = effect.predicted(x, 0 * v).pressure
    for h in (1e-4, 1e-5):
        after = effect.predicted(x + h * v, 0 * v).pressure
        error = np.abs(effect.predicted(x, h * v).pressure - after).max()
        # The rest is quadratic in the step: k h^2.
        assert error <= 20 * h * np.abs(after - at).max()


def test_the_cheap_law_is_kept_where_it_suffices(mesh):
    cheap = {Label.ADIPOSE: tissue(0.45), Label.GLANDULAR: tissue(0.3, 5.0)}
    assert isinstance(bulk_tissue(mesh, cheap), NeoHookean)
    assert isinstance(bulk_tissue(mesh, MIXTURES["in part"]), MixedNeoHookean)
    whole = NeoHookean.of(mesh, MIXTURES["in part"])
    assert whole.softened(10.0).k == pytest.approx(np.minimum(whole.k, 10.0 * whole.mu), rel=1e-15)
    assert np.any(whole.k > 10.0 * whole.mu)


def test_the_mixed_law_is_rejected_where_nothing_is_left_to_it(mesh):
    compressible = {Label.ADIPOSE: tissue(0.45), Label.GLANDULAR: tissue(0.3)}
    with pytest.raises(MechanicsError, match="use NeoHookean"):
        MixedNeoHookean.of(mesh, compressible)


def test_inverted_tissue_has_infinite_energy(mesh):
    effect = MixedNeoHookean.of(mesh, MIXTURES["in part"])
    assert effect.energy(mesh.points * [1.0, 1.0, -1.0]) == np.inf


def test_the_inertia_counts_the_negative_eigenvalues_of_the_whole_matrix(mesh):
    """One eigenvalue is pushed below zero: of n_p + 1 negative pivots, n_p belong to the pressures."""
    effect = MixedNeoHookean.of(mesh, MIXTURES["nearly incompressible"])
    pattern, held = pattern_of(len(mesh.points), [mesh.cells]), np.zeros(mesh.points.shape, dtype=bool)
    held[mesh.boundary_nodes("posterior")] = True
    rows = upper_rows(pattern, held)
    K = Tangent.zero(pattern)
    effect.add_tangent(mesh.points, K)
    whole = K.to_csr()[rows.free][:, rows.free].toarray()
    values = np.linalg.eigvalsh(whole)
    shift = (values[1] + values[2]) / 2
    for a in range(len(mesh.points)):
        p = np.searchsorted(pattern.columns[pattern.row_start[a] : pattern.row_start[a + 1]], a)
        K.blocks[pattern.row_start[a] + p] -= shift * np.eye(3)
    direct = solvers.DirectSolver(rows)
    try:
        with pytest.raises(solvers.IndefiniteTangent) as caught:
            direct.solve(K, np.ones(len(rows.free)), 1e-8)
    finally:
        direct.release()
    assert caught.value.negative == 2


def test_both_solvers_find_the_same_nearly_incompressible_equilibrium(monkeypatch):
    mesh = box((3, 3, 4), (30.0, 30.0, 40.0))
    tissues = {Label.ADIPOSE: tissue(0.4999)}
    weight = Weight.of(mesh, tissues, np.array([0.6, 0.0, 0.8]))
    effects = (MixedNeoHookean.of(mesh, tissues),)
    direct = equilibrium(mesh, effects, loads=(weight,))
    monkeypatch.setattr(solvers, "MULTIGRID_ABOVE", 0)
    iterative = equilibrium(mesh, effects, loads=(weight,))
    assert (direct.stability, iterative.stability) == ("inertia", "Lanczos")
    # Both stop at 1e-8 of the load; the softest mode of so short a column amplifies that a hundred times.
    moved = np.abs(direct.points - mesh.points).max()
    assert np.abs(iterative.points - direct.points).max() <= 1e-6 * moved
