"""Moduli from two positions: the map of the search by hand, the way of the fit, moduli with intervals."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mammosim.figures.style import BLUE, INK, ORANGE, QUIET, SEQUENTIAL, VERMILION, new_figure, styled
from mammosim.study.identification.posterior import QUANTILE

SIDES = {"left": ("o", BLUE, 0.15), "right": ("s", ORANGE, -0.15)}
TISSUES = ("muscle", "skin", "glandular", "adipose")  # upward


@styled
def identification(
    grid: pd.DataFrame, history: pd.DataFrame, moduli: pd.DataFrame, prior: Mapping[str, Mapping[str, float]]
) -> Figure:
    """The map of the grid, the path of the fit, and the moduli.

    grid: rows of study.identification.search; history: of FitStep; moduli: of study.identification.posterior;
    prior: median_kpa, factor.
    Grey bars: 95 % of the prior. Hollow: not identifiable from these data.
    """
    figure = new_figure(5.6)
    axes = figure.subplot_mosaic([["map", "way"], ["moduli", "moduli"]], width_ratios=(1.2, 1))
    _draw_map(figure, axes["map"], grid)
    _draw_way(axes["way"], history)
    _draw_moduli(axes["moduli"], moduli, prior)
    return figure


def _draw_map(figure: Figure, ax: Axes, grid: pd.DataFrame) -> None:
    left = grid.pivot(index="skin_kpa", columns="breast_kpa", values="skin_rms_mm")
    picture = ax.imshow(np.ma.masked_invalid(left), origin="lower", cmap=SEQUENTIAL, aspect="auto")
    middle = np.nanmean([np.nanmin(left.values), np.nanmax(left.values)])
    for i, row in enumerate(left.values):
        for j, value in enumerate(row):
            words = f"{value:.2f}" if np.isfinite(value) else "failed"
            colour = "white" if np.isfinite(value) and value < middle else INK
            ax.text(j, i, words, ha="center", va="center", color=colour, fontsize=8)
    ax.set_xticks(range(len(left.columns)), [f"{E:g}" for E in left.columns])
    ax.set_yticks(range(len(left.index)), [f"{E:g}" for E in left.index])
    ax.grid(visible=False)
    ax.set(title="search by hand", xlabel="fat and gland (kPa)", ylabel="skin (kPa)")
    figure.colorbar(picture, ax=ax).set_label("left of the skin, rms (mm)")


def _draw_way(ax: Axes, history: pd.DataFrame) -> None:
    ax.semilogy(history.iteration, history.skin_rms_mm, "o-", color=BLUE, label="skin")
    ax.semilogy(history.iteration, history.marker_rms_mm, "s-", color=VERMILION, label="markers")
    ax.set(title="the fit: left of the data, rms (mm)", xlabel="iteration")
    ax.set_xticks(history.iteration)
    ax.legend()


def _draw_moduli(ax: Axes, moduli: pd.DataFrame, prior: Mapping[str, Mapping[str, float]]) -> None:
    for n, tissue in enumerate(TISSUES):
        median, reach = prior["median_kpa"][tissue], prior["factor"][tissue] ** QUANTILE
        ax.plot([median / reach, median * reach], [n, n], color="#d5dae0", lw=14, solid_capstyle="butt")
    for row in moduli[moduli.tissue.isin(TISSUES)].itertuples():
        marker, colour, aside = SIDES[str(row.side)]
        place = TISSUES.index(str(row.tissue)) + aside
        colour = colour if row.identifiable else QUIET
        ax.plot([row.low_kpa, row.high_kpa], [place, place], color=colour)
        ax.plot(row.fitted_kpa, place, marker, color=colour, mfc=colour if row.identifiable else "white")
    for side, (marker, colour, _) in SIDES.items():
        ax.plot([], [], marker, color=colour, label=side)
    ax.set_xscale("log")
    ax.set_yticks(range(len(TISSUES)), TISSUES)
    ax.set(
        title="moduli with 95 % intervals", xlabel="Young's modulus (kPa)", ylim=(-0.6, len(TISSUES) - 0.4)
    )
    ax.legend(loc="upper left")
