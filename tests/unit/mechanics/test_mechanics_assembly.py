"""The tangent is assembled into one pattern, the same to the last bit for any number of threads."""

import ctypes

import numpy as np
import pytest
from mechanics_bodies import box
from pypardiso import PyPardisoSolver

from mammosim.core.labels import Label
from mammosim.core.rng import generator
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import Skin, body_effects
from mammosim.mechanics.linear import SymmetricSolver
from mammosim.mechanics.pattern import Tangent, pattern_of, upper_rows
from mammosim.mechanics.potential import Potential


@pytest.fixture(scope="module")
def mesh():
    return box((3, 3, 3), (10.0, 12.0, 9.0))


@pytest.fixture(scope="module")
def potential(mesh):
    return Potential(body_effects(mesh, {Label.ADIPOSE: Tissue(1.0, 0.45, 1.0)}, skin=Skin(10.0, 0.45, 1.5)))


def test_gathering_is_the_sum_of_the_element_tangents():
    elements = np.array([[0, 1, 2], [1, 2, 3]])
    Ke = generator("assembly").standard_normal((2, 3, 3, 3, 3))
    K = Tangent.zero(pattern_of(4, [elements]))
    K.add(elements, Ke)
    expected = np.zeros((4, 3, 4, 3))
    for e, nodes in enumerate(elements):
        for a, node in enumerate(nodes):
            for b, other in enumerate(nodes):
                expected[node, :, other] += Ke[e, a, b]
    assert K.to_csr().toarray() == pytest.approx(expected.reshape(12, 12), abs=1e-14)


def test_the_upper_rows_are_the_free_part_of_the_matrix(mesh, potential):
    held = np.zeros(mesh.points.shape, dtype=bool)
    held[mesh.boundary_nodes("posterior"), 1:] = True
    pattern = pattern_of(len(mesh.points), [mesh.cells])
    rows, K = upper_rows(pattern, held), potential.tangent(mesh.points, pattern)
    free = rows.free
    assert np.array_equal(np.sort(free), np.flatnonzero(~held.ravel()))
    expected = np.triu(K.to_csr().toarray()[np.ix_(free, free)])
    found = np.zeros_like(expected)
    for i in range(len(free)):
        span = slice(rows.row_start[i], rows.row_start[i + 1])
        found[i, rows.columns[span]] = rows.values(K)[span]
    assert np.array_equal(found, expected)


def test_the_solver_counts_negative_eigenvalues_and_solves():
    rng = generator("inertia")
    Q, _ = np.linalg.qr(rng.standard_normal((30, 30)))
    eigenvalues = np.r_[np.full(4, -1.0), np.linspace(1.0, 5.0, 26)]
    A = Q @ np.diag(eigenvalues) @ Q.T
    rows, columns = np.triu_indices(30)
    starts = np.searchsorted(rows, np.arange(31)).astype(np.int32)
    b = rng.standard_normal(30)
    with SymmetricSolver(starts, columns.astype(np.int32)) as solver:
        assert not solver.factorise(A[rows, columns])
        assert solver.negative_pivots == 4
        assert solver.solve(b) == pytest.approx(np.linalg.solve(A, b), rel=1e-10)
        B = A + 2 * np.eye(30)
        assert solver.factorise(B[rows, columns])
        assert solver.solve(b) == pytest.approx(np.linalg.solve(B, b), rel=1e-10)
        assert solver.factorisations == 2


def test_the_solver_gives_the_same_bits_in_every_run_and_for_any_number_of_threads():
    mesh = box((6, 6, 6), (30.0, 30.0, 30.0))
    potential = Potential(body_effects(mesh, {Label.ADIPOSE: Tissue(1.0, 0.45, 1.0)}))
    pattern = pattern_of(len(mesh.points), [mesh.cells])
    held = np.zeros(mesh.points.shape, dtype=bool)
    held[mesh.boundary_nodes("posterior")] = True
    rows = upper_rows(pattern, held)
    values = rows.values(potential.tangent(mesh.points, pattern))
    b = generator("bits").standard_normal(len(rows.free))
    library = ctypes.CDLL(PyPardisoSolver().libmkl._name)
    found = []
    for threads in (1, 2, 2):
        before = library.MKL_Set_Num_Threads_Local(threads)
        with SymmetricSolver(rows.row_start, rows.columns) as solver:
            solver.factorise(values)
            found.append(solver.solve(b))
        library.MKL_Set_Num_Threads_Local(before)
    assert np.array_equal(found[0], found[1])
    assert np.array_equal(found[1], found[2])
