"""Strategies of compression side by side: load paths, thickness, and what they do to the tissue."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from mammosim.core.errors import MissingResult
from mammosim.core.mesh import TetMesh
from mammosim.figures.bodies import coloured_skin, cut_solids
from mammosim.figures.render import Camera, Solid, render
from mammosim.figures.series import (
    COLUMNS,
    MOST,
    add_legend,
    blocks,
    colours,
    line_handles,
    lines,
    panels,
    some,
)
from mammosim.figures.style import (
    BAR_ROOM_MM,
    INK,
    QUIET,
    SEQUENTIAL,
    SMALLEST,
    new_figure,
    picture_axes,
    scale_bar,
    styled,
)
from mammosim.figures.ticks import plain_log
from mammosim.io.tabulated import tabulated

QUANTITIES = (("force_n", 1.0, "force (N)"), ("contact_area_mm2", 1e-2, "contact area (cm²)"),
              ("mean_pressure_kpa", 1.0, "mean pressure (kPa)"),
              ("peak_pressure_kpa", 1.0, "peak pressure (kPa)"))  # fmt: skip
CUT, ABOVE = Camera.at(62, 14), Camera.at(0, 89.9)
UNTOUCHED = (0.88, 0.86, 0.84)
FRAME_MM = 75.0  # around the middle of the plates
COLUMNS_OF_PIXELS = 480  # of a third of the page


@dataclass(frozen=True)
class Marks:
    """What is usual in practice: lowest and highest force_n, and mean pressure_kpa, each with its source."""

    force_n: tuple[float, float]
    force_source: str
    pressure_kpa: float
    pressure_source: str


def require_pressed(table: pd.DataFrame) -> None:
    """Raise MissingResult where a table has no row."""
    if table.empty:
        raise MissingResult("no strategy pressed any breast; the table of compressions says why")


def practice() -> Marks:
    """Force and the standardised pressure in practice, as published."""
    table = tabulated("published_mammography").set_index(["source", "quantity"])
    force = table.loc["de Groot 2015", "force"]
    return Marks(
        force_n=(force.low, force.high),
        force_source="practice",
        pressure_kpa=table.loc["de Groot 2015", "standardised pressure"]["mean"],
        pressure_source="10 kPa, de Groot",
    )


@styled
def curves(paths: pd.DataFrame, marks: Marks | None = None) -> Figure:
    """Force, contact area, mean and peak pressure along every load path; four panels per set of moduli.

    paths: rows of mechanics.compression.Compression.path with volunteer, side, strategy, moduli. A dot is
    where a strategy stops. A colour per strategy, a line style per breast. Of more than MOST sets of moduli
    each has a colour, and strategies of a breast a line style. marks: by default those of practice().
    Raises MissingResult where nothing was pressed.
    """
    require_pressed(paths)
    breast = paths.volunteer + " " + paths.side
    if paths.moduli.nunique() <= MOST:
        rows, coloured, lined = paths.moduli + " moduli", ("strategy", "strategies"), breast
        what = "breasts"
    else:
        rows = pd.Series(f"{paths.moduli.nunique()} sets of moduli", paths.index)
        coloured, lined = ("moduli", "sets of moduli"), paths.strategy + ", " + breast
        what = "strategies of a breast"
    names = list(dict.fromkeys(rows))
    figure, axes = blocks(len(names), len(QUANTITIES), 1.9, extra=0.9, sharex=True)
    for row in axes[1:]:
        for ax, first in zip(row, axes[0]):
            ax.sharey(first)
    colour, line = colours(paths[coloured[0]]), lines(lined)
    for (row, name, way), path in paths.groupby([rows, paths[coloured[0]], lined], sort=False):
        _draw_path(axes[names.index(row)], path, colour[name], line[way])
    for row, name in zip(axes, names):
        for ax in row:
            ax.set_title(name)
    _draw_marks(axes, marks or practice())
    _label_curves(axes)
    handles = [Line2D([], [], marker="o", ms=4, color=each, label=name) for name, each in colour.items()]
    add_legend(figure, [*some(handles, coloured[1]), *line_handles(lined, what)])
    return figure


def _label_curves(axes: np.ndarray) -> None:
    """What the axes are, by column; plates come together to the right."""
    for column, (_, _, label) in zip(axes.T, QUANTITIES):
        for panel in column:
            panel.set_ylabel(label)
            if "area" not in label:
                panel.set_yscale("log")
                plain_log(panel.yaxis)
    for ax in axes[-1, -COLUMNS:]:
        ax.set_xlabel("plates apart (mm)")
    axes[0, 0].xaxis.set_inverted(True)


def _draw_path(row: np.ndarray, path: pd.DataFrame, colour: str, line: Mapping[str, Any]) -> None:
    """One strategy of one breast in the panels of a row."""
    path = path[path.force_n > 0]
    for ax, (column, factor, _) in zip(row, QUANTITIES):
        ax.plot(path.thickness_mm, factor * path[column], color=colour, **line)
        ax.plot(path.thickness_mm.iloc[-1:], factor * path[column].iloc[-1:], "o", ms=4, color=colour)


def _draw_marks(axes: np.ndarray, marks: Marks) -> None:
    """Practice, in grey: a band of force, a line of mean pressure."""
    for number, row in enumerate(axes):
        row[0].axhspan(*marks.force_n, color=QUIET, alpha=0.25, lw=0)
        row[2].axhline(marks.pressure_kpa, color=QUIET, lw=1.2)
        if number == 0:
            for ax, place, text in (
                (row[0], np.sqrt(np.prod(marks.force_n)), marks.force_source),
                (row[2], marks.pressure_kpa, marks.pressure_source),
            ):
                ax.annotate(
                    text, (0.03, place), xycoords=ax.get_yaxis_transform(), fontsize=SMALLEST, va="bottom"
                )


@styled
def thickness_maps(maps: Mapping[str, pd.DataFrame]) -> Figure:
    """How thick the pressed breast is, seen from above, a panel per strategy on a common scale.

    maps: strategy -> rows of chain.plates.thickness_map, none where it failed. Lines are 5 mm
    apart; the scale ends a quarter above the thickest median.
    """
    figure, axes = panels(len(maps), 1.6, extra=0.5, sharex=True, sharey=True)
    medians = [rows.thickness_mm.median() for rows in maps.values() if len(rows)]
    scale = Normalize(0.6 * min(medians), 1.25 * max(medians))
    for ax, (name, rows) in zip(axes, maps.items()):
        if rows.empty:
            _say_failed(ax, name)
        else:
            _draw_map(ax, rows, scale)
            ax.set_title(f"{name}, median {rows.thickness_mm.median():.1f} mm")
    figure.supxlabel("across (mm)", fontsize=9)
    figure.supylabel("from the chest edge (mm)", fontsize=9)
    shown = ScalarMappable(scale, SEQUENTIAL)
    figure.colorbar(shown, ax=axes, shrink=0.75, extend="both", label="thickness (mm)")
    return figure


def _draw_map(ax: Axes, rows: pd.DataFrame, scale: Normalize) -> None:
    """One map, with lines of equal thickness."""
    grid = rows.pivot(index="outward_mm", columns="across_mm", values="thickness_mm")
    place = (grid.columns.to_numpy(float), grid.index.to_numpy(float), grid.to_numpy(float))
    ends = [
        (ticks[0] - step / 2, ticks[-1] + step / 2) for ticks, step in ((t, t[1] - t[0]) for t in place[:2])
    ]
    ax.imshow(
        place[2],
        cmap=SEQUENTIAL,
        norm=scale,
        origin="lower",
        extent=(*ends[0], *ends[1]),
        interpolation="none",
    )
    levels = np.arange(0.0, scale.vmax or 0.0, 5.0)
    ax.contour(*place, levels=levels, colors="white", linewidths=0.4)
    picture_axes(ax)


def _say_failed(ax: Axes, name: str) -> None:
    ax.set_title(f"{name}, failed")
    ax.set_axis_off()


@dataclass(frozen=True)
class Strained:
    """A pressed mesh with what is measured: in each cell (n_cell,), and on each face (n_face,)."""

    mesh: TetMesh
    logarithmic: np.ndarray
    energy_kpa: np.ndarray
    pressure_kpa: np.ndarray


@styled
def discomfort(pressed: Mapping[str, Strained], *, centre: np.ndarray) -> Figure:
    """Strain and energy on a cut, pressure on the skin from above: a row per strategy, a scale per column.

    centre (3,) mm of the plates: what lies at a larger x is cut away, and what is far from it is not shown.
    Scales end where 1 % of the cells go beyond.
    """
    scales = _discomfort_scales(pressed)
    figure = new_figure(0.7 + 1.5 * len(pressed))
    axes = figure.subplots(len(pressed), len(scales), squeeze=False)
    for row, (name, each) in zip(axes, pressed.items()):
        _show_discomfort(row, each, scales, centre)
        for ax in row:
            ax.set_title(name)
    for column, (label, (_, scale, palette)) in zip(axes.T, scales.items()):
        bar = figure.colorbar(
            ScalarMappable(scale, palette), ax=column, location="top", aspect=22, shrink=0.85, label=label
        )
        bar.outline.set_visible(False)
    return figure


OF_CELLS = {"largest logarithmic strain (-)": "logarithmic", "elastic energy (kPa)": "energy_kpa"}


def _discomfort_scales(pressed: Mapping[str, Strained]) -> dict[str, tuple[str, Normalize, str]]:
    """Of each row, by its label: the field, its scale, and its colours."""
    most = max(float(each.pressure_kpa.max()) for each in pressed.values()) or 1.0
    return {
        label: (field, _scale([getattr(each, field) for each in pressed.values()]), SEQUENTIAL)
        for label, field in OF_CELLS.items()
    } | {"pressure (kPa)": ("pressure_kpa", Normalize(0, most), "plasma")}


def _show_discomfort(
    row: np.ndarray, pressed: Strained, scales: Mapping[str, tuple[str, Normalize, str]], centre: np.ndarray
) -> None:
    """One strategy: strain and energy on a cut, pressure from above."""
    for ax, (field, scale, palette) in zip(row, scales.values()):
        values = getattr(pressed, field)
        rgb = colormaps[palette](scale(values))[:, :3]
        if field in OF_CELLS.values():
            show_near(ax, cut_solids(pressed.mesh, float(centre[0]), rgb), CUT, centre)
        else:
            rgb[values <= 0] = UNTOUCHED
            show_near(ax, (coloured_skin(pressed.mesh, rgb),), ABOVE, centre)


def _scale(values: list[np.ndarray]) -> Normalize:
    return Normalize(0, max(float(np.percentile(each, 99)) for each in values) or 1.0)


def show_near(ax: Axes, solids: tuple[Solid, ...], camera: Camera, centre: np.ndarray) -> None:
    """What is near the plates, with the scale bar on white below it."""
    right, up, _ = camera.project(centre[None])[0]
    extent = (right - FRAME_MM, right + FRAME_MM, up - 0.8 * FRAME_MM, up + 0.8 * FRAME_MM)
    render(solids, camera, columns=COLUMNS_OF_PIXELS, extent=extent).show(ax)
    scale_bar(ax, room_mm=BAR_ROOM_MM)


@styled
def amounts(table: pd.DataFrame) -> Figure:
    """How much tissue and skin lies above the marks of each measure: a bar per strategy, a panel per breast.

    table: rows of chain.discomfort.amounts_above with volunteer, side, strategy, moduli. The higher of a
    measure's marks is darker. A colour per set of moduli. More than MOST breasts are shown as one: the
    median, and a line from the least to the most. Raises MissingResult where nothing was pressed.
    """
    require_pressed(table)
    shown = table[table.tissue.isin(["all", "skin"])]
    shown = shown.assign(breast=shown.volunteer + " " + shown.side)
    number = shown.breast.nunique()
    if number > MOST:
        shown = shown.assign(breast=f"median of {number} breasts; lines: least to most")
    measures, breasts = list(dict.fromkeys(shown.measure)), list(dict.fromkeys(shown.breast))
    figure, axes = blocks(len(breasts), len(measures), 1.8, extra=1.0, sharex=True)
    for row in axes[1:]:
        for ax, first in zip(row, axes[0]):
            ax.sharey(first)
    colour = colours(shown.moduli)
    for row, breast in zip(axes, breasts):
        for ax, measure in zip(row, measures):
            rows = shown[(shown.breast == breast) & (shown.measure == measure)]
            _draw_bars(ax, rows, colour)
            marks = " and ".join(f"{mark:g}" for mark in sorted(rows.threshold.unique()))
            of = "skin" if measure == "pressure_kpa" else "tissue"
            ax.set_ylabel(
                f"{of}, {MEASURES[measure].format(marks)} ({UNITS[rows.unit.iloc[0]]})", fontsize=SMALLEST
            )
            ax.set_title(breast)
    add_legend(
        figure, some([Patch(color=c, label=f"{name} moduli") for name, c in colour.items()], "sets of moduli")
    )
    return figure


MEASURES = {
    "logarithmic": "logarithmic\nstrain from {}",
    "green_lagrange": "Green-Lagrange\nstrain from {}",
    "energy_kpa": "elastic energy\nfrom {} kPa",
    "pressure_kpa": "pressure\nfrom {} kPa",
}
UNITS = {"cm3": "cm³", "cm2": "cm²"}


def _draw_bars(ax: Axes, rows: pd.DataFrame, colour: Mapping[str, str]) -> None:
    strategies, moduli = list(dict.fromkeys(rows.strategy)), list(dict.fromkeys(rows.moduli))
    marks, width = sorted(rows.threshold.unique()), 0.8 / len(moduli)
    for number, name in enumerate(moduli):
        for depth, mark in enumerate(marks):
            these = (
                rows[(rows.moduli == name) & (rows.threshold == mark)].groupby("strategy", sort=False).amount
            )
            middle, low, high = these.median(), these.min(), these.max()
            places = [strategies.index(s) + (number - (len(moduli) - 1) / 2) * width for s in middle.index]
            dark = (1 + depth) / len(marks)
            ax.bar(places, middle, 0.9 * width, color=colour[name], alpha=dark)
            if (these.size() > 1).any():
                ax.vlines(places, low, high, color=INK, lw=0.7)
    ax.set_xticks(range(len(strategies)), strategies, rotation=30, ha="right")
    ax.grid(False, axis="x")
