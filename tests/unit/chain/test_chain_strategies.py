"""Strategies on a small block: what each stops at, and what a share of the standard's force means."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import yaml

from mammosim.chain.configuration import check_settings
from mammosim.chain.press import MEASURED, load_standard_path, pressed_breast, save_standard_path
from mammosim.chain.strategies import LoadPath, MeanPressure, PressSetup, Strategy, ThicknessShare
from mammosim.core.errors import ConfigurationError, MechanicsError
from mammosim.core.labels import Label
from mammosim.core.tissues import Tissue
from mammosim.mechanics.body import Body
from mammosim.mechanics.paddles import Friction, Plates, Rigid, Tilting
from mammosim.mechanics.stage import PressSettings
from mammosim.study.report.headlines import numbers_of_strategies

THRESHOLDS = {"logarithmic": [0.0], "pressure_kpa": [0.0]}
AXES = np.column_stack([[0.0, -1, 0], [1.0, 0, 0], [0.0, 0, 1]])
STANDARD = {"until": {"thickness_share": 1.0}}
REDUCED = {"until": {"force_share": 0.5}}


def setup_of(mesh, youngs_modulus_kpa: float = 1.0) -> PressSetup:
    """A cube of 30 mm, held behind, under plates that reach over its front 20 mm."""
    tissue = Tissue(youngs_modulus_kpa, 0.45, 1.0)
    plates = Plates(np.array([15.0, 0.0, 15.0]), AXES, np.array([20.0, 25.0, 6.0]), 5.0)
    return PressSetup(mesh, Body({Label.ADIPOSE: tissue}).effects(mesh), plates, "gravity", 24.0, 8.0)


@pytest.fixture(scope="module")
def setup(block) -> PressSetup:
    return setup_of(block(2))


@pytest.fixture(scope="module")
def standard(setup):
    return Strategy.read(STANDARD).press(setup)


@pytest.fixture(scope="module")
def after(setup, standard) -> PressSetup:
    """The same breast once the standard strategy is known."""
    return replace(setup, standard=LoadPath.of(setup.mesh, standard))


@pytest.fixture(scope="module")
def reduced(after):
    return Strategy.read(REDUCED).press(after)


def test_half_the_force_is_half_the_force_and_leaves_more_thickness(standard, reduced):
    force = [found.path.force_n.iloc[-1] for found in (standard, reduced)]
    assert force[1] == pytest.approx(force[0] / 2, rel=1e-3)
    assert standard.path.readout_mm.iloc[-1] == 24.0
    assert 24.0 < reduced.path.readout_mm.iloc[-1] < 30.0


def test_the_load_path_of_the_standard_leads_to_where_the_whole_path_does(setup, reduced):
    thickness = float(reduced.path.readout_mm.iloc[-1])
    whole = Strategy.read({"until": {"thickness_share": thickness / 24.0}}).press(setup)
    # Pressed skin is as near to the plates in both, but not to the last digit.
    assert np.abs(whole.points - reduced.points).max() < PressSettings().penetration_mm
    assert whole.path.force_n.iloc[-1] == pytest.approx(reduced.path.force_n.iloc[-1], rel=2e-3)


def test_a_share_of_the_force_is_the_same_shape_for_moduli_that_are_all_five_times_larger(block, reduced):
    stiff = setup_of(block(2), 5.0)
    stiff = replace(stiff, standard=LoadPath.of(stiff.mesh, Strategy.read(STANDARD).press(stiff)))
    found = Strategy.read(REDUCED).press(stiff)
    assert found.path.force_n.iloc[-1] == pytest.approx(5 * reduced.path.force_n.iloc[-1], rel=2e-3)
    assert found.path.readout_mm.iloc[-1] == pytest.approx(reduced.path.readout_mm.iloc[-1], abs=0.02)


def test_a_mean_pressure_is_met_or_just_passed(after, standard):
    p = standard.path.mean_pressure_kpa
    goal = (p.iloc[-1] + p[p > 0].min()) / 2
    found = Strategy.read({"until": {"pressure_kpa": {"gravity": goal}}}).press(after).path.iloc[-1]
    assert found.mean_pressure_kpa >= 0.98 * goal
    assert 24.0 <= found.readout_mm < 30.0


def test_moduli_without_a_pressure_are_rejected_with_those_that_have_one(after):
    with pytest.raises(MechanicsError, match=r"'gravity' moduli, only for: compression"):
        Strategy.read({"until": {"pressure_kpa": {"compression": 10.0}}}).press(after)


def test_a_pressure_beyond_every_thickness_is_answered_with_the_largest_there_is(after):
    near = replace(after, smallest_mm=22.0)
    with pytest.raises(MechanicsError, match="never 50 kPa: ask for less, or allow a smaller thickness"):
        MeanPressure({"gravity": 50.0}).press(near, Strategy.read(STANDARD).paddle)


def test_a_share_of_a_standard_that_was_not_found_is_not_found(setup):
    with pytest.raises(MechanicsError, match=r"the standard strategy.*found no equilibrium"):
        Strategy.read(REDUCED).press(setup)


def test_a_rigid_paddle_leaves_one_thickness_and_balances(setup, standard):
    row = pressed_breast(setup, standard, THRESHOLDS).row
    assert set(row) == {*MEASURED, "outcome"}
    assert row["thickness_min_mm"] == row["thickness_max_mm"] == row["plates_mm"] == 24.0
    assert row["imbalance_percent"] < 0.01
    assert 0 < row["logarithmic_p95"] < 1
    assert row["energy_mj"] == pytest.approx(row["work_mj"], rel=0.05)  # by trapezoids over 8 steps


def test_a_paddle_on_a_hinge_leaves_a_wedge_whose_volume_is_counted(after):
    soft = Strategy(Tilting(20.0), Strategy.read(STANDARD).until)
    made = pressed_breast(after, soft.press(after), THRESHOLDS)
    assert made.row["thickness_max_mm"] - made.row["thickness_min_mm"] > 0.1
    assert made.plates["paddle_z_mm"] - made.plates["support_z_mm"] > made.row["plates_mm"]
    assert made.amounts.amount.iloc[0] == pytest.approx(27.0)  # cm3 above nothing


def test_an_unknown_end_or_paddle_is_answered_with_the_known_ones():
    with pytest.raises(
        ConfigurationError, match=r"until = {'pain': 3}; give exactly one of: thickness_share"
    ):
        Strategy.read({"until": {"pain": 3}})
    with pytest.raises(ConfigurationError, match=r"paddle = {'soft': {}}; .*: tilting, flexible"):
        Strategy.read({"until": {"force_n": 50.0}, "paddle": {"soft": {}}})


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({}, r"^mine lacks until"),
        ({"until": {}}, r"^mine\.until = {}; give exactly one of"),
        ({"until": {"force_n": "50"}}, r"^mine\.until\.force_n = '50' is of type"),
        ({"until": {"force_share": 0.0}}, r"^mine\.until\.force_share: share = 0 is outside \(0, inf\)"),
        ({"until": {"pressure_kpa": 3.0}}, r"^mine\.until\.pressure_kpa = 3\.0 has no keys"),
        (
            {"until": {"pressure_kpa": {"gravity": -1.0}}},
            r"pressures {'gravity': -1\.0} kPa: give one above 0",
        ),
        (
            {"until": {"force_n": 5}, "paddle": {"tilting": {}}},
            r"^mine\.paddle\.tilting lacks stiffness",
        ),
        (
            {"until": {"force_n": 5}, "paddle": {"tilting": {"stiffness_n_mm_per_rad": 5, "hinge": 2}}},
            r"^mine\.paddle\.tilting: a hinge of 5 N mm/rad \(above 0\) at 2",
        ),
    ],
)
def test_a_strategy_that_cannot_be_built_is_rejected_with_its_place(values, words):
    with pytest.raises(ConfigurationError, match=words):
        Strategy.read(values, at="mine")


def test_what_is_told_of_the_strategies(setup, standard, reduced):
    rows = [
        {"volunteer": "a", "side": "left", "strategy": name, "moduli": "gravity"}
        | dict(pressed_breast(setup, found, THRESHOLDS).row)
        for name, found in (("standard", standard), ("reduced", reduced))
    ]
    stiff = [row | {"moduli": "compression", "force_n": 5 * row["force_n"]} for row in rows]
    none = [
        {"volunteer": "a", "side": "left", "strategy": "tilted", "moduli": "gravity", "outcome": "missing: -"}
    ]
    told = numbers_of_strategies(pd.DataFrame(rows + stiff + none))
    assert told["moduli_force_ratio"] == pytest.approx(5)
    assert told["reduced_thicker_percent"] == pytest.approx(100 * (reduced.path.readout_mm.iloc[-1] / 24 - 1))
    assert told["strategies_unsolved"] == 1
    assert told["unlevel_most_mm"] == 0


@pytest.fixture
def schema(repository):
    return yaml.safe_load((repository / "workflow/schemas/compression.schema.yaml").read_text())


def test_the_published_strategies_are_accepted_and_can_be_built(repository, schema):
    settings = yaml.safe_load((repository / "config/strategies.yaml").read_text())
    check_settings(settings, schema, files=["-"])
    assert {"standard", "reduced", "pressure", "flexible", "tilted"} <= set(settings)
    assert all(Strategy.read(values) for values in settings.values())


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"until": {"force_share": 50}}, "given in percent? Write 0.5"),
        ({"until": {"force_n": 1e5}}, "given in mN? Write 100"),
        ({"until": {"force_n": 50, "force_share": 0.5}}, "exactly one of thickness_share"),
        ({"until": {"forse_n": 50}}, "did you mean 'force_n'?"),
        ({"until": {"force_n": 50}, "paddle": {"tilting": {"stiffness_n_mm_per_rad": 1e9}}}, "at most 1e+06"),
        ({"paddle": {}}, "lacks until"),
    ],
)
def test_a_strategy_that_cannot_be_meant_is_rejected_with_advice(schema, values, words):
    with pytest.raises(ConfigurationError) as error:
        check_settings({"standard": STANDARD, "mine": values}, schema, files=["mine.yaml"])
    assert words in str(error.value)
    assert "mine" in str(error.value)


def test_a_paddle_that_yields_ends_where_it_does_from_first_contact(setup, after, standard):
    newton = float(standard.path.force_n.iloc[-1])
    hinged = Strategy.read(
        {"paddle": {"tilting": {"stiffness_n_mm_per_rad": 50.0}}, "until": {"force_n": newton}}
    )
    short, whole = hinged.press(after), hinged.press(setup)
    assert len(short.path) < len(whole.path)
    # Both meet the force within 1e-3 of it, by skin that lies on the plates within 0.02 mm.
    assert np.abs(short.points - whole.points).max() < 3e-3 * 30.0
    assert short.path.tilt_deg.iloc[-1] == pytest.approx(whole.path.tilt_deg.iloc[-1], rel=1e-2)


def test_no_strategy_presses_further_than_is_allowed(setup):
    with pytest.raises(MechanicsError, match=r"2\.4 mm are less than compression\.smallest_mm = 20"):
        ThicknessShare(0.1).press(replace(setup, thickness_mm=24.0, smallest_mm=20.0), Rigid())


def test_a_state_in_which_the_paddle_does_not_touch_is_no_compression(setup, standard):
    apart = replace(standard, path=standard.path.assign(force_n=0.0))
    with pytest.raises(MechanicsError, match=r"24\.0 mm above the support the paddle has no contact"):
        pressed_breast(setup, apart, THRESHOLDS)


@pytest.mark.parametrize("friction", [None, Friction(0.3)])
def test_the_standard_strategy_is_measured_at_the_end_of_its_kept_path_as_where_it_was_pressed(
    setup, friction, tmp_path
):
    setup = replace(setup, plates=replace(setup.plates, friction=friction))
    pressed = Strategy.read(STANDARD).press(setup)
    files = {"shapes": str(tmp_path / "shapes.vtu"), "path": str(tmp_path / "path.csv")}
    save_standard_path(LoadPath.of(setup.mesh, pressed), files, {})
    kept = pressed_breast(setup, load_standard_path(files).end(setup), THRESHOLDS)
    direct = pressed_breast(setup, pressed, THRESHOLDS)
    assert kept.row == direct.row
    assert kept.plates == direct.plates
    np.testing.assert_array_equal(kept.mesh.points, direct.mesh.points)
    for table in ("path", "cells", "faces", "amounts", "thickness"):
        pd.testing.assert_frame_equal(getattr(kept, table), getattr(direct, table), check_exact=True)
