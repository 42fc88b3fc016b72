"""Both libraries that factorise a tangent give the same answers: PARDISO, and RSLAB where there is no MKL."""

import ctypes
from contextlib import contextmanager
from importlib.util import find_spec

import numba
import numpy as np
import pytest
from mechanics_bodies import box

import mammosim as ms
from mammosim.core.errors import ConfigurationError
from mammosim.core.labels import Label
from mammosim.core.rng import generator
from mammosim.core.tissues import Tissue
from mammosim.mechanics import linear
from mammosim.mechanics.body import Skin, body_effects, load
from mammosim.mechanics.linear import CHOICE, PARDISO, RSLAB, SymmetricSolver, direct_solver
from mammosim.mechanics.pattern import pattern_of, upper_rows
from mammosim.mechanics.potential import Potential

DOWN = np.array([0.0, 0.0, 1.0])
ADIPOSE = Tissue(1.0, 0.45, 1.0)


def chosen(name, monkeypatch):
    if name == PARDISO and not find_spec("pypardiso"):
        pytest.skip("MKL is not made for this processor")
    monkeypatch.setenv(CHOICE, name)


@pytest.fixture(params=[PARDISO, RSLAB])
def library(request, monkeypatch):
    chosen(request.param, monkeypatch)
    return request.param


def factors_of(A, **options):
    """Of a full matrix: its solver, and its upper triangle by rows, zeros included."""
    n = len(A)
    rows, columns = np.triu_indices(n)
    starts = np.searchsorted(rows, np.arange(n + 1)).astype(np.int32)
    return SymmetricSolver(starts, columns.astype(np.int32), **options), A[rows, columns]


@pytest.fixture(scope="module")
def tangent():
    """A tangent of 882 unknowns with skin: its upper rows, and their values."""
    mesh = box((6, 6, 6), (30.0, 30.0, 30.0))
    potential = Potential(body_effects(mesh, {Label.ADIPOSE: ADIPOSE}, skin=Skin(10.0, 0.45, 1.5)))
    elements = [term.connectivity for term in potential.terms if len(term.connectivity)]
    pattern = pattern_of(len(mesh.points), elements)
    held = np.zeros(mesh.points.shape, dtype=bool)
    held[mesh.boundary_nodes("posterior")] = True
    rows = upper_rows(pattern, held)
    return rows, rows.values(potential.tangent(mesh.points, pattern))


def test_negative_eigenvalues_are_counted_and_systems_solved(library):
    rng = generator("inertia")
    Q, _ = np.linalg.qr(rng.standard_normal((30, 30)))
    A = Q @ np.diag(np.r_[np.full(4, -1.0), np.linspace(1.0, 5.0, 26)]) @ Q.T
    B = A + 2 * np.eye(30)
    b, several = rng.standard_normal(30), rng.standard_normal((30, 3))
    solver, values = factors_of(A)
    with solver:
        assert not solver.factorise(values)
        assert solver.negative_pivots == 4
        assert solver.solve(b) == pytest.approx(np.linalg.solve(A, b), rel=1e-10)
        assert solver.solve(several) == pytest.approx(np.linalg.solve(A, several), rel=1e-9, abs=1e-12)
        assert solver.factorise(factors_of(B)[1])
        assert solver.solve(b) == pytest.approx(np.linalg.solve(B, b), rel=1e-10)
        assert solver.factorisations == 2
        assert solver.memory_mb > 0


def test_pressures_as_unknowns_are_negative_pivots(library):
    """[[K, B^T], [B, -M]] of a definite K has as many negative eigenvalues as pressures."""
    rng = generator("saddle")
    K = np.eye(20) + 0.1 * np.ones((20, 20))
    B, M = rng.standard_normal((5, 20)), 1e-6 * np.eye(5)
    A, b = np.block([[K, B.T], [B, -M]]), rng.standard_normal(25)
    solver, values = factors_of(A)
    with solver:
        solver.factorise(values)
        assert solver.negative_pivots == 5
        assert A @ solver.solve(b) == pytest.approx(b, abs=1e-9)


def test_a_matrix_without_a_row_is_factorised_all_the_same(library):
    A = np.diag([1.0, 0.0, 2.0])
    solver, values = factors_of(A)
    with solver:
        solver.factorise(values)
        x = solver.solve(np.array([3.0, 0.0, 4.0]))
    assert x[[0, 2]] == pytest.approx([3.0, 2.0])
    assert np.isfinite(x).all()


def test_single_precision_is_enough_for_a_preconditioner(library, tangent):
    rows, values = tangent
    b = generator("single").standard_normal(len(rows.free))
    found = []
    for single in (False, True):
        with SymmetricSolver(rows.row_start, rows.columns, single=single) as solver:
            assert solver.factorise(values)
            found.append(solver.solve(b))
    assert [x.dtype for x in found] == [np.float64, np.float32]
    assert np.linalg.norm(found[1] - found[0]) < 1e-4 * np.linalg.norm(found[0])


@contextmanager
def threads(library, number):
    """This library on so many threads."""
    if library == RSLAB:
        before = numba.get_num_threads()
        numba.set_num_threads(number)
        yield
        numba.set_num_threads(before)
        return
    from pypardiso import PyPardisoSolver

    mkl = ctypes.CDLL(PyPardisoSolver().libmkl._name)
    before = mkl.MKL_Set_Num_Threads_Local(number)
    yield
    mkl.MKL_Set_Num_Threads_Local(before)


def test_the_same_bits_come_in_every_run_and_for_any_number_of_threads(library, tangent):
    if numba.config.NUMBA_NUM_THREADS < 2 and library == RSLAB:
        pytest.skip("numba was given one thread")
    rows, values = tangent
    b = generator("bits").standard_normal(len(rows.free))
    found = []
    for number in (1, 2, 2):
        with threads(library, number), SymmetricSolver(rows.row_start, rows.columns) as solver:
            solver.factorise(values)
            found.append(solver.solve(b))
    assert np.array_equal(found[0], found[1])
    assert np.array_equal(found[1], found[2])


def press(mesh):
    """A block of fat with skin between two plates, to four fifths of its height."""
    body = ms.Body({Label.ADIPOSE: ADIPOSE}, (ms.Skin(10.0, 0.45, 1.45),))
    plates = ms.Plates(
        centre=np.array([15.0, 25.0, 15.0]),
        axes=np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
        half_sizes=np.array([15.0, 25.0, 6.0]),
        edge_radius_mm=5.0,
    )
    return ms.compress(mesh, body.effects(mesh), plates=plates, control=ms.Thickness(24.0))


def test_a_press_is_the_same_by_both(monkeypatch):
    """Both solve each system to rounding: Newton's tolerance of 1e-8 is left between the answers."""
    mesh = ms.meshing.shapes.box((3, 3, 3), (30.0, 30.0, 30.0), posterior_axis=1)
    found = {}
    for name in (PARDISO, RSLAB):
        chosen(name, monkeypatch)
        found[name] = press(mesh)
    one, other = found[PARDISO], found[RSLAB]
    assert len(one.path) == len(other.path)
    assert one.path.force_n.to_numpy() == pytest.approx(other.path.force_n.to_numpy(), rel=1e-6)
    assert one.points == pytest.approx(other.points, abs=1e-6)


def test_the_hanging_of_nearly_incompressible_tissue_is_the_same_by_both(monkeypatch):
    mesh = box((2, 2, 2), (40.0, 40.0, 40.0))
    found = []
    for name in (PARDISO, RSLAB):
        chosen(name, monkeypatch)
        found.append(load(mesh, {Label.ADIPOSE: Tissue(1.0, 0.4999, 1.0)}, DOWN).points)
    assert found[0] == pytest.approx(found[1], abs=1e-6)


def test_another_library_is_taken_where_mkl_is_not_installed(monkeypatch):
    monkeypatch.delenv(CHOICE, raising=False)
    monkeypatch.setattr(linear, "find_spec", lambda name: None)
    assert direct_solver() == RSLAB
    monkeypatch.setattr(linear, "find_spec", lambda name: object())
    assert direct_solver() == PARDISO


def test_a_library_that_is_not_there_is_refused_by_name(monkeypatch):
    monkeypatch.setenv(CHOICE, "mumps")
    with pytest.raises(ConfigurationError, match=f"{CHOICE} is 'mumps': pardiso .* or rslab can be chosen"):
        direct_solver()
    monkeypatch.setenv(CHOICE, PARDISO)
    monkeypatch.setattr(linear, "find_spec", lambda name: None)
    with pytest.raises(ConfigurationError, match="pypardiso is not installed: choose rslab"):
        direct_solver()
