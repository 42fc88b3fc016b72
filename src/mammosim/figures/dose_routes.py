"""Glandular dose by several routes side by side, and the transport behind it beside AAPM report 195."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from mammosim.figures.style import QUIET, SERIES, new_figure, series_colour, styled

MARKERS = ("o", "s", "D", "^")


@styled
def report195(table: pd.DataFrame) -> Figure:
    """Our energies less those of the report, percent, with three standard errors, over the gates; per beam.

    table: rows of xray.verification.report195_rows.
    """
    beams = list(dict.fromkeys(table.beam))
    figure = new_figure(2.8)
    axes = figure.subplots(1, len(beams), squeeze=False, sharey=True)[0]
    for ax, beam in zip(axes, beams):
        rows = table[table.beam == beam].reset_index(drop=True)
        ax.bar(
            rows.index, 2 * rows.gate_percent, bottom=-rows.gate_percent, color=QUIET, alpha=0.3, width=0.8
        )
        error = 3 * 100 * rows.standard_error_ev / rows.reference_ev
        for within, colour in ((True, SERIES[0]), (False, SERIES[1])):
            part = rows[rows.within == within]
            ax.errorbar(
                part.index, part.difference_percent, error[part.index], fmt="o", ms=4, capsize=3, color=colour
            )
        ax.axhline(0, color=QUIET, lw=0.8)
        ax.set_xticks(rows.index, rows.quantity, rotation=30, ha="right", fontsize=7)
        ax.set_title(beam)
        ax.grid(False, axis="x")
    axes[0].set_ylabel("ours less the report (%)")
    return figure


@styled
def dose_routes(routes: pd.DataFrame, standard: pd.DataFrame) -> Figure:
    """Dose over incident air kerma by every route and protocol: of each breast, and of standard ones.

    routes: rows of xray.dose_routes.three_routes with volunteer and side; standard: rows of standard_rows.
    """
    figure = new_figure(3.0)
    left, right = figure.subplots(1, 2, sharey=True)
    breasts = list(dict.fromkeys(routes.volunteer + " " + routes.side))
    for number, ((route, protocol), rows) in enumerate(routes.groupby(["route", "protocol"], sort=False)):
        label = protocol if route in protocol else f"{protocol}, {route}"
        places = [breasts.index(name) + 0.2 * (number - 1) for name in rows.volunteer + " " + rows.side]
        left.errorbar(places, rows.agd_mgy_per_mgy, 2 * rows.standard_error, label=label, **_style(number))
    left.set_xlim(-0.6, len(breasts) - 0.4)
    left.set_xticks(np.arange(len(breasts)), breasts)
    left.set_title("this study's breasts", fontsize=8.5)
    left.grid(False, axis="x")
    for (_, rows), number in zip(standard.groupby("route", sort=False), (1, 2)):
        right.errorbar(
            rows.thickness_mm, rows.agd_mgy_per_mgy, 2 * rows.standard_error, ls="-", **_style(number)
        )
    right.set(xlabel="thickness (mm)")
    right.set_title(f"standard breasts, {standard.glandularity_percent.iloc[0]:.0f} % gland", fontsize=8.5)
    left.set_ylabel("glandular dose per incident\nair kerma (mGy/mGy)")
    left.set_ylim(bottom=0)
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=1, fontsize=7.5)
    return figure


def _style(number: int) -> dict[str, Any]:
    """Marker and colour of a route."""
    return {"fmt": MARKERS[number % len(MARKERS)], "color": series_colour(number), "ms": 5, "capsize": 3}
