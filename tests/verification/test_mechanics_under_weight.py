"""Bodies under their weight against exact one-dimensional solutions, forward and inverse, with rates."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from mechanics_bodies import box
from mechanics_references import TIGHT, rows, unit_tissue
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

from mammosim.core.units import KPA_PER_MM_PER_G_CM3
from mammosim.mechanics.body import Body, body_effects
from mammosim.mechanics.effects import Weight
from mammosim.mechanics.equilibrium import equilibrium
from mammosim.mechanics.reference import CELL_SHAPES, cell_quadrature
from mammosim.mechanics.unloaded import UnloadingSettings
from mammosim.mechanics.unloading import METHODS

LENGTH = 60.0
AWAY = np.array([0.0, 0.0, 1.0])


def name_of(case):
    return "-".join(str(value) for value in case[:3])


def column(n):
    """n elements long and one wide, with its lateral faces as skin and the held end as posterior."""
    return box((1, 1, n), (LENGTH / n, LENGTH / n, LENGTH))


def weigh(mesh, case, start=None):
    """The column of one row of the table: nothing moves sideways."""
    tissue = unit_tissue(case.nu, density=case.q / (KPA_PER_MM_PER_G_CM3 * LENGTH))
    held = np.ones(mesh.points.shape, dtype=bool)
    held[:, 2] = np.isclose(mesh.points[:, 2], 0.0)
    gravity = AWAY if case.case == "hang" else -AWAY
    weight = Weight.of(mesh, tissue, gravity)
    loads = () if start is not None else (weight,)
    effects = (*body_effects(mesh, tissue), *(() if loads else (weight,)))
    return equilibrium(mesh, effects, loads=loads, held=held, start=start, settings=TIGHT)


def end_of(mesh, points):
    return points[np.isclose(mesh.points[:, 2], mesh.points[:, 2].max()), 2].mean()


@pytest.mark.parametrize("case", rows("column"), ids=name_of)
def test_a_column_under_its_weight(case):
    mesh = column(8)
    tip = end_of(mesh, weigh(mesh, case).points - mesh.points) / LENGTH
    # (1/8)^4 of the variation of the strain, which is up to 2.
    assert tip == pytest.approx(case.tip, rel=2e-4)


def integrated(slopes, places):
    """The integral (n, m) of slopes(s) (m,) from 0 to each of the places (n,) in [0, 1]."""
    different, which = np.unique(places, return_inverse=True)
    zero = np.zeros_like(slopes(0.0))
    flow = solve_ivp(lambda s, _: slopes(s), (0, 1), zero, dense_output=True, rtol=1e-10, atol=1e-13)
    return flow.sol(different).T[which]


def bulk_over_shear(nu):
    return 2 * (1 + nu) / (3 * (1 - 2 * nu))


def exact_column(case, places):
    """u / L (n,) at X / L = places: P = q (1 - X / L), P the nominal stress over mu of F = diag(1, 1, c)."""
    k = bulk_over_shear(case.nu)

    def slopes(s):
        def excess(c):
            return c ** (-2 / 3) * (c - (2 + c**2) / (3 * c)) + k * (c - 1) - case.q * (1 - s)

        return np.array([brentq(excess, 0.5, 4.0, xtol=1e-14) - 1])

    return integrated(slopes, places)[:, 0]


@pytest.mark.parametrize("nu", [0.3, 0.45, 0.49, 0.495])  # at 0.499 the errors are those of rounding, 1e-11
def test_the_field_of_a_column_converges_at_third_order(nu):
    """Quadratic elements: the displacement's error in the L2 norm falls as h^3, whatever nu."""
    (case,) = rows("column", nu=nu, q=2.0, case="hang")
    assert exact_column(case, np.ones(1)) == pytest.approx(case.tip, rel=1e-6)
    errors = []
    for n in (2, 4, 8):
        mesh = column(n)
        u = (weigh(mesh, case).points - mesh.points)[mesh.cells][:, :, 2]
        z = np.einsum("qa,ea->eq", CELL_SHAPES, mesh.points[mesh.cells][:, :, 2])
        found = np.einsum("qa,ea->eq", CELL_SHAPES, u).ravel()
        errors.append(np.sqrt(np.mean((found / LENGTH - exact_column(case, z.ravel() / LENGTH)) ** 2)))
    assert np.log2(np.divide(errors[:-1], errors[1:])).min() > 2.8


@dataclass(frozen=True)
class Column(Body):
    """The column of one row of the table, as what is unloaded."""

    case: Any = None

    def load(self, mesh, gravity, *, start=None, settings=None):
        return weigh(mesh, self.case, start)


@pytest.mark.parametrize("method", ["fixed_point", "pull_back", "mean_start", "anderson"])
@pytest.mark.parametrize(
    "case",
    rows("column", nu=0.45, q=0.5) + rows("column", nu=0.3, q=2.0) + rows("column", nu=0.49, q=5.0),
    ids=name_of,
)
def test_the_stress_free_length_is_found(case, method):
    """The table's column is 1 long when loaded, so q is rho g / mu times that."""
    measured = column(4)
    found = METHODS[method](
        measured,
        Column({}, case=case),
        gravity=AWAY,
        start=measured.points,
        settings=UnloadingSettings(tolerance_mm=1e-3, max_iterations=60),
    )
    length = found.points[:, 2].max() / LENGTH
    # The tolerance is 2e-5 of the length; four elements leave (1/4)^4 of the variation of the strain.
    assert length == pytest.approx(case.rest_length, rel=1e-3)


# The layer: P_xX = 0 and P_yX = rho g (H - X) with F = [[stretch, 0], [gamma, 1]], nothing along z.


def stresses(stretch, gamma, k):
    """P_xX and P_yX over mu."""
    F = np.array([[stretch, 0, 0], [gamma, 1, 0], [0, 0, 1.0]])
    J, I1 = stretch, np.sum(F**2)
    P = J ** (-2 / 3) * (F - I1 / 3 * np.linalg.inv(F).T) + k * (J - 1) * J * np.linalg.inv(F).T
    return P[0, 0], P[1, 0]


def exact_layer(case, depths):
    """At depths X / H (n,): u_x, u_y over H (n, 2) and their slopes, stretch - 1 and gamma (n, 2)."""
    k = bulk_over_shear(case.nu)

    def slopes(depth):
        load = case.q * (1 - depth)
        found = root(lambda s: np.subtract(stresses(*s, k), (0.0, load)), (1.0, load), tol=1e-13)
        return found.x - [1.0, 0.0]

    different, which = np.unique(depths, return_inverse=True)
    return integrated(slopes, depths), np.array([slopes(depth) for depth in different])[which]


@pytest.mark.parametrize("case", rows("shear_layer"), ids=lambda case: f"{case.nu}-{case.q}")
def test_the_one_dimensional_solution_of_the_layer_is_the_tables(case):
    u, slopes = exact_layer(case, np.array([0.0, 1.0]))
    assert u[-1] == pytest.approx([case.thickening, case.sag], rel=1e-6, abs=1e-9)
    assert slopes[0] == pytest.approx([case.stretch - 1, case.gamma], abs=2e-9)


def layer_errors(case, n):
    """Of the displacement over H and of its gradient, root mean square, with n elements through the layer."""
    H = 10.0
    mesh = box((n, 2, 1), (H, 2 * H / n, H / n), posterior_axis=0)
    tissue = unit_tissue(case.nu, density=case.q / (KPA_PER_MM_PER_G_CM3 * H))
    x = mesh.points + H * np.pad(exact_layer(case, mesh.points[:, 0] / H)[0], ((0, 0), (0, 1)))
    # Sideways the layer goes on: its displacement is given there, and nothing moves along z.
    held = np.isclose(mesh.points[:, [0, 1, 1]], [0.0, 0.0, 2 * H / n]).any(axis=1)
    held = np.stack([held, held, np.ones_like(held)], axis=1)
    weight = Weight.of(mesh, tissue, np.array([0.0, 1.0, 0.0]))
    state = equilibrium(mesh, (*body_effects(mesh, tissue), weight), held=held, start=x, settings=TIGHT)
    moved = (state.points - mesh.points)[mesh.cells]
    at = np.einsum("qa,eai->eqi", CELL_SHAPES, mesh.points[mesh.cells]).reshape(-1, 3)
    u, strain = exact_layer(case, at[:, 0] / H)
    found = np.einsum("qa,eai->eqi", CELL_SHAPES, moved).reshape(-1, 3)[:, :2]
    slopes = np.einsum("eqaj,eai->eqij", cell_quadrature(mesh.points, mesh.cells).gradients, moved)
    slopes = slopes.reshape(-1, 3, 3)[:, :2, 0]
    return np.sqrt(np.mean((found / H - u) ** 2)), np.sqrt(np.mean((slopes - strain) ** 2))


@pytest.mark.parametrize(
    "case", [row for row in rows("shear_layer") if row.q == 2], ids=lambda row: f"{row.nu}"
)
def test_a_layer_that_sags_under_its_weight_converges_at_the_rates_of_its_elements(case):
    """h^3 in the displacement, h^2 in its gradient; on 8 elements within 0.1 % of the sag."""
    (coarse, coarse_slope), (fine, fine_slope) = (layer_errors(case, n) for n in (4, 8))
    assert np.log2(coarse / fine) > 2.7
    assert np.log2(coarse_slope / fine_slope) > 1.8
    assert fine < 1e-3 * case.sag
