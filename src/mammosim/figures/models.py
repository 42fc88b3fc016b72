"""Published models side by side: nipples, stress-free shapes, forces and times."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mammosim.figures.style import BLUE, GREEN, ORANGE, QUIET, VERMILION, new_figure, styled
from mammosim.figures.ticks import written

MARKS = {"prone": ("o", BLUE), "supine": ("s", VERMILION), "upright": ("^", GREEN)}


@styled
def models(table: pd.DataFrame) -> Figure:
    """A line per model: nipples by position, error of the stress-free skin, force, processor time.

    table: study.models.rows.table. What a model did not find is an open mark at the left.
    """
    figure = new_figure(1.4 + 0.27 * len(table))
    nipples, shape, force, time = figure.subplots(1, 4, sharey=True, width_ratios=(5, 3, 3, 3))
    place = np.arange(len(table))[::-1]
    for shift, (position, (marker, colour)) in zip((0.2, 0.0, -0.2), MARKS.items()):
        values = table[f"nipple_{position}_mm"].to_numpy(dtype=float)
        nipples.plot(values, place + shift, marker, color=colour, label=position, ms=4.5)
    nipples.set(xlabel="nipple off by (mm)")
    nipples.legend(loc="lower right", frameon=True, edgecolor="none")
    _bars(shape, place, table.stress_free_median_mm, ORANGE)
    shape.set(xlabel="stress-free skin\noff by (mm)", xlim=(0, None))
    _dots(force, place, table.force_n)
    force.set(xlabel="force at half\nthickness (N)", xlim=(0, None))
    _dots(time, place, table.seconds)
    time.set(xlabel="processor\ntime (s)", xlim=(0, None))
    nipples.set_yticks(place, list(map(written, table.title)))
    for ax in (nipples, shape, force, time):
        ax.grid(False, axis="y")
        for y in place:
            ax.axhline(y, color="#eef1f4", lw=0.8, zorder=0)
    _lacking(nipples, place, table.nipple_supine_mm)
    _lacking(force, place, table.force_n)
    return figure


def _bars(ax: Axes, place: np.ndarray, values: pd.Series, colour: str) -> None:
    ax.barh(place, values.fillna(0.0), height=0.55, color=colour)


def _dots(ax: Axes, place: np.ndarray, values: pd.Series) -> None:
    ax.plot(values.to_numpy(dtype=float), place, "D", color=BLUE, ms=4.5)
    ax.margins(x=0.12)  # a mark at the end is whole


def _lacking(ax: Axes, place: np.ndarray, values: pd.Series) -> None:
    """An open mark at the left edge where there is no value."""
    for y in place[values.isna().to_numpy()]:
        ax.plot(0.03, y, "o", mfc="white", mec=QUIET, ms=5, transform=ax.get_yaxis_transform(), clip_on=False)
