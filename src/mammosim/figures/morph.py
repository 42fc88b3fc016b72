"""A mesh brought onto the shape of another: outlines, the distance left, and what nearness costs."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from mammosim.core.mesh import TetMesh
from mammosim.figures.outlines import draw_outlines
from mammosim.figures.style import BLUE, QUIET, SEQUENTIAL, VERMILION, new_figure, picture_axes, styled
from mammosim.figures.surfaces import boundary_triangles


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
    ax.set(title="what is left, from the front", xlabel="x to the left (mm)", ylabel="z to superior (mm)")


def _draw_regularity(ax: Axes, history: pd.DataFrame) -> None:
    """Distance and strain energy against the stiffness of the attraction, level by level."""
    levels = history[history.level > 0]
    s = levels.stiffness_kpa_per_mm
    ax.loglog(s, levels.mean_mm, "o-", color=BLUE, label="mean distance")
    ax.loglog(s, levels.p95_mm, "o:", color=BLUE, fillstyle="none", label="95 % of the distances")
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
        title="nearness against regularity",
    )
    lines = [*ax.get_lines(), *energy.get_lines()]
    ax.legend(
        lines,
        [str(line.get_label()) for line in lines],
        loc="upper center",
        bbox_to_anchor=(0.5, -0.2),
        ncols=2,
    )
