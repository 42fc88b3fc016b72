"""Moduli: how a fit came to them, how near the true ones they are, and what follows from them."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullLocator

from mammosim.chain.quantities import QUANTILE
from mammosim.figures.series import add_legend, colours, some
from mammosim.figures.style import (
    BLUE,
    INK,
    ORANGE,
    QUIET,
    SEQUENTIAL,
    SMALLEST,
    VERMILION,
    new_figure,
    styled,
)
from mammosim.figures.ticks import plain_log

SIDES = {"left": ("o", BLUE, 0.15), "right": ("s", ORANGE, -0.15)}
TISSUES = ("muscle", "skin", "glandular", "adipose")  # upward


@styled
def identification(
    grid: pd.DataFrame, history: pd.DataFrame, moduli: pd.DataFrame, prior: Mapping[str, Mapping[str, float]]
) -> Figure:
    """The map of the grid, the path of the fit, and the moduli.

    grid: rows of study.identification.fit.grid_table; history: of FitStep; moduli: of posterior.moduli_table;
    prior: median_kpa, factor.
    Grey bars: 95 % of the prior. Hollow: not identifiable from these data.
    """
    figure = new_figure(5.6)
    axes = figure.subplot_mosaic([["map", "way"], ["moduli", "moduli"]], width_ratios=(1.2, 1))
    _draw_map(figure, axes["map"], grid)
    _draw_way(axes["way"], history)
    _draw_moduli(axes["moduli"], moduli, prior)
    return figure


NUMBERED = 8  # pairs of moduli along a side of the grid whose numbers have room


def _draw_map(figure: Figure, ax: Axes, grid: pd.DataFrame) -> None:
    left = grid.pivot(index="skin_kpa", columns="breast_kpa", values="skin_rms_mm")
    picture = ax.imshow(np.ma.masked_invalid(left), origin="lower", cmap=SEQUENTIAL, aspect="auto")
    middle = np.nanmean([np.nanmin(left.values), np.nanmax(left.values)])
    for i, row in enumerate(left.values if max(left.shape) <= NUMBERED else ()):
        for j, value in enumerate(row):
            words = f"{value:.2f}" if np.isfinite(value) else "failed"
            colour = "white" if np.isfinite(value) and value < middle else INK
            ax.text(j, i, words, ha="center", va="center", color=colour, fontsize=SMALLEST)
    ax.set_xticks(range(len(left.columns)), [f"{E:g}" for E in left.columns])
    ax.set_yticks(range(len(left.index)), [f"{E:g}" for E in left.index])
    ax.grid(visible=False)
    ax.set(title="grid of moduli", xlabel="fat and gland (kPa)", ylabel="skin (kPa)")
    figure.colorbar(picture, ax=ax).set_label("residual of the skin, rms (mm)")


def _draw_way(ax: Axes, history: pd.DataFrame) -> None:
    ax.semilogy(history.iteration, history.skin_rms_mm, "o-", color=BLUE, label="skin")
    ax.semilogy(history.iteration, history.marker_rms_mm, "s-", color=VERMILION, label="markers")
    ax.set(title="iterations of the fit", xlabel="iteration", ylabel="residual, rms (mm)")
    ax.set_xticks(history.iteration)
    plain_log(ax.yaxis)
    ax.legend(loc="upper right")


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
    plain_log(ax.xaxis)
    ax.set_yticks(range(len(TISSUES)), TISSUES)
    ax.set(
        title="moduli with 95 % intervals", xlabel="Young's modulus (kPa)", ylim=(-0.6, len(TISSUES) - 0.4)
    )
    ax.legend(loc="lower left")


TICKS_KPA = np.outer([0.01, 0.1, 1, 10, 100, 1000], [1, 2, 5]).ravel()
MARGIN = 1.25  # of the axes beyond the smallest and the largest modulus


@styled
def recovery(table: pd.DataFrame) -> Figure:
    """One picture per tissue that the volunteers have, both axes logarithmic; on the line is right.

    table: rows of study.identification.scores.scored. Hollow: not identifiable; vermilion: the truth is
    outside.
    """
    table = table[table.true_kpa > 0]
    tissues = list(dict.fromkeys(table.tissue))
    rows = -(-len(tissues) // 2)
    figure = new_figure(0.6 + 3.2 * rows)
    axes = figure.subplots(rows, 2, squeeze=False).ravel()
    for ax, tissue in zip(axes, tissues):
        _draw_recovered(ax, table[table.tissue == tissue])
        ax.set_title(tissue)
    for ax in axes[len(tissues) :]:
        ax.set_axis_off()
    figure.legend(handles=_recovered_legend(), ncols=4, loc="outside upper center")
    return figure


def _draw_recovered(ax: Axes, table: pd.DataFrame) -> None:
    table = table[np.isfinite(table.fitted_kpa)]
    for row in table.itertuples():
        marker, colour = SIDES[str(row.side)][:2]
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


def _recovered_legend() -> list[Line2D]:
    marks = [Line2D([], [], ls="", marker=m, color=c, label=side) for side, (m, c, _) in SIDES.items()]
    marks.append(Line2D([], [], color=VERMILION, marker="o", label="truth outside its interval"))
    marks.append(Line2D([], [], color=QUIET, marker="o", mfc="white", label="not identifiable"))
    return marks


NIPPLE = {"nipple_x_mm": "x", "nipple_y_mm": "y", "nipple_z_mm": "z"}


@styled
def propagation(table: pd.DataFrame) -> Figure:
    """Intervals of the nipples about the fit, and of force and dose, each side of each volunteer a line.

    table: volunteer, side and rows of study.identification.propagation; what was measured is a cross.
    """
    lines = table[["volunteer", "side"]].drop_duplicates()
    heights = (0.62 * len(lines) + 0.3, max(0.2 * len(lines), 0.4) + 0.3)
    figure = new_figure(1.7 + sum(heights))
    axes = figure.subplot_mosaic([["nipple", "nipple"], ["force", "dose"]], height_ratios=heights)
    nipple, force, dose = (axes[name] for name in ("nipple", "force", "dose"))
    places = table[table.quantity.isin(NIPPLE)]
    names = places.volunteer + ", " + places.side + ", " + places.quantity.map(NIPPLE)
    _draw_intervals(nipple, places.assign(name=names), about_fit=True)
    nipple.set(xlabel="nipple, from where the fit predicts it (mm)", title="nipple, held-out position")
    for ax, quantity, label, title in (
        (force, "force_n", "force (N)", "compression"),
        (dose, "agd_mgy", "glandular dose (mGy)", "dose"),
    ):
        rows = table[table.quantity == quantity]
        _draw_intervals(ax, rows.assign(name=rows.volunteer + ", " + rows.side))
        ax.set(xlabel=label, title=title)
        ax.set_xlim(0, 1.15 * ax.get_xlim()[1])
    figure.legend(*nipple.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _draw_intervals(ax: Axes, rows: pd.DataFrame, *, about_fit: bool = False) -> None:
    """A bar from low to high, the fit on it, and what was measured."""
    zero = rows.fit if about_fit else 0.0
    place = range(len(rows))
    ax.hlines(place, rows.low - zero, rows.high - zero, colors=BLUE, lw=5, alpha=0.55, label="all draws")
    ax.plot(rows.fit - zero, place, "o", color=INK, ms=4.5, label="fit")
    ax.plot(rows.measured - zero, place, "x", color=VERMILION, mew=1.8, label="measured")
    ax.set_yticks(place, rows.name)
    ax.set_ylim(len(rows) - 0.4, -0.6)
    ax.grid(False, axis="y")


SOFTENING_PANELS = {
    "nipple_moved_mm": ("nipple upright", "moved (mm)"),
    "force_n": ("to the same thickness", "force (N)"),
    "thickness_mm": ("at the same force", "between the plates (mm)"),
    "agd_mgy": ("at the same force", "glandular dose (mGy)"),
}
SOFTENING_LINES = {"glandular": "-", "all": ":"}


@styled
def softening(table: pd.DataFrame) -> Figure:
    """A panel per quantity against the factor of the moduli.

    table: rows of study.identification.softening with volunteer and side.
    """
    figure = new_figure(4.6)
    breasts = {" ".join(name): part for name, part in table.groupby(["volunteer", "side"], sort=False)}
    colour = colours(breasts)
    for ax, (column, (title, label)) in zip(figure.subplots(2, 2).ravel(), SOFTENING_PANELS.items()):
        for name, part in breasts.items():
            today = part[part.factor == 1.0]
            for tissue, line in SOFTENING_LINES.items():
                rows = pd.concat([today, part[(part.tissue == tissue) & (part.factor != 1.0)]])
                rows = rows.sort_values("factor")
                ax.plot(100 * (rows.factor - 1), rows[column], line, marker="o", ms=4, color=colour[name])
        ax.set(title=title, ylabel=label, xlabel="change of the moduli (%)")
    marks = some([Line2D([], [], color=each, label=name) for name, each in colour.items()], "breasts")
    marks += [
        Line2D([], [], color=INK, ls=line, label=f"{name} changed") for name, line in SOFTENING_LINES.items()
    ]
    add_legend(figure, marks)
    return figure
