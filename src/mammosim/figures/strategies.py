"""Strategies of compression side by side: load paths, thickness, and what they do to the tissue."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import cycle

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from mammosim.core.errors import MissingResult
from mammosim.core.mesh import TetMesh
from mammosim.figures.render import Camera, render
from mammosim.figures.style import (
    INK,
    QUIET,
    SEQUENTIAL,
    SERIES,
    new_figure,
    picture_axes,
    scale_bar,
    series_colour,
    styled,
)
from mammosim.figures.surfaces import coloured_skin, cut_solid
from mammosim.io.tabulated import tabulated

QUANTITIES = (("force_n", 1.0, "force (N)"), ("contact_area_mm2", 1e-2, "contact area (cm²)"),
              ("mean_pressure_kpa", 1.0, "mean pressure (kPa)"),
              ("peak_pressure_kpa", 1.0, "peak pressure (kPa)"))  # fmt: skip
LINES = ("-", "--", ":", "-.")
CUT, ABOVE = Camera.at(62, 14), Camera.at(0, 89.9)
UNTOUCHED = (0.88, 0.86, 0.84)
FRAME_MM = 75.0  # around the middle of the plates


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
    """Force, contact area, mean and peak pressure along every load path; a row per set of moduli.

    paths: rows of mechanics.compression.Compression.path with volunteer, side, strategy, moduli. A dot is
    where a strategy stops. A line style per breast. marks: by default those of practice().
    Raises MissingResult where nothing was pressed.
    """
    require_pressed(paths)
    moduli, strategies = list(dict.fromkeys(paths.moduli)), list(dict.fromkeys(paths.strategy))
    figure = new_figure(0.9 + 2.1 * len(moduli))
    axes = figure.subplots(len(moduli), len(QUANTITIES), squeeze=False, sharex=True, sharey="col")
    breasts = list(dict.fromkeys(paths.volunteer + " " + paths.side))
    for row, name in zip(axes, moduli):
        for (_, strategy, breast), path in _paths(paths[paths.moduli == name]):
            colour, line = (
                series_colour(strategies.index(strategy)),
                LINES[breasts.index(breast) % len(LINES)],
            )
            _draw_path(row, path, colour, line)
        row[0].set_title(f"{name} moduli")
    for column, (_, _, label) in zip(axes.T, QUANTITIES):
        for panel in column:
            panel.set_ylabel(label)
            if "area" not in label:
                _logarithmic(panel)
        column[-1].set_xlabel("plates apart (mm)")
    axes[0, 0].xaxis.set_inverted(True)
    _draw_marks(axes, marks or practice())
    for strategy, colour in zip(strategies, cycle(SERIES)):
        axes[0, 0].plot([], [], "o-", ms=4, color=colour, label=strategy)
    for breast, line in zip(breasts, cycle(LINES)):
        axes[0, 0].plot([], [], line, color=QUIET, label=breast)
    figure.legend(loc="outside lower center", ncols=4)
    return figure


def _paths(paths: pd.DataFrame):  # type: ignore[no-untyped-def]
    return paths.groupby([paths.moduli, paths.strategy, paths.volunteer + " " + paths.side], sort=False)


def _logarithmic(ax: Axes) -> None:
    """A logarithmic axis with plain numbers at 1, 2, 5, 10 ..."""
    ax.set_yscale("log")
    ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.yaxis.set_minor_formatter(NullFormatter())


def _draw_path(row: np.ndarray, path: pd.DataFrame, colour: str, line: str) -> None:
    """One strategy of one breast in the panels of a row."""
    path = path[path.force_n > 0]
    for ax, (column, factor, _) in zip(row, QUANTITIES):
        ax.plot(path.thickness_mm, factor * path[column], line, color=colour, lw=1.3)
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
                ax.annotate(text, (0.03, place), xycoords=ax.get_yaxis_transform(), fontsize=6.5, va="bottom")


@styled
def thickness_maps(maps: Mapping[str, pd.DataFrame]) -> Figure:
    """How thick the pressed breast is, seen from above, a panel per strategy on a common scale.

    maps: strategy -> rows of chain.plates.thickness_map, none where it failed. Lines are 5 mm
    apart; the scale ends a quarter above the thickest median.
    """
    figure = new_figure(2.7)
    axes = figure.subplots(1, len(maps), squeeze=False, sharex=True, sharey=True)[0]
    medians = [rows.thickness_mm.median() for rows in maps.values() if len(rows)]
    scale = Normalize(0.6 * min(medians), 1.25 * max(medians))
    for ax, (name, rows) in zip(axes, maps.items()):
        if rows.empty:
            _say_failed(ax, name)
        else:
            _draw_map(ax, rows, scale)
            ax.set_title(f"{name}\nmedian {rows.thickness_mm.median():.1f} mm", fontsize=8)
    axes[0].set_ylabel("from the chest edge (mm)")
    colours = ScalarMappable(scale, SEQUENTIAL)
    figure.colorbar(colours, ax=axes, shrink=0.75, extend="both", label="thickness (mm)")
    return figure


def _draw_map(ax: Axes, rows: pd.DataFrame, scale: Normalize) -> None:
    """One map, with lines of equal thickness."""
    grid = rows.pivot(index="outward_mm", columns="across_mm", values="thickness_mm")
    place = (grid.columns.to_numpy(float), grid.index.to_numpy(float), grid.to_numpy(float))
    ax.pcolormesh(*place, cmap=SEQUENTIAL, norm=scale, shading="nearest", rasterized=True)
    levels = np.arange(0.0, scale.vmax or 0.0, 5.0)
    ax.contour(*place, levels=levels, colors="white", linewidths=0.4)
    picture_axes(ax)
    ax.set_xlabel("across (mm)")


def _say_failed(ax: Axes, name: str) -> None:
    ax.set_title(f"{name}\nfailed", fontsize=8)
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
    """Strain and energy on a cut, pressure on the skin from above: a column per strategy, a scale per row.

    centre (3,) mm of the plates: elements at a larger x are taken away, and what is far from it is not shown.
    Scales end where 1 % of the cells go beyond.
    """
    figure = new_figure(5.4)
    axes = figure.subplots(3, len(pressed), squeeze=False)
    of_cells = (("logarithmic", "largest logarithmic strain (-)"), ("energy_kpa", "elastic energy (kPa)"))
    for row, (field, label) in zip(axes, of_cells):
        scale = _scale([getattr(each, field) for each in pressed.values()])
        for ax, each in zip(row, pressed.values()):
            kept = each.mesh.points[each.mesh.cells[:, :4]].mean(axis=1)[:, 0] <= centre[0]
            rgb = colormaps[SEQUENTIAL](scale(getattr(each, field)))[:, :3]
            _show(ax, cut_solid(each.mesh, kept, rgb), CUT, centre, ink="white")
        figure.colorbar(ScalarMappable(scale, SEQUENTIAL), ax=row, shrink=0.8, label=label)
    scale = Normalize(0, max(float(each.pressure_kpa.max()) for each in pressed.values()) or 1.0)
    for ax, each in zip(axes[2], pressed.values()):
        rgb = colormaps["plasma"](scale(each.pressure_kpa))[:, :3]
        rgb[each.pressure_kpa <= 0] = UNTOUCHED
        _show(ax, coloured_skin(each.mesh, rgb), ABOVE, centre)
    figure.colorbar(ScalarMappable(scale, "plasma"), ax=axes[2], shrink=0.8, label="pressure (kPa)")
    for ax, name in zip(axes[0], pressed):
        ax.set_title(name)
    return figure


def _scale(values: list[np.ndarray]) -> Normalize:
    return Normalize(0, max(float(np.percentile(each, 99)) for each in values) or 1.0)


def _show(ax: Axes, solid, camera: Camera, centre: np.ndarray, *, ink: str = INK) -> None:  # type: ignore[no-untyped-def]
    right, up, _ = camera.project(centre[None])[0]
    extent = (right - FRAME_MM, right + FRAME_MM, up - 0.8 * FRAME_MM, up + 0.8 * FRAME_MM)
    render((solid,), camera, columns=280, extent=extent).show(ax)
    scale_bar(ax, colour=ink)


@styled
def amounts(table: pd.DataFrame) -> Figure:
    """How much tissue and skin lies above the marks of each measure: a bar per strategy, a row per breast.

    table: rows of chain.discomfort.amounts_above with volunteer, side, strategy, moduli. The higher of a
    measure's marks is darker. A colour per set of moduli. Raises MissingResult where nothing was pressed.
    """
    require_pressed(table)
    shown = table[table.tissue.isin(["all", "skin"])]
    measures, breasts = (
        list(dict.fromkeys(shown.measure)),
        list(dict.fromkeys(shown.volunteer + " " + shown.side)),
    )
    figure = new_figure(1.1 + 1.9 * len(breasts))
    axes = figure.subplots(len(breasts), len(measures), squeeze=False, sharex=True, sharey="col")
    for row, breast in zip(axes, breasts):
        for ax, measure in zip(row, measures):
            rows = shown[(shown.volunteer + " " + shown.side == breast) & (shown.measure == measure)]
            _draw_bars(ax, rows)
            ax.set_ylabel(f"{'skin' if measure == 'pressure_kpa' else 'tissue'} ({UNITS[rows.unit.iloc[0]]})")
        row[0].set_title(breast)
    for ax, measure in zip(axes[-1], measures):
        marks = " and ".join(
            f"{mark:g}" for mark in sorted(shown[shown.measure == measure].threshold.unique())
        )
        ax.set_xlabel(f"{MEASURES[measure].format(marks)}", fontsize=8)
    names = zip(cycle(SERIES), dict.fromkeys(shown.moduli))
    handles = [Patch(color=colour, label=f"{name} moduli") for colour, name in names]
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    return figure


MEASURES = {
    "logarithmic": "logarithmic strain\nfrom {}",
    "green_lagrange": "Green-Lagrange strain\nfrom {}",
    "energy_kpa": "elastic energy\nfrom {} kPa",
    "pressure_kpa": "contact pressure\nfrom {} kPa",
}
UNITS = {"cm3": "cm³", "cm2": "cm²"}


def _draw_bars(ax: Axes, rows: pd.DataFrame) -> None:
    strategies, moduli = list(dict.fromkeys(rows.strategy)), list(dict.fromkeys(rows.moduli))
    marks, width = sorted(rows.threshold.unique()), 0.8 / len(moduli)
    for number, name in enumerate(moduli):
        for depth, mark in enumerate(marks):
            these = rows[(rows.moduli == name) & (rows.threshold == mark)].set_index("strategy").amount
            places = [strategies.index(s) + (number - (len(moduli) - 1) / 2) * width for s in these.index]
            ax.bar(places, these, 0.9 * width, color=series_colour(number), alpha=(1 + depth) / len(marks))
    ax.set_xticks(range(len(strategies)), strategies, rotation=60)
    ax.grid(False, axis="x")
