"""From draws of moduli to intervals of what follows."""

import numpy as np
import pandas as pd
import pytest

from mammosim.core.errors import EquilibriumError, MechanicsError
from mammosim.core.fiducials import Fiducials
from mammosim.mechanics.body import Body
from mammosim.mechanics.unloaded import Unloaded
from mammosim.study.identification.propagation import (
    by_stiffness,
    expected_share_percent,
    nipple_table,
    position_rows,
    pressed_rows,
    repositioned,
    stored_energy,
)
from mammosim.study.sweep import one_law

SUPINE, PRONE = np.array([0.0, 1, 0]), np.array([0.0, -1, 0])


def law(E):
    return Body(one_law(E, poisson_ratio=0.45, muscle_kpa=30.0, density_g_cm3=1.0))


def loaded_backwards(measured, body, *, gravity, start=None):
    """Reverse gravity, as a method of unloading that needs one solve."""
    if body.tissues[1].youngs_modulus_kpa < 1:
        raise EquilibriumError("too soft to be unloaded")
    return Unloaded(body.load(measured, -gravity, start=start).points)


def test_softer_draws_move_further_and_one_that_failed_has_no_place(block):
    mesh = block(2)
    bodies = [law(E) for E in (20.0, 10.0, 0.5, 20.0)]
    draws = repositioned(
        mesh, bodies, unload=loaded_backwards, gravity=PRONE, new_gravity=SUPINE, rest=mesh.points
    )
    nipple = np.array([15.0, 0.0, 15.0])
    table = nipple_table(mesh, {"left": nipple}, draws).set_index("draw")
    way = table.nipple_y_mm - nipple[1]
    assert way[1] == pytest.approx(2 * way[0], rel=0.1)  # linear in 1/E up to a strain of 3 %
    assert np.isnan(way[2])
    assert table.outcome[2] == "failed: too soft to be unloaded"
    # The same body from another starting point: the residual's tolerance is 1e-7 of the load.
    assert way[3] == pytest.approx(way[0], abs=1e-5)


def test_energy_in_a_given_shape_is_linear_in_the_moduli(block):
    mesh = block(2)
    x = mesh.points * [1.1, 0.95, 1.0]
    assert stored_energy(law(6.0), mesh, x) == pytest.approx(2 * stored_energy(law(3.0), mesh, x))


def test_draws_are_pressed_from_the_softest_to_the_stiffest_and_never_the_fit():
    energies = np.array([0.0, 5.0, 9.0, np.nan, 1.0, 7.0, 3.0])
    np.testing.assert_array_equal(by_stiffness(energies, 3), [4, 1, 2])
    np.testing.assert_array_equal(by_stiffness(energies, 1), [1])
    np.testing.assert_array_equal(by_stiffness(energies, 5), [4, 6, 1, 5, 2])
    with pytest.raises(MechanicsError, match="5 beside the fit"):
        by_stiffness(energies, 6)


def test_the_least_and_greatest_of_n_draws_hold_n_minus_1_of_n_plus_1_on_average():
    n, repeats = 23, 4000
    drawn = np.random.default_rng(8).random((repeats, n))
    share = 100 * (drawn.max(axis=1) - drawn.min(axis=1))
    standard_error = share.std() / np.sqrt(repeats)
    assert abs(share.mean() - expected_share_percent(n)) < 4 * standard_error


def test_intervals_hold_the_fit_and_count_the_draws_that_were_solved():
    nipples = pd.DataFrame({
        "draw": range(4), "side": "left", "nipple_x_mm": [1.0, 2.0, np.nan, -1.0],
        "nipple_y_mm": [0.0, 0.0, np.nan, 0.0], "nipple_z_mm": [5.0, 5.0, np.nan, 5.0],
    })  # fmt: skip
    measured = Fiducials(("nipple_left",), ("nipple",), np.array([[1.0, 3.0, 9.0]]))
    table = pd.DataFrame(position_rows(nipples, measured)).set_index("quantity")
    assert table.loc["nipple_x_mm", ["fit", "low", "high", "measured"]].tolist() == [1.0, -1.0, 2.0, 1.0]
    assert table.loc["nipple_from_fit_mm", ["fit", "low", "high", "measured"]].tolist() == [0, 0, 2.0, 5.0]
    assert (table.solved == 3).all()
    assert (table.draws == 2).all()


def test_force_and_dose_span_the_draws_between_which_they_were_solved():
    pressed = pd.DataFrame({
        "side": "left", "draw": [0, 7, 3], "force_n": [2.0, 1.5, 2.6], "agd_mgy": [1.0, 1.02, 0.98],
    })  # fmt: skip
    table = pd.DataFrame(pressed_rows(pressed, ranked=23)).set_index("quantity")
    assert table.loc["force_n", ["fit", "low", "high", "solved"]].tolist() == [2.0, 1.5, 2.6, 3]
    assert table.share_percent.tolist() == pytest.approx([100 * 22 / 24] * 2)
