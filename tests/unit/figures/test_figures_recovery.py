"""Fitted against true moduli: what is drawn, and what is marked."""

import numpy as np
import pandas as pd
from conftest import title

from mammosim.figures.identification import recovery
from mammosim.figures.style import VERMILION


def table():
    columns = ["side", "tissue", "true_kpa", "fitted_kpa", "low_kpa", "high_kpa", "inside_95", "identifiable"]
    rows = [
        ("left", "adipose", 1.0, 1.1, 0.9, 1.3, True, True),
        ("right", "adipose", 0.7, 1.0, 0.9, 1.1, False, True),
        ("left", "skin", 12.0, 10.0, np.nan, np.nan, None, False),
        ("left", "fascia", 0.0, 50.0, np.nan, np.nan, None, False),
    ]
    return pd.DataFrame(rows, columns=columns)


def test_each_tissue_that_the_volunteers_have_is_a_picture_on_equal_log_axes():
    axes = [ax for ax in recovery(table()).axes if ax.axison]
    assert [title(ax) for ax in axes] == ["adipose", "skin"]
    for ax in axes:
        assert ax.get_xscale() == ax.get_yscale() == "log"
        assert ax.get_xlim() == ax.get_ylim()


def test_what_lies_outside_its_interval_stands_out():
    adipose, skin = (ax for ax in recovery(table()).axes if ax.axison)
    marked = [line for line in adipose.lines if line.get_color() == VERMILION]
    assert [list(line.get_xdata()) for line in marked] == [[0.7, 0.7], [0.7]]
    assert not [line for line in skin.lines if line.get_color() == VERMILION]
