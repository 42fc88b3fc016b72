"""Beams, glandular dose by several routes and beside AAPM report 195, and what thickness costs."""

from itertools import cycle
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mammosim.figures.style import INK, QUIET, SERIES, new_figure, series_colour, styled


@styled
def spectra(table: pd.DataFrame, quality: pd.DataFrame) -> Figure:
    """The first beam over the others; beside it the half-value layer of each, before and behind the paddle.

    table: energy_kev, photons_per_mm2_mas, beam; quality: rows of xray.quality.quality_table of these beams.
    """
    figure = new_figure(3.0)
    left, right = figure.subplots(1, 2, width_ratios=(1.5, 1))
    names = list(quality.beam)
    for number, name in reversed(list(enumerate(names))):
        rows = table[table.beam == name]
        share = rows.photons_per_mm2_mas / rows.photons_per_mm2_mas.sum()
        colour, width = (INK, 2.0) if number == 0 else (SERIES[(number - 1) % len(SERIES)], 1.0)
        left.plot(rows.energy_kev, share, color=colour, lw=width, label=name)
    left.set(xlabel="energy (keV)", ylabel="share of the photons")
    left.set_ylim(bottom=0)
    left.legend(reverse=True, fontsize=7)
    places = range(len(names))
    right.barh(places, quality.hvl_behind_mm_al, color=QUIET, height=0.6, label="behind the paddle")
    right.plot(quality.hvl_mm_al, places, "o", color=INK, ms=4, label="before it")
    right.set_yticks(places, names, fontsize=7)
    right.invert_yaxis()
    right.set(xlabel="half-value layer (mm Al)")
    right.grid(False, axis="y")
    right.legend(fontsize=7, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return figure


MARKERS = ("o", "s", "D", "^", "v", "P")


@styled
def report195(table: pd.DataFrame) -> Figure:
    """Our energies less those of AAPM report 195, percent, three standard errors and tolerances; per beam.

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
    axes[0].set_ylabel("ours less AAPM 195 (%)")
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
        left.errorbar(
            places, rows.agd_mgy_per_mgy, 2 * rows.standard_error, label=label, **_route_style(number)
        )
    left.set_xlim(-0.6, len(breasts) - 0.4)
    left.set_xticks(np.arange(len(breasts)), breasts)
    left.set_title("this study's breasts", fontsize=8.5)
    left.grid(False, axis="x")
    for (_, rows), number in zip(standard.groupby("route", sort=False), (1, 2)):
        right.errorbar(
            rows.thickness_mm, rows.agd_mgy_per_mgy, 2 * rows.standard_error, ls="-", **_route_style(number)
        )
    right.set(xlabel="thickness (mm)")
    right.set_title(f"standard breasts, {standard.glandularity_percent.iloc[0]:.0f} % gland", fontsize=8.5)
    left.set_ylabel("glandular dose per incident\nair kerma (mGy/mGy)")
    left.set_ylim(bottom=0)
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=1, fontsize=7.5)
    return figure


def _route_style(number: int) -> dict[str, Any]:
    """Marker and colour of a route."""
    return {"fmt": MARKERS[number % len(MARKERS)], "color": series_colour(number), "ms": 5, "capsize": 3}


# Column, its error bars (below and above, or one for both), label.
TRADE_OFF_PANELS = (
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
    for ax, (column, errors, label) in zip(axes.ravel(), TRADE_OFF_PANELS):
        for number, (_, rows) in enumerate(table.groupby(["volunteer", "side"])):
            _draw_breast(
                ax, rows.sort_values("thickness_mm"), column, errors, series_colour(number), strategies
            )
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


def _draw_breast(
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
