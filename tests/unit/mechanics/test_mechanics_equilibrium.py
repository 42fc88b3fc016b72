"""An equilibrium is verified, or the solver fails; ill-posed problems are rejected before assembly."""

from dataclasses import replace

import numpy as np
import pytest
from mechanics_bodies import box

from mammosim.core.errors import EquilibriumError, MechanicsError
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import Skin, body_effects, load
from mammosim.mechanics.equilibrium import Settings, equilibrium
from mammosim.mechanics.newton import NewtonSettings
from mammosim.mechanics.reference import cell_quadrature, smallest_jacobians

SOFT = {Label.ADIPOSE: Tissue(1.0, 0.45, 1.0)}
DOWN = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def mesh():
    """A block of 40 mm, held at z = 0."""
    return box((2, 2, 2), (40.0, 40.0, 40.0))


def test_without_load_nothing_moves(mesh):
    state = equilibrium(mesh, body_effects(mesh, SOFT, skin=Skin(10.0, 0.45, 1.5)))
    assert np.array_equal(state.points, mesh.points)
    assert state.positive_definite


def test_an_equilibrium_carries_its_verification(mesh):
    state = load(mesh, SOFT, DOWN)
    assert state.residual <= NewtonSettings().tolerance
    assert state.positive_definite
    assert 0 < state.smallest_J < 1.5
    # One factorisation an iteration, and one of the exact tangent at the end.
    assert state.factorisations == len(state.history)
    residuals = [row.residual for row in state.history]
    assert residuals[0] == pytest.approx(1.0)
    assert residuals[-1] == state.residual
    assert np.array_equal(state.points[mesh.boundary_nodes("posterior")], held_points(mesh))


def held_points(mesh):
    return mesh.points[mesh.boundary_nodes("posterior")]


def test_the_state_does_not_depend_on_steps_or_start(mesh):
    direct = load(mesh, SOFT, DOWN)
    stepped = load(mesh, SOFT, DOWN, settings=Settings(load_steps=4))
    stiff = load(mesh, {Label.ADIPOSE: Tissue(2.0, 0.45, 1.0)}, DOWN)
    warm = load(mesh, SOFT, DOWN, start=stiff.points)
    # Residuals of 1e-8 of the load leave about 1e-8 of the displacement, here of the order of 5 mm.
    assert stepped.points == pytest.approx(direct.points, abs=1e-6)
    assert warm.points == pytest.approx(direct.points, abs=1e-6)


def test_a_useless_start_is_dropped(mesh):
    inverted = np.where(
        np.isin(np.arange(len(mesh.points)), mesh.boundary_nodes("posterior"))[:, None], 1, -1
    )
    state = load(mesh, SOFT, DOWN, start=mesh.points * inverted)
    assert state.points == pytest.approx(load(mesh, SOFT, DOWN).points, abs=1e-6)


def test_the_same_body_turned_gives_the_same_answer_turned(mesh):
    turn = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    turned = mesh.moved_to(mesh.points @ turn.T)
    expected = load(mesh, SOFT, DOWN).points @ turn.T
    assert load(turned, SOFT, turn @ DOWN).points == pytest.approx(expected, abs=1e-6)


def test_twice_the_stiffness_and_density_is_the_same_shape(mesh):
    double = {Label.ADIPOSE: Tissue(2.0, 0.45, 2.0)}
    assert load(mesh, double, DOWN).points == pytest.approx(load(mesh, SOFT, DOWN).points, abs=1e-6)


def test_lost_stability_is_an_error_that_says_how_far_it_came():
    """A tall soft column standing on its base buckles: its weight is far above the heavy elastica's limit."""
    column = box((1, 1, 6), (10.0, 10.0, 90.0))
    column = column.moved_to(column.points + [0.02, 0.0, 0.0] * (column.points[:, 2:] / 90.0) ** 2)
    with pytest.raises(EquilibriumError, match="stability") as caught:
        load(column, {Label.ADIPOSE: Tissue(0.3, 0.45, 1.0)}, -DOWN)
    # Euler under its own weight: rho g A L^3 / (E I) = 7.84, I = A w^2 / 12.
    critical = 7.84 * 0.3 * 10.0**2 / 12 / (9.81e-3 * 90.0**3)
    assert caught.value.load_factor < 2 * critical
    assert len(caught.value.history) > 0


def test_too_few_iterations_are_an_error_not_an_answer(mesh):
    settings = Settings(newton=NewtonSettings(max_iterations=1), smallest_step=0.9)
    with pytest.raises(EquilibriumError, match="iterations left a residual"):
        load(mesh, SOFT, DOWN, settings=settings)


def inverted(mesh):
    cells = mesh.cells.copy()
    cells[7] = cells[7, [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]]
    return replace(mesh, cells=cells)


def flat(mesh):
    points = mesh.points.copy()
    cell = mesh.cells[7]
    points[cell] = points[cell[0]]
    return mesh.moved_to(points)


def bent(mesh):
    """A mid-edge node of one outer edge at the corner: positive at the four integration points, not there."""
    points = mesh.points.copy()
    a, b, middle = mesh.cells[7, [0, 1, 4]]
    points[middle] = 0.8 * points[a] + 0.2 * points[b]
    return mesh.moved_to(points)


def not_finite(mesh):
    points = mesh.points.copy()
    points[5, 1] = np.nan
    return mesh.moved_to(points)


def unattached(mesh):
    n = len(mesh.points)
    away = TetMesh(
        np.vstack([mesh.points, mesh.points + 100.0]),
        np.vstack([mesh.cells, mesh.cells + n]),
        np.tile(mesh.tissue, 2),
        mesh.boundaries,
    )
    return away


def with_loose_node(mesh):
    return mesh.moved_to(np.vstack([mesh.points, [[1.0, 2.0, 3.0]]]))


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (inverted, "1 cells are inverted or flat .*7"),
        (flat, "cells are inverted or flat"),
        (bent, r"cells are inverted or flat \(det dX/dxi down to -.*7"),
        (not_finite, "1 nodes have coordinates that are no numbers: 5"),
        (unattached, r"1 pieces of the mesh \(48 cells: 48, 49"),
        (with_loose_node, "1 nodes belong to no cell"),
        (lambda mesh: replace(mesh, boundaries={"skin": mesh.boundaries["skin"]}), "no boundary 'posterior'"),
        (
            lambda mesh: replace(mesh, boundaries={"posterior": mesh.boundaries["posterior"][:0]}),
            "'posterior' is empty",
        ),
    ],
)
def test_ill_posed_problems_are_rejected_by_name(mesh, spoil, message):
    effects = body_effects(mesh, SOFT)
    with pytest.raises(MechanicsError, match=message):
        equilibrium(spoil(mesh), effects)


def test_a_cell_that_is_inverted_only_between_its_integration_points_is_seen(mesh):
    spoilt = bent(mesh)
    spoilt_cells = np.any(np.isin(spoilt.cells, spoilt.cells[7, 4]), axis=1)
    assert cell_quadrature(spoilt.points, spoilt.cells).volumes.min() > 0
    assert np.array_equal(smallest_jacobians(spoilt.points, spoilt.cells) <= 0, spoilt_cells)


@pytest.mark.parametrize(
    ("E", "nu", "density", "message"),
    [
        (1.0, 0.5, 1.0, r"poisson_ratio = 0.5 is outside \[0, 0.5\)"),
        (-1.0, 0.45, 1.0, r"youngs_modulus_kpa = -1 is outside \(0, "),
        (1.0, 0.45, -1.0, "density_g_cm3 = -1 is negative"),
        (np.nan, 0.45, 1.0, "youngs_modulus_kpa = nan is outside"),
        (1.0, np.nan, 1.0, "poisson_ratio = nan is outside"),
        (1.0, 0.45, np.nan, "density_g_cm3 = nan"),
    ],
)
def test_impossible_tissue_is_rejected_by_its_value(E, nu, density, message):
    with pytest.raises(MechanicsError, match=message):
        Tissue(E, nu, density)


def test_a_tissue_without_parameters_is_rejected_by_name(mesh):
    glandular = replace(mesh, tissue=np.full(len(mesh.cells), int(Label.GLANDULAR)))
    with pytest.raises(MechanicsError, match="'glandular' is in the mesh but has no parameters"):
        load(glandular, SOFT, DOWN)
