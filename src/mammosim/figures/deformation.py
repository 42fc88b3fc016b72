"""What gravity does to shapes: sweep, upright, morphing, the stress-free shape by several methods."""

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from mammosim.chain.outcome import CONVERGED
from mammosim.core.mesh import TetMesh
from mammosim.figures.bodies import coloured_skin
from mammosim.figures.render import Camera, render
from mammosim.figures.series import (
    MOST,
    add_legend,
    colours,
    labelled,
    markers,
    some,
)
from mammosim.figures.style import (
    BAR_ROOM_MM,
    BLUE,
    QUIET,
    SEQUENTIAL,
    SMALLEST,
    VERMILION,
    new_figure,
    scale_bar,
    styled,
)
from mammosim.figures.surfaces import colours_of_shapes, draw_outlines
from mammosim.figures.ticks import plain_log

SIDES: Mapping[str, tuple[str, Literal["full", "none"]]] = {"left": ("o", "full"), "right": ("s", "none")}
BEFORE: dict[str, Any] = {"color": QUIET, "lw": 0.9, "ls": (0, (4, 3))}


@styled
def sweep(table: pd.DataFrame) -> Figure:
    """Nipple error and largest displacement against the modulus (figure 1.14 of Mira 2018).

    table: rows of study.sweep.sweep_row. A row without solution is a cross at the top, in
    the colour of its volunteer.
    """
    figure = new_figure(3.2)
    error, way = figure.subplots(1, 2)
    women = {str(name): rows for name, rows in table.sort_values("youngs_modulus_kpa").groupby("volunteer")}
    colour, marker = colours(women), markers(women)
    for name, rows in women.items():
        for side, (mark, fill) in SIDES.items():
            style = {"color": colour[name], "marker": mark, "fillstyle": fill}
            E = rows.youngs_modulus_kpa
            error.plot(E, rows[f"nipple_{side}_mm"], label=f"{name}, {side}", **style)
            error.axhline(rows[f"supine_{side}_mm"].iloc[0], **BEFORE | {"color": colour[name]})
        way.plot(rows.youngs_modulus_kpa, rows.max_displacement_mm, color=colour[name], marker=marker[name])
    error.plot([], [], label="before modelling", **BEFORE)
    error.set(ylabel="distance (mm)", title="predicted to measured nipple")
    way.set(ylabel="largest displacement (mm)", title="supine to prone")
    for ax in (error, way):
        _draw_modulus_axis(ax, table.youngs_modulus_kpa)
        _draw_unsolved(ax, table[table.outcome != CONVERGED], colour)
    handles = labelled(error) if len(women) <= MOST else _sweep_legend(error, colour)
    add_legend(figure, handles, ncols=3)
    return figure


def _sweep_legend(error: Axes, colour: Mapping[str, str]) -> list[Artist]:
    """Of more women than there are marks: their colours, then what is the same for all."""
    women = [Line2D([], [], color=each, label=name) for name, each in colour.items()]
    sides = [Line2D([], [], color=QUIET, marker=m, fillstyle=f, label=side) for side, (m, f) in SIDES.items()]
    unsolved = [line for line in labelled(error) if str(line.get_label()).endswith(NO_EQUILIBRIUM)]
    lost = Line2D(
        [], [], ls="", marker="x", mew=2, color=QUIET, label=f"{NO_EQUILIBRIUM}, {len(unsolved)} volunteers"
    )
    before = Line2D([], [], label="before modelling", **BEFORE)
    return [*some(women, "volunteers"), *sides, before, *([lost] if unsolved else [])]


def _draw_modulus_axis(ax: Axes, moduli: pd.Series) -> None:
    ticks = sorted(set(moduli))
    ax.set_xscale("log")
    ax.set_xticks(ticks, [f"{E:g}" for E in ticks])
    ax.minorticks_off()
    ax.set_ylim(bottom=0)
    ax.set_xlabel("Young's modulus of the breast (kPa)")


NO_EQUILIBRIUM = "no equilibrium found"


def _draw_unsolved(ax: Axes, unsolved: pd.DataFrame, colour: Mapping[str, str]) -> None:
    """Crosses at the top, those of each volunteer at a height of their own."""
    step = min(0.05, 0.6 / len(colour))
    for number, (name, each) in enumerate(colour.items()):
        moduli = unsolved[unsolved.volunteer == name].youngs_modulus_kpa
        if len(moduli):
            ax.plot(
                moduli,
                np.full(len(moduli), 0.97 - step * number),
                "x",
                color=each,
                mew=2,
                transform=ax.get_xaxis_transform(),
                label=f"{name}, {NO_EQUILIBRIUM}",
            )


@styled
def upright(shapes: Mapping[str, TetMesh], table: pd.DataFrame, *, x_mm: float) -> Figure:
    """One volunteer upright with skins of several moduli, in the plane x_mm (figure 1.15 of Mira 2018).

    shapes: name -> loaded mesh, at the end those of the rows, by modulus; table: rows of
    study.sweep.upright_row of this volunteer.
    """
    figure = new_figure(3.6)
    left, right = figure.subplots(1, 2, width_ratios=(1, 1.15))
    draw_outlines(left, shapes, "sagittal", x_mm)
    left.set_title(f"skin, x = {x_mm:.0f} mm")
    add_legend(figure, some(labelled(left), "skins"))
    rows = table.sort_values("skin_kpa")
    names = [
        ("none" if E == 0 else f"{E:g} kPa") + ("" if np.isfinite(d) else "\nno equi-\nlibrium")
        for E, d in zip(rows.skin_kpa, rows.max_displacement_mm)
    ]
    # Each skin has the colour of its outline.
    colour = [colours_of_shapes(shapes)[name] for name in list(shapes)[-len(rows) :]]
    bars = right.bar(range(len(rows)), rows.max_displacement_mm, color=colour, width=0.62)
    right.set_xticks(range(len(rows)), names)
    bare = rows.max_displacement_mm[rows.skin_kpa == 0].dropna()
    labels = [
        f"{d:.1f}" if E == 0 or not len(bare) else f"{d:.1f}\n({100 * (d / bare.iloc[0] - 1):+.0f} %)"
        for E, d in zip(rows.skin_kpa, rows.max_displacement_mm)
    ]
    if len(rows) <= MOST:
        right.bar_label(bars, labels, padding=2, fontsize=SMALLEST)
    right.margins(y=0.18)
    right.set_xlim(-0.6, len(rows) - 0.4)
    right.set(
        xlabel="Young's modulus of the skin", ylabel="largest displacement (mm)", title="prone to upright"
    )
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
    add_legend(figure, some(labelled(axes[0]), "shapes"), ncols=min(len(shapes), 4))
    return figure


@styled
def morph(
    shapes: Mapping[str, TetMesh], distance_mm: np.ndarray, history: pd.DataFrame, *, x_mm: float, z_mm: float
) -> Figure:
    """Outlines of the shapes, the morphed one's distance to the target from the front, and its regularity.

    shapes: name -> mesh, of which one is `morphed`; distance_mm (n_node,) of the skin of that one; history:
    rows of chain.morph.MorphStep; x_mm, z_mm: the sagittal and the axial plane.
    """
    figure = new_figure(5.6)
    (axial, sagittal), (front, regular) = figure.subplots(2, 2, width_ratios=(1.15, 1))
    draw_outlines(sagittal, shapes, "sagittal", x_mm)
    draw_outlines(axial, shapes, "axial", z_mm)
    sagittal.set_title(f"sagittal, x = {x_mm:.0f} mm")
    axial.set_title(f"axial, z = {z_mm:.0f} mm")
    _draw_distance(figure, front, shapes["morphed"], distance_mm)
    _draw_regularity(regular, history)
    figure.legend(*sagittal.get_legend_handles_labels(), loc="outside lower center", ncols=len(shapes))
    return figure


def _draw_distance(figure: Figure, ax: Axes, body: TetMesh, distance_mm: np.ndarray) -> None:
    """The distance as colour on the skin, seen from the front."""
    scale = Normalize(0, float(np.nanpercentile(distance_mm, 99)) or 1.0)
    faces = body.boundaries["skin"]
    rgb = colormaps[SEQUENTIAL](scale(distance_mm[faces].mean(axis=1)))[:, :3]
    render((coloured_skin(body, rgb),), Camera.at(0, 0)).show(ax)
    bar = figure.colorbar(ScalarMappable(scale, SEQUENTIAL), ax=ax, shrink=0.9, extend="max")
    bar.set_label("distance (mm)")
    bar.outline.set_visible(False)
    scale_bar(ax, room_mm=BAR_ROOM_MM)
    ax.set_title("remaining distance")


def _draw_regularity(ax: Axes, history: pd.DataFrame) -> None:
    """Distance and strain energy against the stiffness of the attraction, level by level."""
    levels = history[history.level > 0]
    s = levels.stiffness_kpa_per_mm
    ax.loglog(s, levels.mean_mm, "o-", color=BLUE, label="mean distance")
    ax.loglog(s, levels.p95_mm, "o:", color=BLUE, fillstyle="none", label="95 % of the distances")
    plain_log(ax.xaxis)
    plain_log(ax.yaxis)
    ax.axhline(history.mean_mm.iloc[0], color=QUIET, ls="--", lw=1, label="mean before the morph")
    energy = ax.twinx()
    energy.plot(s, levels.energy_uj / 1000, "s-", color=VERMILION, label="strain energy")
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
        bbox_to_anchor=(0.5, -0.24),
        ncols=1,
    )
