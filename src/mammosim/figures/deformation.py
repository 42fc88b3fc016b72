"""What gravity does to shapes: sweep, upright, morphing, the stress-free shape by several methods."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullFormatter
from matplotlib.tri import Triangulation

from mammosim.chain.outcome import CONVERGED
from mammosim.core.errors import MissingResult
from mammosim.core.mesh import TetMesh
from mammosim.figures.style import (
    BLUE,
    INK,
    QUIET,
    SEQUENTIAL,
    SERIES,
    VERMILION,
    new_figure,
    picture_axes,
    series_colour,
    styled,
)
from mammosim.figures.surfaces import boundary_triangles, draw_outlines

MARKERS = ("o", "s", "D", "^", "v", "P")


@styled
def sweep(table: pd.DataFrame) -> Figure:
    """Nipple error and largest displacement against the modulus (figure 1.14 of Mira 2018).

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
    """One volunteer upright with skins of several moduli, in the plane x_mm (figure 1.15 of Mira 2018).

    shapes: name -> loaded mesh; table: rows of study.sweep.upright_row of this volunteer.
    """
    figure = new_figure(3.6)
    left, right = figure.subplots(1, 2, width_ratios=(1, 1.15))
    draw_outlines(left, shapes, "sagittal", x_mm)
    left.set_title(f"skin, x = {x_mm:.0f} mm")
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    rows = table.sort_values("skin_kpa")
    names = ["none" if E == 0 else f"{E:g} kPa" for E in rows.skin_kpa]
    colours = [series_colour(number) for number in range(len(rows))]
    bars = right.bar(names, rows.max_displacement_mm, color=colours, width=0.62)
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
    """Measured and stress-free shapes in a sagittal and an axial plane (figures 1.16 and 1.17 of Mira 2018).

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


@styled
def morph(
    shapes: Mapping[str, TetMesh], distance_mm: np.ndarray, history: pd.DataFrame, *, x_mm: float, z_mm: float
) -> Figure:
    """Outlines of the shapes, the morphed one's distance to the target from the front, and its regularity.

    shapes: name -> mesh, of which one is `morphed`; distance_mm (n_node,) of the skin of that one; history:
    rows of chain.morph.MorphStep; x_mm, z_mm: the sagittal and the axial plane.
    """
    figure = new_figure(6.0)
    (sagittal, axial), (front, regular) = figure.subplots(2, 2, width_ratios=(1, 1.35))
    draw_outlines(sagittal, shapes, "sagittal", x_mm)
    draw_outlines(axial, shapes, "axial", z_mm)
    sagittal.set_title(f"sagittal, x = {x_mm:.0f} mm")
    axial.set_title(f"axial, z = {z_mm:.0f} mm")
    _draw_distance(figure, front, shapes["morphed"], distance_mm)
    _draw_regularity(regular, history)
    figure.legend(*sagittal.get_legend_handles_labels(), loc="outside lower center", ncols=len(shapes))
    return figure


def _draw_distance(figure: Figure, ax: Axes, body: TetMesh, distance_mm: np.ndarray) -> None:
    """The distance as colour on the skin that is seen from the front."""
    triangles = boundary_triangles(body.boundaries["skin"])
    a, b, c = (body.points[triangles[:, i]] for i in range(3))
    seen = triangles[np.cross(b - a, c - a)[:, 1] < 0]
    x, _, z = body.points.T
    surface = Triangulation(x, z, seen)
    colours = ax.tripcolor(surface, distance_mm, shading="gouraud", cmap=SEQUENTIAL, vmin=0, vmax=2)
    bar = figure.colorbar(colours, ax=ax, shrink=0.55, pad=0.02, extend="max")
    bar.set_label("distance (mm)")
    picture_axes(ax)
    ax.set(
        title="remaining distance, from the front", xlabel="x to the left (mm)", ylabel="z to superior (mm)"
    )


def _draw_regularity(ax: Axes, history: pd.DataFrame) -> None:
    """Distance and strain energy against the stiffness of the attraction, level by level."""
    levels = history[history.level > 0]
    s = levels.stiffness_kpa_per_mm
    ax.loglog(s, levels.mean_mm, "o-", color=BLUE, label="mean distance")
    ax.loglog(s, levels.p95_mm, "o:", color=BLUE, fillstyle="none", label="95 % of the distances")
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.axhline(history.mean_mm.iloc[0], color=QUIET, ls="--", lw=1, label="mean before the morph")
    energy = ax.twinx()
    energy.semilogx(s, levels.energy_uj / 1000, "s-", color=VERMILION, label="strain energy")
    energy.spines["right"].set_visible(True)
    energy.grid(False)
    energy.set_ylim(bottom=0)
    energy.set_ylabel("strain energy at 1 kPa (mJ)", color=VERMILION)
    ax.set(
        xlabel="stiffness of the attraction (kPa/mm)",
        ylabel="distance of the skins (mm)",
        title="distance and strain energy",
    )
    lines = [*ax.get_lines(), *energy.get_lines()]
    ax.legend(
        lines,
        [str(line.get_label()) for line in lines],
        loc="upper center",
        bbox_to_anchor=(0.5, -0.2),
        ncols=2,
    )


# Column of the table, title, the target that a method should stay below, if any.
UNLOADING_PANELS = (
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
    axes = figure.subplots(len(women), len(UNLOADING_PANELS), squeeze=False, sharex=True, sharey="col")
    for row, woman in zip(axes, women):
        for ax, (column, _, target) in zip(row, UNLOADING_PANELS):
            _draw_methods(ax, table[table.volunteer == woman], column)
            if target is not None:
                ax.axhline(target, color=QUIET, lw=1, ls=(0, (4, 3)))
        row[0].set_ylabel(str(woman))
    _finish_unloading(axes, table)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


def _draw_methods(ax: Axes, rows: pd.DataFrame, column: str) -> None:
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


def _finish_unloading(axes: np.ndarray, table: pd.DataFrame) -> None:
    moduli = sorted(set(table.youngs_modulus_kpa))
    for ax in axes.ravel():
        ax.set_xticks(moduli, [f"{E:g}" for E in moduli])
        ax.minorticks_off()
    for ax, (_, title, _) in zip(axes[0], UNLOADING_PANELS):
        ax.set_title(title, fontsize=8.5)
    axes[0, -1].set_yticks(TICKS, [f"{n:g}" for n in TICKS])
    for ax in axes[-1]:
        ax.set_xlabel("modulus of fat and gland (kPa)")
    axes[0, 0].plot([], [], "x", color=INK, label="failed or unstable")
