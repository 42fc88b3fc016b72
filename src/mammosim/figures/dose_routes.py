"""Dose by several routes side by side, and the transport beside AAPM report 195."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from mammosim.figures.style import BLUE, INK, QUIET, VERMILION, new_figure, styled


@styled
def dose_routes(table: pd.DataFrame) -> Figure:
    """Mean glandular dose per incident air kerma of each breast, by each route; bars: two standard errors.

    table: of xray.dose_routes; a group of bars per protocol, thickness and glandularity.
    """
    kinds = ["protocol", "thickness_mm", "glandularity_percent"]
    groups = list(table.groupby(kinds, sort=False))
    figure = new_figure(0.9 + 0.5 * len(groups))
    ax = figure.subplots()
    for n, (_, rows) in enumerate(groups):
        for i, row in enumerate(rows.itertuples()):
            y = n + 0.34 * (i - (len(rows) - 1) / 2)
            colour = BLUE if row.route == "Monte Carlo" else VERMILION
            error = 2 * row.standard_error or None
            ax.barh(y, row.agd_mgy_per_mgy, 0.3, xerr=error, color=colour, capsize=2, label=row.route)
            ax.text(row.agd_mgy_per_mgy * 1.015, y, f"{row.agd_mgy_per_mgy:.3f}", va="center", fontsize=7.5)
    ax.set_yticks(
        range(len(groups)),
        [f"{protocol.split(',')[0]}\n{t:.0f} mm, {gland:.0f} % gland" for (protocol, t, gland), _ in groups],
    )
    ax.invert_yaxis()
    ax.margins(x=0.1)
    ax.grid(False, axis="y")
    ax.set_xlabel("mean glandular dose per incident air kerma (mGy/mGy)")
    labels = dict(zip(*reversed(ax.get_legend_handles_labels())))
    ax.legend(labels.values(), labels.keys(), loc="lower right", bbox_to_anchor=(1, 1), ncols=2)
    return figure


@styled
def verification(table: pd.DataFrame) -> Figure:
    """Differences from AAPM report 195 in per cent, with three standard errors; grey: the gate.

    table: of xray.verification.
    """
    beams = list(table["beam"].unique())
    figure = new_figure(3.2)
    for ax, beam in zip(np.atleast_1d(figure.subplots(1, len(beams), sharey=True)), beams):
        rows = table[table["beam"] == beam]
        y = np.arange(len(rows))
        ax.barh(y, 2 * rows["gate_percent"], 0.7, left=-rows["gate_percent"], color=QUIET, alpha=0.25)
        error = 300 * rows["standard_error_ev"] / rows["reference_ev"]
        ax.errorbar(rows["difference_percent"], y, xerr=error, fmt="o", color=BLUE, ms=4, capsize=2)
        ax.axvline(0, color=INK, lw=0.8)
        ax.set(title=beam, xlabel="ours - report (%)")
        ax.set_yticks(y, rows["quantity"])
        ax.grid(False, axis="y")
    ax.invert_yaxis()
    return figure
