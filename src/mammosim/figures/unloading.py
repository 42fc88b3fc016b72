"""The search for the stress-free shape by several methods: how it converges, its cost, where it fails."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from mammosim.chain.outcome import CONVERGED
from mammosim.core.errors import MissingResult
from mammosim.figures.series import (
    COLUMNS,
    MOST,
    add_legend,
    blocks,
    colours,
    labelled,
    line_handles,
    lines,
    markers,
    panels,
    some,
)
from mammosim.figures.style import INK, QUIET, styled
from mammosim.figures.ticks import plain_log


@styled
def convergence(table: pd.DataFrame, *, tolerance_mm: float) -> Figure:
    """Residual of each iteration towards the stress-free shape: a panel per volunteer, a line per method.

    table: rows of mechanics.unloaded.UnloadingStep with volunteer and method; the largest distance is drawn.
    Raises MissingResult where no method that iterates has any.
    """
    rows = table.dropna(subset=["max_mm"])
    if rows.empty:
        raise MissingResult("no method that iterates found a stress-free shape; their table says why")
    women, methods = sorted(rows.volunteer.unique()), list(dict.fromkeys(rows.method))
    figure, axes = panels(len(women), 2.6, extra=0.6, sharey=True)
    colour, marker = colours(table.method), markers(table.method)
    for ax, woman in zip(axes, women):
        for method in methods:
            history = rows[(rows.volunteer == woman) & (rows.method == method)].sort_values("iteration")
            style = {"color": colour[method], "marker": marker[method]}
            ax.semilogy(history.iteration, history.max_mm, label=method.replace("_", " "), **style)
        ax.axhline(tolerance_mm, color=QUIET, ls="--", lw=1, label="tolerance")
        ax.set(xlabel="iteration", title=str(woman))
        ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    plain_log(axes[0].yaxis)
    for ax in axes[::COLUMNS]:
        ax.set_ylabel("largest distance of the reloaded\nfrom the measured skin (mm)")
    add_legend(figure, some(labelled(axes[0]), "methods and the tolerance"))
    return figure


# Column of the table, title, the target that a method should stay below, if any.
UNLOADING_PANELS = (
    ("error_mean_mm", "error of the skin,\nmean (mm)", None),
    ("round_max_mm", "round trip, largest (mm)", 0.1),
    ("forward_solves", "time (forward solves)", 6.0),
)

LEAST = 1e-4  # mm: less is drawn there
TICKS = (1, 2, 4, 6, 10, 20)


@styled
def unloading(table: pd.DataFrame) -> Figure:
    """Panels per quantity and volunteer, a line per method, a cross at the top where it found no solution.

    table: rows of study.unloading.rows with volunteer and youngs_modulus_kpa. Dashed: the targets
    of the default method.
    """
    women = sorted(table.volunteer.unique())
    several = {f"{len(women)} volunteers": table}
    shown = {str(v): table[table.volunteer == v] for v in women} if len(women) <= MOST else several
    figure, axes = blocks(len(UNLOADING_PANELS), len(shown), 1.9, extra=0.7, sharex=True)
    for block, (column, label, target) in zip(axes, UNLOADING_PANELS):
        for ax, (name, part) in zip(block, shown.items()):
            _draw_methods(ax, part, column)
            if target is not None:
                ax.axhline(target, color=QUIET, lw=1, ls=(0, (4, 3)))
            ax.set(title=name, ylabel=label)
            if ax is not block[0]:
                ax.sharey(block[0])
    _finish_unloading(axes, table)
    add_legend(figure, _unloading_legend(table, women))
    return figure


def _unloading_legend(table: pd.DataFrame, women: list[str]) -> list[Artist]:
    """The methods, what a cross is, and that a line is a volunteer where each has no panel of hers."""
    colour, marker = colours(table.method), markers(table.method)
    methods = [
        Line2D(
            [],
            [],
            color=colour[each],
            marker=marker[each],
            markersize=4,
            lw=1.4,
            label=each.replace("_", " "),
        )
        for each in colour
    ]
    cross = Line2D([], [], ls="", marker="x", color=INK, label="failed or unstable")
    return [
        *some(methods, "methods"),
        cross,
        *(line_handles(women, "volunteers") if len(women) > MOST else []),
    ]


def _draw_methods(ax: Axes, rows: pd.DataFrame, column: str) -> None:
    """Lines of the methods, and crosses of those without solution in their colours, one below the other."""
    colour, marker, women = colours(rows.method), markers(rows.method), rows.volunteer.unique()
    step = min(0.06, 0.6 / len(colour))
    thin = {"lw": 1.4} if len(women) == 1 else lines(women)[women[0]]
    for number, (method, part) in enumerate(rows.groupby("method", sort=False)):
        style: dict[str, Any] = {"color": colour[method], "markersize": 4}
        for _, hers in part.groupby("volunteer"):
            hers = hers.sort_values("youngs_modulus_kpa")
            solved = hers[column].where(hers.outcome == CONVERGED).clip(lower=LEAST)
            ax.loglog(hers.youngs_modulus_kpa, solved, marker=marker[method], **style | thin)
        lost = part[part.outcome != CONVERGED].youngs_modulus_kpa.unique()
        height = np.full(len(lost), 0.97 - step * number)
        ax.plot(lost, height, "x", transform=ax.get_xaxis_transform(), **style)


def _finish_unloading(axes: np.ndarray, table: pd.DataFrame) -> None:
    moduli = sorted(set(table.youngs_modulus_kpa))
    for ax in axes.ravel():
        ax.set_xticks(moduli, [f"{E:g}" for E in moduli])
        ax.minorticks_off()
    for ax in axes[:-1].ravel():
        plain_log(ax.yaxis)
    for ax in axes[-1]:
        ax.set_yticks(TICKS, [f"{n:g}" for n in TICKS])
    for ax in axes[-1, -COLUMNS:]:
        ax.set_xlabel("modulus of fat and gland (kPa)")
