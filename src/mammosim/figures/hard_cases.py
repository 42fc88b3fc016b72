"""Hard cases of the mechanics: what happened in each, how far within its bound, how long it took."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from mammosim.figures.style import BLUE, INK, QUIET, SMALLEST, VERMILION, new_figure, styled

# An error of exactly zero has no place on a log axis; this is below rounding of any bound.
_SMALLEST = 1e-9
MARKERS = {"converged": "o", "rejected": "s", "unstable": "^", "failed": "v", "crashed": "X"}


@styled
def hard_cases(table: pd.DataFrame) -> Figure:
    """One line per case, by family: error over the largest allowed, and processor time.

    table: rows of study.hard_cases.cases.row. MARKERS say what happened; hollow, beside the axes, where
    there is no number to compare; vermilion where the outcome is not the expected one.
    """
    table = table.iloc[::-1].reset_index(drop=True)
    figure = new_figure(1.4 + 0.17 * len(table))
    error, time = figure.subplots(1, 2, sharey=True, width_ratios=(3, 2))
    _draw_errors(error, table)
    place = np.arange(len(table))
    time.barh(place, table.seconds, color=[BLUE if ok else VERMILION for ok in table.ok], height=0.6)
    time.set(xscale="log", xlabel="processor time (s)", title="time")
    for ax in (error, time):
        ax.margins(y=0.01)
        ax.grid(False, axis="y")
        _separate_families(ax, table)
    return figure


def _draw_errors(ax: Axes, table: pd.DataFrame) -> None:
    part = np.maximum(table.error / table.within, _SMALLEST)
    for place, case in enumerate(table.itertuples()):
        style: dict[str, Any] = {"color": BLUE if case.ok else VERMILION, "clip_on": False, "zorder": 3}
        marker = MARKERS[str(case.outcome).split(":")[0]]
        if np.isfinite(part[place]):
            ax.plot(part[place], place, marker, **style)
        else:
            beside = ax.get_yaxis_transform()
            ax.plot(1.04, place, marker, transform=beside, markerfacecolor="none", **style)
    ax.axvline(1.0, color=INK, lw=1)
    ax.set_yticks(np.arange(len(table)), [name.replace("_", " ") for name in table.case])
    for label, ok in zip(ax.get_yticklabels(), table.ok):
        label.set_color(INK if ok else VERMILION)
    ax.set(xscale="log", xlabel="error / largest error allowed (-)", title="what happened")
    kinds = {text: (m, QUIET) for text, m in MARKERS.items()}
    kinds |= {"expected outcome": ("o", BLUE), "another outcome": ("o", VERMILION)}
    marks = [Line2D([], [], ls="", marker=m, color=c, label=text) for text, (m, c) in kinds.items()]
    ax.figure.legend(handles=marks, ncols=4, loc="outside upper center")


def _separate_families(ax: Axes, table: pd.DataFrame) -> None:
    """A line between families, and their names at the right of the last axes."""
    starts = np.flatnonzero(table.family != table.family.shift())
    for start, end in zip(starts, [*starts[1:], len(table)]):
        ax.axhline(start - 0.5, color=QUIET, lw=0.5)
        if not ax.get_ylabel() and ax.get_title(loc="left") == "time":
            ax.annotate(
                table.family[start],
                (1.02, (start + end - 1) / 2),
                xycoords=("axes fraction", "data"),
                va="center",
                fontsize=SMALLEST,
                color=INK,
            )
