"""The numbers that texts quote are there whatever a table has in it, and what is no number is none."""

import numpy as np
import pandas as pd
import pytest

from mammosim.io.tables import read_json, write_table

PRESSED = pd.DataFrame(
    {
        **{"volunteer": "ada", "side": "left", "strategy": ["standard", "standard", "reduced"]},
        **{"moduli": ["gravity", "compression", "gravity"], "thickness_mm": [50.0, 50.0, 60.0]},
        **{"thickness_min_mm": 49.0, "thickness_max_mm": 61.0, "force_n": [20.0, 100.0, 10.0]},
        **{"mean_pressure_kpa": 3.0, "peak_pressure_kpa": 9.0, "penetration_mm": 0.1},
        **{"imbalance_percent": 0.2, "logarithmic_p95": [0.4, 0.4, 0.3], "outcome": "converged"},
    }
)


def collected(script, tmp_path, **changes) -> dict:
    write_table(PRESSED.assign(**changes), tmp_path / "compression.csv")
    script("collect_numbers").main([str(tmp_path / "compression.csv")], str(tmp_path / "numbers.json"))
    return read_json(tmp_path / "numbers.json")


def test_each_number_has_its_name(script, tmp_path):
    found = collected(script, tmp_path)
    assert found["headline.moduli_force_ratio"] == 5.0
    assert found["headline.pressure_max_kpa"] == 9.0
    assert found["compression.ada.left.reduced.gravity.thickness_mm"] == 60.0


@pytest.mark.parametrize(
    ("changes", "lost"),
    [
        ({"force_n": 0.0}, ["headline.moduli_force_ratio"]),
        ({"force_n": [0.0, 100.0, 10.0]}, ["headline.moduli_force_ratio"]),
        ({"thickness_mm": 0.0}, ["headline.reduced_thicker_percent"]),
        ({"logarithmic_p95": 0.0}, ["headline.reduced_strain_percent"]),
        (
            {"peak_pressure_kpa": np.inf},
            ["headline.pressure_max_kpa", "compression.ada.left.reduced.gravity.peak_pressure_kpa"],
        ),
        ({"force_n": np.nan}, ["headline.standard_force_least_n", "headline.moduli_force_ratio"]),
    ],
)
def test_what_is_no_number_is_none_and_every_other_one_is_there(script, tmp_path, changes, lost):
    whole, found = collected(script, tmp_path), collected(script, tmp_path, **changes)
    assert found.keys() == whole.keys()
    assert [found[name] for name in lost] == [None] * len(lost)
    assert found["headline.penetration_max_mm"] == 0.1


def test_where_nobody_was_pressed_every_number_is_none(script, tmp_path):
    """Each row stands in the place of a missing result: its keys, and why."""
    whole = collected(script, tmp_path)
    keys = PRESSED[["volunteer", "side", "strategy", "moduli"]]
    write_table(keys.assign(outcome="missing: mesh ada prone: no breast"), tmp_path / "compression.csv")
    script("collect_numbers").main([str(tmp_path / "compression.csv")], str(tmp_path / "numbers.json"))
    found = read_json(tmp_path / "numbers.json")
    assert found.keys() == {name for name in whole if name.startswith("headline.")}
    assert found["headline.strategies_unsolved"] == 3
    assert found["headline.pressure_max_kpa"] is found["headline.standard_force_least_n"] is None
