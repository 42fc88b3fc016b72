"""Conjugate gradients under the V-cycle find what the factorisation finds, and reject what it rejects."""

import numba
import numpy as np
import pytest
from mechanics_bodies import box

from mammosim.core.labels import Label
from mammosim.core.rng import generator
from mammosim.core.tissues import Tissue
from mammosim.mechanics import solvers
from mammosim.mechanics.body import Skin, body_effects, load
from mammosim.mechanics.equilibrium import held_nodes
from mammosim.mechanics.multigrid import IndefiniteTangent, VCycle
from mammosim.mechanics.newton import System
from mammosim.mechanics.potential import Potential
from mammosim.mechanics.solvers import DirectSolver, MultigridSolver

DOWN = np.array([0.0, 0.0, 1.0])


def tissue(E=1.0, nu=0.45):
    return {Label.ADIPOSE: Tissue(E, nu, 1.0)}


@pytest.fixture
def always_multigrid(monkeypatch):
    monkeypatch.setattr(solvers, "MULTIGRID_ABOVE", 0)


def cube(n, nu=0.45, held=None):
    """The system of a cube of 30 mm with n bricks along each edge and a skin, and its tangent at rest."""
    mesh = box((n, n, n), (30.0, 30.0, 30.0))
    potential = Potential(body_effects(mesh, tissue(nu=nu), skin=Skin(10.0, 0.45, 1.5)))
    system = System.of(potential, held_nodes(mesh) if held is None else held(mesh))
    return mesh, system, potential.tangent(mesh.points, system.pattern)


def multigrid(mesh, system):
    return MultigridSolver(system.pattern, mesh.cells, system.rows, system.held)


def rollers(mesh):
    """Each face at 0 is held along its normal only, so that nodes have none to three free components."""
    return np.isclose(mesh.points, 0.0)


@pytest.mark.parametrize("held", [None, rollers])
def test_the_v_cycle_is_symmetric_and_positive_definite(held):
    mesh, system, K = cube(2, held=held)
    cycle = VCycle(system.pattern, mesh.cells, system.held)
    cycle.prepare(K)
    entries, n = system.rows.entries, len(system.rows.free)
    M_inverse = np.empty((n, n))
    for i in range(n):
        e = np.zeros(system.held.size)
        e[entries[i]] = 1.0
        M_inverse[:, i] = cycle(e.reshape(-1, 3)).ravel()[entries]
    # Rounding of about 30 sums per row, in single precision.
    assert np.abs(M_inverse - M_inverse.T).max() < 30 * 2.0**-24 * np.abs(M_inverse).max()
    eigenvalues = np.linalg.eigvalsh((M_inverse + M_inverse.T) / 2)
    assert eigenvalues[0] > 0
    # A smoother that does not amplify, and an exact coarse correction, leave M^-1 K at most 1.
    free = np.ix_(system.rows.free, system.rows.free)
    spectrum = np.linalg.eigvals(M_inverse @ K.to_csr().toarray()[free]).real
    assert spectrum.min() > 0.05
    assert spectrum.max() < 1 + 1e-5
    nodes = np.repeat(np.arange(K.pattern.n_node), 3)
    D = np.where(nodes[:, None] == nodes[None, :], K.to_csr().toarray(), 0.0)[free]
    assert np.linalg.eigvals(M_inverse @ D).real.min() > cycle.least


def test_the_coarse_matrix_is_the_galerkin_product():
    mesh, system, K = cube(2, held=rollers)
    level = VCycle(system.pattern, mesh.cells, system.held).level
    P = np.zeros((len(mesh.points), 3, len(level.held), 3))
    for i, parents in zip(system.pattern.order, level.parents):
        for a in parents:
            for c in range(3):
                P[i, c, a, c] += 0.5 * ~system.held[i, c]
    P = P.reshape(3 * len(mesh.points), -1)[:, level.rows.free]
    expected = np.triu(P.T @ K.to_csr().toarray() @ P)
    found = np.zeros_like(expected)
    values = level.restricted(K, ~system.held[system.pattern.order])
    for i in range(len(level.rows.free)):
        span = slice(level.rows.row_start[i], level.rows.row_start[i + 1])
        found[i, level.rows.columns[span]] = values[span]
    assert found == pytest.approx(expected, abs=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize(("nu", "most"), [(0.45, 25), (0.495, 60)])
def test_iterations_do_not_grow_with_refinement(nu, most):
    counts = []
    for n in (3, 6):
        mesh, system, K = cube(n, nu)
        b = generator("refinement").standard_normal(len(system.rows.free))
        solver = multigrid(mesh, system)
        x = solver.solve(K, b, 1e-8)
        residual = (K.to_csr() @ system.spread(x).ravel())[system.rows.free] - b
        assert np.linalg.norm(residual) <= 1.01e-8 * np.linalg.norm(b)
        counts.append(solver.iterations)
        solver.release()
    assert max(counts) <= most
    assert counts[1] <= 1.3 * counts[0]


def test_a_hundredfold_bulk_modulus_costs_what_two_digits_of_the_residual_cost():
    """The residual counts volumes k times over; nothing else of nu -> 0.5 reaches the iterations."""
    counts = []
    for nu, tolerance in ((0.4999, 1e-8), (0.499999, 1e-6)):
        mesh, system, K = cube(4, nu)
        b = generator("incompressible").standard_normal(len(system.rows.free))
        solver = multigrid(mesh, system)
        x = solver.solve(K, b, tolerance)
        residual = (K.to_csr() @ system.spread(x).ravel())[system.rows.free] - b
        assert np.linalg.norm(residual) <= 1.01 * tolerance * np.linalg.norm(b)
        assert solver.stability == "Lanczos"
        counts.append(solver.iterations)
        solver.release()
    assert counts[1] <= counts[0]


def test_a_tangent_in_used_memory_is_the_same():
    mesh, system, K = cube(2)
    before = K.blocks.copy()
    K.give_back()
    again = system.potential.tangent(mesh.points, system.pattern)
    assert np.array_equal(again.blocks, before)


@pytest.mark.parametrize(("E", "nu"), [(1.0, 0.45), (0.4, 0.45), (0.5, 0.495)])
def test_the_equilibrium_is_that_of_the_direct_solver(E, nu, monkeypatch):
    mesh = box((3, 3, 3), (40.0, 40.0, 40.0))
    direct = load(mesh, tissue(E, nu), DOWN)
    monkeypatch.setattr(solvers, "MULTIGRID_ABOVE", 0)
    iterative = load(mesh, tissue(E, nu), DOWN)
    assert (direct.stability, iterative.stability) == ("inertia", "Lanczos")
    assert direct.cg_iterations == 0
    assert iterative.cg_iterations > 0
    assert iterative.residual <= 1e-8
    # Residuals of 1e-8 of the load leave a few 1e-8 of displacements of up to 30 mm.
    assert iterative.points == pytest.approx(direct.points, abs=3e-6)


def a_layer(mesh):
    """All nodes of the bricks at one side: the pressures there belong to cells that cannot deform."""
    return np.repeat((mesh.points[:, 0] >= 20.0 - 1e-9)[:, None], 3, axis=1)


def test_cells_that_are_held_all_over_have_no_pressure_to_find():
    mesh, system, K = cube(3, nu=0.495, held=a_layer)
    b = generator("held cells").standard_normal(len(system.rows.free))
    x = multigrid(mesh, system).solve(K, b, 1e-8)
    assert x == pytest.approx(
        DirectSolver(system.rows).solve(K, b, 1e-8), rel=1e-5, abs=1e-6 * np.abs(x).max()
    )


@pytest.mark.parametrize("shift", [0.5, 0.9, 1.1, 2.0])
def test_an_indefinite_tangent_is_found_wherever_the_inertia_says_so(shift):
    """K - shift lambda 1, lambda the smallest eigenvalue of K: one smooth mode turns negative above 1."""
    mesh, system, K = cube(3)
    free = np.ix_(system.rows.free, system.rows.free)
    smallest = np.linalg.eigvalsh(K.to_csr().toarray()[free])[0]
    nodes = np.repeat(np.arange(K.pattern.n_node), np.diff(K.pattern.row_start))
    K.blocks[nodes == K.pattern.columns] -= shift * smallest * np.eye(3)
    solver = multigrid(mesh, system)
    assert solver.is_definite(K) == (shift < 1)
    assert DirectSolver(system.rows).is_definite(K) == (shift < 1)
    if shift > 1.5:
        with pytest.raises(IndefiniteTangent):
            solver.solve(K, generator("indefinite").standard_normal(len(system.rows.free)), 1e-8)


def test_too_many_iterations_end_in_a_factorisation(always_multigrid, monkeypatch):
    monkeypatch.setattr(solvers, "MAX_ITERATIONS", 3)
    mesh = box((2, 2, 2), (40.0, 40.0, 40.0))
    state = load(mesh, tissue(), DOWN)
    assert state.stability == "inertia"
    assert state.points == pytest.approx(load(mesh, tissue(), DOWN).points, abs=1e-6)


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="one thread only")
def test_one_and_two_threads_give_the_same_bits_under_the_v_cycle():
    mesh, system, K = cube(5)
    b = generator("bits").standard_normal(len(system.rows.free))
    before, found = numba.get_num_threads(), []
    try:
        for threads in (1, 2, 2):
            numba.set_num_threads(threads)
            solver = multigrid(mesh, system)
            found.append(solver.solve(K, b, 1e-8))
            solver.release()
    finally:
        numba.set_num_threads(before)
    assert np.array_equal(found[0], found[1])
    assert np.array_equal(found[1], found[2])
