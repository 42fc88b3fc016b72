import numpy as np
import pytest

from mammosim.chain.outcome import CONVERGED
from mammosim.core.errors import EquilibriumError, MechanicsError
from mammosim.core.labels import Label
from mammosim.mechanics.body import Skin
from mammosim.study import sweep
from mammosim.study.sweep import one_law, reposition, sweep_row, upright_row

SUPINE, PRONE, UPRIGHT = np.array([0.0, 1, 0]), np.array([0.0, -1, 0]), np.array([0.0, 0, -1])
NIPPLES = np.array([[20.0, 0, 15], [10.0, 0, 15]])


def law(E):
    return one_law(E, poisson_ratio=0.45, muscle_kpa=30.0, density_g_cm3=1.0)


def test_a_stiff_body_hardly_moves_so_the_nipple_error_is_the_distance_before_modelling(block):
    mesh, stiff = block(2), law(1e4)
    repositioned = reposition(mesh, stiff, gravity=SUPINE, new_gravity=PRONE)
    goal = NIPPLES - 6.0 * SUPINE
    row = sweep_row("small", stiff, mesh, repositioned, nipples=NIPPLES, goal=goal)
    assert row["outcome"] == CONVERGED
    assert row["supine_left_mm"] == pytest.approx(6)
    # rho g h^2 / E is 1e-3 mm here, twice.
    assert row["nipple_left_mm"] == pytest.approx(6, abs=5e-3)
    assert row["max_displacement_mm"] < 5e-3


def test_displacement_from_supine_to_prone_falls_as_one_over_the_modulus_when_small(block):
    mesh = block(2)
    E1, E2 = 20.0, 40.0
    small = [
        np.abs(reposition(mesh, law(E), gravity=SUPINE, new_gravity=PRONE).points - mesh.points).max()
        for E in (E1, E2)
    ]
    # Linear in 1/E up to the strain itself, which is rho g h / E = 1.5 % at 20 kPa.
    assert small[0] / small[1] == pytest.approx(E2 / E1, rel=0.03)


def test_a_soft_body_moves_towards_the_prone_side_and_its_nipple_error_is_measured_there(block):
    mesh, soft = block(2), law(2.0)
    repositioned = reposition(mesh, soft, gravity=SUPINE, new_gravity=PRONE)
    row = sweep_row("small", soft, mesh, repositioned, nipples=NIPPLES, goal=NIPPLES)
    assert row["nipple_left_mm"] > 0.5
    assert repositioned.points[:, 1].min() < -0.5


def test_skin_lets_the_body_hang_less(block):
    mesh, soft = block(2), law(2.0)
    rows = []
    for skin in (None, Skin(30.0, 0.45, 1.45)):
        repositioned = reposition(mesh, soft, gravity=PRONE, new_gravity=UPRIGHT, skin=skin)
        rows.append(upright_row("small", soft, mesh, repositioned, nipples=NIPPLES, skin=skin))
    assert rows[0]["skin_kpa"] == 0
    assert rows[1]["skin_kpa"] == 30
    assert rows[1]["max_displacement_mm"] < rows[0]["max_displacement_mm"]


def test_a_load_without_equilibrium_gives_a_row_that_says_why_and_no_number(block, monkeypatch):
    def fail(*_, **__):
        raise EquilibriumError("no equilibrium beyond load factor 0.4", history=(1, 2, 3), load_factor=0.4)

    monkeypatch.setattr(sweep, "load", fail)
    mesh, soft = block(1), law(0.1)
    repositioned = reposition(mesh, soft, gravity=PRONE, new_gravity=SUPINE)
    row = sweep_row("small", soft, mesh, repositioned, nipples=NIPPLES, goal=NIPPLES)
    assert row["outcome"] == "failed: unloading: no equilibrium beyond load factor 0.4"
    assert np.isnan(row["nipple_left_mm"])
    assert np.isnan(row["max_displacement_mm"])
    assert row["iterations"] == 3


def test_a_load_that_loses_stability_is_unstable(block, monkeypatch):
    mesh, soft = block(1), law(0.1)

    def lose(*_, **__):
        raise EquilibriumError("it buckles", mode=np.ones_like(mesh.points))

    monkeypatch.setattr(sweep, "load", lose)
    repositioned = reposition(mesh, soft, gravity=PRONE, new_gravity=SUPINE)
    assert repositioned.outcome == "unstable: unloading: it buckles"


def test_an_impossible_modulus_is_rejected_before_anything_is_computed():
    with pytest.raises(MechanicsError, match="outside"):
        law(-1.0)


def test_all_soft_tissues_share_one_law_except_muscle():
    tissues = law(5.0)
    assert tissues[Label.GLANDULAR] == tissues[Label.ADIPOSE] == tissues[Label.SKIN]
    assert tissues[Label.MUSCLE].youngs_modulus_kpa == 30
