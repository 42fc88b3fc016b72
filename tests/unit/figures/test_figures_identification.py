"""The figure of a fit shows what failed, and what is not identifiable, as such."""

import numpy as np
import pandas as pd

from mammosim.figures.identification import identification

PRIOR = {
    "median_kpa": {"adipose": 1.0, "glandular": 2.0, "skin": 10.0, "muscle": 30.0},
    "factor": {"adipose": 3.0, "glandular": 3.0, "skin": 2.5, "muscle": 2.0},
}
HISTORY = pd.DataFrame({"iteration": [0, 1], "skin_rms_mm": [2.0, 0.3], "marker_rms_mm": [2.0, 0.6]})
GRID = pd.DataFrame(
    {"breast_kpa": [1.0, 2.0, 1.0, 2.0], "skin_kpa": [5.0, 5.0, 9.0, 9.0], "skin_rms_mm": [np.nan, 1, 2, 3]}
)


def moduli():
    rows = [
        {"side": side, "tissue": tissue, "fitted_kpa": E, "low_kpa": E / 2, "high_kpa": 2 * E}
        for side in ("left", "right")
        for tissue, E in (*PRIOR["median_kpa"].items(), ("fascia", 0.0))
    ]
    table = pd.DataFrame(rows)
    return table.assign(identifiable=table.tissue != "muscle")


def test_a_pair_that_failed_and_a_modulus_that_is_not_identifiable_are_told_apart():
    figure = identification(GRID, HISTORY, moduli(), PRIOR)
    chart, _, bars = figure.axes[:3]
    assert sorted(text.get_text() for text in chart.texts) == ["1.00", "2.00", "3.00", "failed"]
    hollow = [line for line in bars.lines if line.get_marker() in "os" and line.get_mfc() == "white"]
    assert len(hollow) == 2  # muscle, left and right
