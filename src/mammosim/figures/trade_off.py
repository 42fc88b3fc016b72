"""What thickness costs: dose, exposure, scatter and contrast of every strategy of compression."""

from itertools import cycle
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mammosim.figures.style import QUIET, new_figure, series_colour, styled

MARKERS = ("o", "s", "D", "^", "v", "P")
# Column, its error bars (below and above, or one for both), label.
PANELS = (
    ("dose_mgy", ("dose_se_mgy",), "glandular dose (mGy),\nMonte Carlo, this breast"),
    ("mas", (), "automatic exposure (mAs)"),
    ("scatter_to_primary", (), "scatter to primary"),
    ("cnr_quantum", (), "mass: contrast over\nnoise of a pixel"),
    ("calcification_cnr", (), "calcifications: contrast\nover noise of a pixel"),
    ("calcification_d_expected", (), "calcifications: d' of\nan observer"),
)


@styled
def trade_off(table: pd.DataFrame) -> Figure:
    """A panel per quantity against the compressed thickness; a marker per strategy, a colour per breast.

    table: rows of study.report.trade_off.trade_off. Bars: one standard error, or 95 %.
    """
    figure = new_figure(5.2)
    axes = figure.subplots(2, 3, sharex=True)
    strategies = list(dict.fromkeys(table.strategy))
    for ax, (column, errors, label) in zip(axes.ravel(), PANELS):
        for number, (_, rows) in enumerate(table.groupby(["volunteer", "side"])):
            _draw(ax, rows.sort_values("thickness_mm"), column, errors, series_colour(number), strategies)
        ax.set_ylabel(label)
        ax.set_ylim(0, 1.08 * ax.dataLim.y1)
    for ax in axes[-1]:
        ax.set_xlabel("compressed thickness (mm)")
    for number, (breast, _) in enumerate(table.groupby(["volunteer", "side"])):
        axes[0, 0].plot([], [], color=series_colour(number), label=" ".join(breast))
    for strategy, marker in zip(strategies, cycle(MARKERS)):
        axes[0, 0].plot([], [], marker, color=QUIET, label=strategy)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def _draw(
    ax: Axes, rows: pd.DataFrame, column: str, errors: tuple[str, ...], colour: str, strategies: list[str]
) -> None:
    """One breast: a line through its strategies."""
    ax.plot(rows.thickness_mm, rows[column], color=colour, lw=1)
    for row in rows.itertuples():
        value = getattr(row, column)
        bar: Any = getattr(row, errors[0]) if len(errors) == 1 else None
        if len(errors) == 2:
            low, high = (getattr(row, name) for name in errors)
            bar = [[value - low], [high - value]]
        marker = MARKERS[strategies.index(row.strategy) % len(MARKERS)]
        ax.errorbar(row.thickness_mm, value, bar, fmt=marker, color=colour, ms=4.5, capsize=2, lw=1)
