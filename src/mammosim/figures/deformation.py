"""What gravity does: the elasticity sweep, upright with and without skin, stress-free estimates."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from mammosim.chain.outcome import CONVERGED
from mammosim.core.errors import MissingResult
from mammosim.core.mesh import TetMesh
from mammosim.figures.outlines import draw_outlines
from mammosim.figures.style import QUIET, SERIES, new_figure, series_colour, styled

MARKERS = ("o", "s", "D", "^", "v", "P")


@styled
def sweep(table: pd.DataFrame) -> Figure:
    """Nipple error and largest displacement against the modulus (the report's figure 1.14).

    table: rows of study.sweep.sweep_row. A row without solution is a cross at the top, in
    the colour of its volunteer.
    """
    figure = new_figure(3.2)
    error, way = figure.subplots(1, 2)
    for number, (volunteer, rows) in enumerate(table.sort_values("youngs_modulus_kpa").groupby("volunteer")):
        for side, marker, fill in (("left", "o", "full"), ("right", "s", "none")):
            style = {"color": series_colour(number), "marker": marker, "fillstyle": fill}
            label = f"{volunteer}, {side}"
            error.plot(rows.youngs_modulus_kpa, rows[f"nipple_{side}_mm"], label=label, **style)
            error.axhline(
                rows[f"supine_{side}_mm"].iloc[0], color=series_colour(number), lw=0.9, ls=(0, (4, 3))
            )
        way.plot(
            rows.youngs_modulus_kpa,
            rows.max_displacement_mm,
            color=series_colour(number),
            marker=MARKERS[number % len(MARKERS)],
        )
    error.plot([], [], color=QUIET, lw=0.9, ls=(0, (4, 3)), label="before modelling")
    error.set(ylabel="predicted to measured nipple (mm)", title="nipple error")
    way.set(ylabel="largest displacement (mm)", title="supine to prone")
    for ax in (error, way):
        _draw_modulus_axis(ax, table.youngs_modulus_kpa)
        for number, (volunteer, rows) in enumerate(table.groupby("volunteer")):
            unsolved = rows[rows.outcome != CONVERGED].youngs_modulus_kpa
            _draw_unsolved(ax, unsolved, f"{volunteer}, no equilibrium found", number)
    figure.legend(*error.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _draw_modulus_axis(ax: Axes, moduli: pd.Series) -> None:
    ticks = sorted(set(moduli))
    ax.set_xscale("log")
    ax.set_xticks(ticks, [f"{E:g}" for E in ticks])
    ax.minorticks_off()
    ax.set_ylim(bottom=0)
    ax.set_xlabel("Young's modulus of the breast (kPa)")


def _draw_unsolved(ax: Axes, moduli: pd.Series, label: str, number: int) -> None:
    if len(moduli):
        ax.plot(
            moduli,
            np.full(len(moduli), 0.97 - 0.05 * number),
            "x",
            color=series_colour(number),
            mew=2,
            transform=ax.get_xaxis_transform(),
            label=label,
        )


@styled
def upright(shapes: Mapping[str, TetMesh], table: pd.DataFrame, *, x_mm: float) -> Figure:
    """One volunteer upright with skins of several moduli, in the plane x_mm (the report's figure 1.15).

    shapes: name -> loaded mesh; table: rows of study.sweep.upright_row of this volunteer.
    """
    figure = new_figure(3.6)
    left, right = figure.subplots(1, 2, width_ratios=(1, 1.15))
    draw_outlines(left, shapes, "sagittal", x_mm)
    left.set_title(f"skin in the plane x = {x_mm:.0f} mm")
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    rows = table.sort_values("skin_kpa")
    names = ["none" if E == 0 else f"{E:g} kPa" for E in rows.skin_kpa]
    bars = right.bar(names, rows.max_displacement_mm, color=SERIES[: len(rows)], width=0.62)
    bare = rows.max_displacement_mm[rows.skin_kpa == 0]
    labels = [
        f"{d:.1f}" if E == 0 or not len(bare) else f"{d:.1f}\n({100 * (d / bare.iloc[0] - 1):+.0f} %)"
        for E, d in zip(rows.skin_kpa, rows.max_displacement_mm)
    ]
    right.bar_label(bars, labels, padding=2, fontsize=8)
    right.margins(y=0.18)
    right.set(xlabel="Young's modulus of the skin", ylabel="largest displacement, prone to upright (mm)")
    right.grid(False, axis="x")
    return figure


@styled
def stress_free(shapes: Mapping[str, TetMesh], *, x_mm: float, z_mm: float) -> Figure:
    """Measured and stress-free shapes in a sagittal and an axial plane (the report's figures 1.16 and 1.17).

    shapes: name -> mesh, e.g. measured prone, reverse gravity, fixed point, and the truth where it is known.
    """
    figure = new_figure(3.7)
    axes = figure.subplots(1, 2, width_ratios=(1, 1.6))
    draw_outlines(axes[0], shapes, "sagittal", x_mm)
    draw_outlines(axes[1], shapes, "axial", z_mm)
    axes[0].set_title(f"sagittal, x = {x_mm:.0f} mm")
    axes[1].set_title(f"axial, z = {z_mm:.0f} mm")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 4))
    return figure


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
    figure = new_figure(3.2)
    axes = figure.subplots(1, len(women), squeeze=False, sharey=True)[0]
    for ax, woman in zip(axes, women):
        for number, method in enumerate(methods):
            history = rows[(rows.volunteer == woman) & (rows.method == method)].sort_values("iteration")
            style = {"color": series_colour(number), "marker": MARKERS[number % len(MARKERS)]}
            ax.semilogy(history.iteration, history.max_mm, label=method.replace("_", " "), **style)
        ax.axhline(tolerance_mm, color=QUIET, ls="--", lw=1, label="tolerance")
        ax.set(xlabel="iteration", title=str(woman))
        ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes[0].set_ylabel("largest distance of the reloaded\nfrom the measured skin (mm)")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure
