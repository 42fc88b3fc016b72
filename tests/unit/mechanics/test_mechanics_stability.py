"""Where stability is lost: how far the load came, how the tissue moves, and what would help."""

from dataclasses import dataclass

import numpy as np
import pytest
from mechanics_bodies import box

from mammosim.core.errors import EquilibriumError
from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import Skin, body_effects, load
from mammosim.mechanics.effects import NeoHookean, Weight
from mammosim.mechanics.equilibrium import held_nodes
from mammosim.mechanics.loading import advice, lowest_mode
from mammosim.mechanics.newton import NewtonSettings, System, converge
from mammosim.mechanics.potential import Potential, energy_imbalance

DOWN = np.array([0.0, 0.0, 1.0])
E_FALLEN = 0.2


def tissue(E):
    return {Label.ADIPOSE: Tissue(E, 0.45, 1.0)}


@pytest.fixture(scope="module")
def column():
    return box((1, 1, 4), (10.0, 12.0, 60.0))


@pytest.fixture(scope="module")
def cube():
    return box((2, 2, 2), (40.0, 40.0, 40.0))


@pytest.fixture(scope="module")
def fallen(cube):
    """A cube that hangs from its face, so soft that the load would stretch it more than twofold."""
    with pytest.raises(EquilibriumError, match="stability is lost between") as caught:
        load(cube, tissue(E_FALLEN), DOWN)
    return caught.value


@pytest.mark.parametrize("nu", [0.45, 0.495])
def test_the_lowest_mode_is_that_of_the_whole_spectrum(column, nu):
    potential = Potential(body_effects(column, {Label.ADIPOSE: Tissue(1.0, nu, 1.0)}))
    with System.of(potential, held_nodes(column)) as system:
        mode = lowest_mode(system, column.points, column.points)
        free = system.rows.free
        K = potential.tangent(column.points, system.pattern).to_csr()[free][:, free].toarray()
    # The Rayleigh quotient has settled to 1e-3.
    assert mode.eigenvalue == pytest.approx(np.linalg.eigvalsh(K)[0], rel=5e-3)
    assert np.linalg.norm(mode.shape, axis=1).max() == pytest.approx(1.0)
    assert np.all(mode.shape[column.boundary_nodes("posterior")] == 0.0)


def test_stability_is_lost_where_the_lowest_eigenvalue_vanishes(cube, fallen):
    """One step of the load, 1/64 of it, further the symmetric equilibrium is a saddle."""
    eigenvalues = []
    potential = Potential(body_effects(cube, tissue(E_FALLEN)), (Weight.of(cube, tissue(E_FALLEN), DOWN),))
    with System.of(potential, held_nodes(cube)) as system:
        x = cube.points
        for load_factor in (0.25, 0.5, fallen.load_factor, fallen.load_factor * (1 + 1 / 32)):
            under = system.under(load_factor)
            x = converge(under, x, NewtonSettings(tolerance=1e-6), [])
            eigenvalues.append(lowest_mode(under, x, cube.points).eigenvalue)
    assert np.all(np.diff(eigenvalues) < 0)
    assert eigenvalues[2] > 0 > eigenvalues[3]


def test_the_mode_breaks_the_symmetry_of_the_cube(cube, fallen):
    """The load is symmetric about the diagonal x = y, and so is the path; the mode is across it."""
    most = np.argmax(np.linalg.norm(fallen.mode, axis=1))
    assert np.abs(fallen.mode[most] @ np.array([1.0, -1.0, 0.0]) / np.sqrt(2)) > 0.99
    assert np.all(fallen.mode[cube.boundary_nodes("posterior")] == 0.0)


def test_a_diagnosis_is_cheap_and_says_what_helps(fallen):
    # Six halvings that end at the first indefinite tangent, as many steps between, 20 iterations beyond.
    assert len(fallen.history) < 90
    words = str(fallen)
    for part in ("the tissue gives way as a whole, most at", "add skin", "times larger"):
        assert part in words


def test_the_stiffness_that_is_advised_suffices(cube, fallen):
    state = load(cube, tissue(1.05 * E_FALLEN / fallen.load_factor), DOWN)
    assert state.positive_definite


def test_a_column_stands_up_to_eulers_load(column):
    """Under its own weight: rho g A L^3 / (E I) = 7.84, I = A w^2 / 12; 5 % less for shear in a stout one.

    The mesh is not symmetric: beyond that load it bends, without losing its stability at once.
    """
    euler = 7.84 * 3.0 * 10.0**2 / 12 / (9.81e-3 * 60.0**3)
    with pytest.raises(EquilibriumError, match="stability is lost") as caught:
        load(column, tissue(3.0), -DOWN)
    assert caught.value.load_factor > 0.95 * euler


@pytest.mark.parametrize(
    ("skin", "gravity", "helps", "does_not"),
    [
        (Skin(10.0, 0.45, 1.5), -DOWN, "stiffer or thicker; or let the chest wall", "add skin"),
        (None, -DOWN, "add skin, which holds soft tissue; or let the chest wall", "stiffer or thicker"),
        (None, DOWN, "add skin", "chest wall"),
    ],
)
def test_advice_depends_on_skin_and_on_where_the_load_presses(column, skin, gravity, helps, does_not):
    loads = (Weight.of(column, tissue(1.0), gravity),)
    potential = Potential(body_effects(column, tissue(1.0), skin=skin), loads)
    with System.of(potential, held_nodes(column)) as system:
        words = advice(system, column.points, 0.5)
    assert helps in words
    assert does_not not in words
    assert "2.1 times larger" in words


@dataclass(frozen=True)
class WithWrongGradient(NeoHookean):
    """A bulk whose forces are 5 % too large."""

    def add_gradient(self, x, g):
        part = np.zeros_like(g)
        super().add_gradient(x, part)
        g += 1.05 * part


def test_forces_that_are_not_those_of_the_energy_show_in_the_balance(column):
    state = load(column, tissue(20.0), DOWN)
    assert state.energy_imbalance < 1e-6
    assert state.load_factors == (0.0, 1.0)
    (bulk,) = body_effects(column, tissue(20.0))
    wrong = WithWrongGradient(bulk.cells, bulk.quadrature, bulk.mu, bulk.k)
    path = [column.points, state.points]
    assert energy_imbalance(Potential((wrong,)), path) == pytest.approx(0.05, rel=1e-3)
    loads = (Weight.of(column, tissue(20.0), DOWN),)
    assert energy_imbalance(Potential((bulk,), loads), path) == state.energy_imbalance


def test_a_path_through_an_inverted_body_has_no_balance(column):
    """From a body to its mirror image, the straight line passes one without width."""
    mirrored = column.points * [-1.0, 1.0, 1.0]
    potential = Potential(body_effects(column, tissue(1.0)))
    path = [column.points, 1.1 * column.points, mirrored]
    assert energy_imbalance(potential, path) == np.inf


def test_memory_is_that_of_the_process_and_its_factors(column):
    state = load(column, tissue(20.0), DOWN)
    assert 0 < state.solver_mb < state.memory_mb
