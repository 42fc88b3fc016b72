"""Beams, glandular dose by several routes and beside AAPM report 195, and what thickness costs."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from mammosim.figures.series import (
    COLUMNS,
    MOST,
    add_legend,
    colours,
    labelled,
    markers,
    numbered,
    panels,
    some,
)
from mammosim.figures.style import INK, QUIET, new_figure, styled

BEAM_ROW = 0.19  # inches of a beam among many


@styled
def spectra(table: pd.DataFrame, quality: pd.DataFrame) -> Figure:
    """The first beam over the others; beside it the half-value layer of each, before and behind the paddle.

    table: energy_kev, photons_per_mm2_mas, beam; quality: rows of xray.quality.quality_table of these beams.
    """
    names = list(quality.beam)
    height = max(2.0, BEAM_ROW * len(names))
    figure = new_figure(3.7 + height)
    left, right = figure.subplots(2, 1, height_ratios=(2.6, height))
    colour = colours(names[1:])
    for number, name in reversed(list(enumerate(names))):
        rows = table[table.beam == name]
        share = rows.photons_per_mm2_mas / rows.photons_per_mm2_mas.sum()
        hue, width = (INK, 2.0) if number == 0 else (colour[name], 1.0)
        left.plot(rows.energy_kev, share, color=hue, lw=width, label=name)
    left.set(xlabel="energy (keV)", ylabel="share of the photons (-)")
    left.set_ylim(bottom=0)
    left.margins(x=0.01)
    left.set_title("beams in vacuum")
    places = range(len(names))
    right.barh(places, quality.hvl_behind_mm_al, color=QUIET, height=0.6, label="behind the paddle")
    right.plot(quality.hvl_mm_al, places, "o", color=INK, ms=4, label="before the paddle")
    right.set_yticks(places, names)
    right.invert_yaxis()
    right.set(xlabel="half-value layer (mm Al)")
    right.grid(False, axis="y")
    right.set_title("half-value layers")
    add_legend(figure, [*some(labelled(left)[::-1], "beams"), *labelled(right)], ncols=3)
    return figure


@styled
def report195(table: pd.DataFrame) -> Figure:
    """Our energies less those of AAPM report 195, percent, three standard errors and tolerances; per beam.

    table: rows of xray.verification.report195_rows.
    """
    beams = list(dict.fromkeys(table.beam))
    figure, axes = panels(len(beams), 2.8, sharey=True)
    for ax, beam in zip(axes, beams):
        rows = table[table.beam == beam].reset_index(drop=True)
        ax.bar(
            rows.index, 2 * rows.gate_percent, bottom=-rows.gate_percent, color=QUIET, alpha=0.3, width=0.8
        )
        error = 3 * 100 * rows.standard_error_ev / rows.reference_ev
        for within, colour in colours((True, False)).items():
            part = rows[rows.within == within]
            ax.errorbar(
                part.index, part.difference_percent, error[part.index], fmt="o", ms=4, capsize=3, color=colour
            )
        ax.axhline(0, color=QUIET, lw=0.8)
        ax.set_xticks(rows.index, rows.quantity, rotation=30, ha="right")
        ax.set_title(beam)
        ax.grid(False, axis="x")
    for ax in axes[::COLUMNS]:
        ax.set_ylabel("ours less AAPM 195 (%)")
    return figure


@styled
def dose_routes(routes: pd.DataFrame, standard: pd.DataFrame) -> Figure:
    """Dose over incident air kerma by every route and protocol: of each breast, and of standard ones.

    routes: rows of xray.dose_routes.three_routes with volunteer and side; standard: rows of standard_rows.
    """
    figure = new_figure(3.0)
    left, right = figure.subplots(1, 2, sharey=True)
    breasts = list(dict.fromkeys(routes.volunteer + " " + routes.side))
    ways = routes.groupby(["route", "protocol"], sort=False)
    looks = _looks(max(len(ways), 1 + standard.route.nunique()))
    step = min(0.2, 0.6 / len(ways))
    for number, ((route, protocol), rows) in enumerate(ways):
        label = protocol if route in protocol else f"{protocol}, {route}"
        places = [breasts.index(name) + step * (number - 1) for name in rows.volunteer + " " + rows.side]
        left.errorbar(places, rows.agd_mgy_per_mgy, 2 * rows.standard_error, label=label, **looks[number])
    left.set_xlim(-0.6, len(breasts) - 0.4)
    left.set_xticks(np.arange(len(breasts)), breasts)
    left.set_title("this study's breasts")
    left.grid(False, axis="x")
    for number, (_, rows) in enumerate(standard.groupby("route", sort=False), start=1):
        error = 2 * rows.standard_error
        right.errorbar(rows.thickness_mm, rows.agd_mgy_per_mgy, error, ls="-", **looks[number])
    right.set(xlabel="thickness (mm)")
    right.set_title(f"standard breasts, {standard.glandularity_percent.iloc[0]:.0f} % gland")
    left.set_ylabel("glandular dose per incident\nair kerma (mGy/mGy)")
    left.set_ylim(bottom=0)
    right.margins(x=0.12)
    handles = labelled(left)
    add_legend(figure, handles, ncols=1 if len(handles) <= MOST else 3)
    return figure


def _looks(number: int) -> list[dict[str, Any]]:
    """Marker and colour of each of so many routes."""
    colour, marker = colours(range(number)), markers(range(number))
    return [{"fmt": marker[k], "color": colour[k], "ms": 5, "capsize": 3} for k in range(number)]


# Column, its error, label.
TRADE_OFF_PANELS = (
    ("dose_mgy", "dose_se_mgy", "glandular dose (mGy),\nMonte Carlo, this breast"),
    ("mas", "", "automatic exposure (mAs)"),
    ("scatter_to_primary", "", "scatter to primary (-)"),
    ("cnr_quantum", "", "mass: contrast over\nnoise of a pixel (-)"),
    ("calcification_cnr", "", "calcifications: contrast\nover noise of a pixel (-)"),
    ("calcification_d_expected", "", "calcifications: d' of\nan observer (-)"),
)


@styled
def trade_off(table: pd.DataFrame) -> Figure:
    """A panel per quantity against the compressed thickness; a marker per strategy, a colour per breast.

    table: rows of study.report.trade_off.trade_off. Bars: one standard error, or 95 %.
    """
    figure = new_figure(6.6)
    axes = figure.subplots(3, 2, sharex=True)
    strategies = dict.fromkeys(table.strategy)
    table = table.assign(breast=table.volunteer + " " + table.side).sort_values(
        ["volunteer", "side"], kind="stable"
    )
    colour, marker = colours(table.breast), numbered(strategies)
    size = MARK if len(strategies) <= MOST else NUMBER
    for ax, (column, error, label) in zip(axes.ravel(), TRADE_OFF_PANELS):
        for breast, rows in table.groupby("breast", sort=False):
            _draw_breast(ax, rows.sort_values("thickness_mm"), column, error, colour[str(breast)])
        for strategy, rows in table.groupby("strategy", sort=False):
            colours_of = list(rows.breast.map(colour))
            ax.scatter(
                rows.thickness_mm, rows[column], s=size**2, c=colours_of, marker=marker[strategy], zorder=3
            )
        ax.set_ylabel(label)
        ax.set_ylim(0, 1.08 * ax.dataLim.y1)
    for ax in axes[-1]:
        ax.set_xlabel("compressed thickness (mm)")
    breasts = [Line2D([], [], color=each, label=name) for name, each in colour.items()]
    ways = [Line2D([], [], ls="", marker=each, color=QUIET, label=name) for name, each in marker.items()]
    add_legend(figure, [*some(breasts, "breasts"), *ways])
    return figure


MARK, NUMBER = 4.5, 7.5  # points


def _draw_breast(ax: Axes, rows: pd.DataFrame, column: str, error: str, colour: str) -> None:
    """One breast: a line through its strategies, with error bars."""
    ax.plot(rows.thickness_mm, rows[column], color=colour, lw=1)
    if error:
        ax.errorbar(rows.thickness_mm, rows[column], rows[error], fmt="none", color=colour, capsize=2, lw=1)
