"""Methods of unloading compared: error, round trip and cost against the modulus."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mammosim.chain.outcome import CONVERGED
from mammosim.figures.style import INK, QUIET, SERIES, new_figure, styled

MARKERS = ("o", "s", "D", "^", "v", "P")
# Column of the table, title, the target that a method should stay below, if any.
PANELS = (
    ("error_mean_mm", "error of the skin, mean (mm)", None),
    ("round_max_mm", "round trip, largest (mm)", 0.1),
    ("forward_solves", "time (forward solves)", 6.0),
)

LEAST = 1e-4  # mm: less is drawn there
TICKS = (1, 2, 4, 6, 10, 20)


@styled
def unloading(table: pd.DataFrame) -> Figure:
    """One row of panels per volunteer, one line per method, a cross at the top where it found no solution.

    table: rows of study.unloading.rows with volunteer and youngs_modulus_kpa. Dashed: the targets
    of the default method.
    """
    women = sorted(table.volunteer.unique())
    figure = new_figure(0.7 + 2.3 * len(women))
    axes = figure.subplots(len(women), len(PANELS), squeeze=False, sharex=True, sharey="col")
    for row, woman in zip(axes, women):
        for ax, (column, _, target) in zip(row, PANELS):
            _draw(ax, table[table.volunteer == woman], column)
            if target is not None:
                ax.axhline(target, color=QUIET, lw=1, ls=(0, (4, 3)))
        row[0].set_ylabel(str(woman))
    _finish(axes, table)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


def _draw(ax: Axes, rows: pd.DataFrame, column: str) -> None:
    """Lines of the methods, and crosses of those without solution in their colours, one below the other."""
    for number, (method, part) in enumerate(rows.groupby("method", sort=False)):
        part = part.sort_values("youngs_modulus_kpa")
        style: dict[str, Any] = {"color": SERIES[number % len(SERIES)], "markersize": 4, "lw": 1.4}
        marker = MARKERS[number % len(MARKERS)]
        ax.loglog(
            part.youngs_modulus_kpa,
            part[column].where(part.outcome == CONVERGED).clip(lower=LEAST),
            marker=marker,
            label=str(method).replace("_", " "),
            **style,
        )
        lost = part[part.outcome != CONVERGED].youngs_modulus_kpa
        height = np.full(len(lost), 0.97 - 0.06 * number)
        ax.plot(lost, height, "x", transform=ax.get_xaxis_transform(), **style)


def _finish(axes: np.ndarray, table: pd.DataFrame) -> None:
    moduli = sorted(set(table.youngs_modulus_kpa))
    for ax in axes.ravel():
        ax.set_xticks(moduli, [f"{E:g}" for E in moduli])
        ax.minorticks_off()
    for ax, (_, title, _) in zip(axes[0], PANELS):
        ax.set_title(title, fontsize=8.5)
    axes[0, -1].set_yticks(TICKS, [f"{n:g}" for n in TICKS])
    for ax in axes[-1]:
        ax.set_xlabel("modulus of fat and gland (kPa)")
    axes[0, 0].plot([], [], "x", color=INK, label="failed or unstable")
