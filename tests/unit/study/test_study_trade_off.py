"""Compression and image side by side, and what changes against the standard strategy."""

import pandas as pd
import pytest
from matplotlib.collections import PathCollection

from mammosim.core.errors import ConfigurationError
from mammosim.figures.dose import TRADE_OFF_PANELS as PANELS
from mammosim.figures.dose import trade_off as drawn
from mammosim.study.report.trade_off import KEY, PRESSED, SEEN, trade_off

BREASTS = ("small", "large")


def rows(columns, values):
    """A row per breast and strategy; every column has the value of its strategy."""
    return pd.DataFrame(
        [
            {"volunteer": v, "side": "left", "strategy": s, "moduli": "gravity"} | dict.fromkeys(columns, x)
            for v in BREASTS
            for s, x in values.items()
        ]
    )


@pytest.fixture(scope="module")
def table():
    return trade_off(
        rows(PRESSED, {"standard": 50.0, "reduced": 55.0, "tilted": 52.0}),
        rows(SEEN, {"standard": 2.0, "reduced": 2.2}),
    )


def test_changes_are_against_the_standard_of_the_same_breast(table):
    assert len(table) == 4
    reduced = table[table.strategy == "reduced"]
    assert reduced.dose_change_percent.to_numpy() == pytest.approx(10.0)
    assert reduced.thickness_change_mm.to_numpy() == pytest.approx(5.0)
    assert not table[table.strategy == "standard"].dose_change_percent.any()


def test_an_image_of_a_strategy_that_was_not_compressed_is_rejected(table):
    with pytest.raises(ConfigurationError, match="small left reduced gravity"):
        trade_off(rows(PRESSED, {"standard": 50.0}), table[[*KEY, *SEEN]])


def test_every_quantity_has_its_panel_with_a_marker_for_every_image(table):
    figure = drawn(table)
    assert [ax.get_ylabel() for ax in figure.axes] == [label for *_, label in PANELS]
    for ax in figure.axes:
        marks = [each for each in ax.collections if isinstance(each, PathCollection)]
        assert sum(len(each.get_offsets()) for each in marks) == len(table)


def test_an_image_that_is_missing_is_a_row_that_says_why():
    image = rows(SEEN, {"standard": 2.0, "reduced": 2.2})
    image["outcome"] = [None, None, "missing: why", None]
    found = trade_off(rows(PRESSED, {"standard": 50.0, "reduced": 55.0}), image)
    gone = found[found.outcome.notna()]
    assert gone[KEY].values.tolist() == [["large", "left", "standard", "gravity"]]
    assert gone.outcome.tolist() == ["missing: why"]
    assert gone.dose_mgy.isna().all()
    assert found.dose_mgy.notna().sum() == 3
