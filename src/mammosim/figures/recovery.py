"""Moduli that were found against the true ones, with the intervals that the fit states."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullLocator

from mammosim.figures.style import BLUE, INK, ORANGE, QUIET, VERMILION, new_figure, styled

SIDES = {"left": ("o", BLUE), "right": ("s", ORANGE)}
TICKS_KPA = np.outer([0.01, 0.1, 1, 10, 100, 1000], [1, 2, 5]).ravel()
MARGIN = 1.25  # of the axes beyond the smallest and the largest modulus


@styled
def recovery(table: pd.DataFrame) -> Figure:
    """One picture per tissue that the volunteers have, both axes logarithmic; on the line is right.

    table: rows of study.identification.recovery.scored. Hollow: not identifiable; vermilion: the truth is
    outside.
    """
    table = table[table.true_kpa > 0]
    tissues = list(dict.fromkeys(table.tissue))
    rows = -(-len(tissues) // 2)
    figure = new_figure(0.6 + 3.2 * rows)
    axes = figure.subplots(rows, 2, squeeze=False).ravel()
    for ax, tissue in zip(axes, tissues):
        _draw(ax, table[table.tissue == tissue])
        ax.set_title(tissue)
    for ax in axes[len(tissues) :]:
        ax.set_axis_off()
    figure.legend(handles=_legend(), ncols=4, loc="outside upper center")
    return figure


def _draw(ax: Axes, table: pd.DataFrame) -> None:
    table = table[np.isfinite(table.fitted_kpa)]
    for row in table.itertuples():
        marker, colour = SIDES[str(row.side)]
        outside = pd.notna(row.inside_95) and not row.inside_95
        colour = (VERMILION if outside else colour) if row.identifiable else QUIET
        ax.plot([row.true_kpa] * 2, [row.low_kpa, row.high_kpa], color=colour, lw=1.2)
        ax.plot(
            row.true_kpa, row.fitted_kpa, marker, color=colour, mfc=colour if row.identifiable else "white"
        )
    shown = table[table.identifiable] if table.identifiable.any() else table
    values = shown[["true_kpa", "fitted_kpa", "low_kpa", "high_kpa"]].to_numpy(float)
    values = values[np.isfinite(values) & (values > 0)]
    ends = np.array([values.min() / MARGIN, values.max() * MARGIN]) if len(values) else np.array([0.1, 10.0])
    ax.plot(ends, ends, color=INK, lw=1, zorder=1)
    ax.set(xscale="log", yscale="log", xlim=ends, ylim=ends, aspect="equal")
    ax.set(xlabel="true modulus (kPa)", ylabel="fitted (kPa)")
    ticks = [tick for tick in TICKS_KPA if ends[0] <= tick <= ends[1]]
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_ticks(ticks, [f"{tick:g}" for tick in ticks])
        axis.set_minor_locator(NullLocator())


def _legend() -> list[Line2D]:
    marks = [Line2D([], [], ls="", marker=m, color=c, label=side) for side, (m, c) in SIDES.items()]
    marks.append(Line2D([], [], color=VERMILION, marker="o", label="truth outside its interval"))
    marks.append(Line2D([], [], color=QUIET, marker="o", mfc="white", label="not identifiable"))
    return marks
