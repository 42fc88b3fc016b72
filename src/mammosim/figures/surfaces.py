"""Pictures of meshes: the skin, tissues on a cut, and outlines of the skin in a plane."""

from collections.abc import Iterable, Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, MultipleLocator

from mammosim.core.fiducials import Fiducials
from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.figures.bodies import balls_solid, boundary_triangles, cut_solids, skin_solid, tissue_rgb
from mammosim.figures.render import Camera, Solid, render
from mammosim.figures.series import MOST, colours
from mammosim.figures.slices import AXIS_LABELS, PLANES
from mammosim.figures.style import (
    INK,
    ORANGE,
    QUIET,
    SMALLEST,
    TISSUE_COLOURS,
    new_figure,
    picture_axes,
    scale_bar,
    styled,
)


def left_breast(fiducials: Fiducials, mesh: TetMesh) -> np.ndarray:
    """Where a body is cut (3,) mm: at the left nipple, or amid its left half when nobody marked one."""
    if "nipple_left" in fiducials.names:
        return fiducials.point("nipple_left")
    points = mesh.points
    middle: np.ndarray = points[points[:, 0] >= (points[:, 0].min() + points[:, 0].max()) / 2].mean(axis=0)
    return middle


TICKS_MM = 50.0  # of outlines
SCRAP_MM = 30.0  # of an outline: what reaches less far is no part of it


@styled
def mesh_with_tissues(mesh: TetMesh, *, cut_x_mm: float, nipples: np.ndarray | None = None) -> Figure:
    """The skin of a mesh, and its elements where a sagittal plane cuts them, in the colours of their tissues.

    cut_x_mm: what lies at a larger x is cut away; nipples (n, 3) mm are marked.
    """
    figure = new_figure(2.9)
    axes = figure.subplots(1, 2)
    balls = () if nipples is None else (balls_solid(nipples, ORANGE),)
    draw_solids(axes[0], (skin_solid(mesh), *balls), Camera.at(28, 16))
    axes[0].set_title("skin")
    draw_solids(axes[1], cut_solids(mesh, cut_x_mm, tissue_rgb(mesh.tissue), edges=True), Camera.at(52, 20))
    axes[1].set_title(f"tissues, cut at x = {cut_x_mm:.0f} mm")
    present = [Label(v) for v in np.unique(mesh.tissue)]
    handles = [
        Line2D([], [], marker="s", ls="", ms=8, color=TISSUE_COLOURS[label], label=label.tissue)
        for label in present
    ]
    caption = f"{len(mesh.cells):,} quadratic tetrahedra, {len(mesh.points):,} nodes"
    figure.legend(
        handles=handles, loc="outside lower center", ncols=5, title=caption, title_fontsize=SMALLEST
    )
    return figure


def draw_solids(ax: Axes, solids: tuple[Solid, ...], camera: Camera, *, bar_mm: float = 50.0) -> None:
    """A rendered picture with a scale bar."""
    render(solids, camera).show(ax)
    scale_bar(ax, bar_mm)


def outline(points: np.ndarray, triangles: np.ndarray, axis: int, at_mm: float) -> np.ndarray:
    """Segments (n, 2, 3) where triangles (m, 3) cross the plane x[axis] = at_mm."""
    height = points[triangles][:, :, axis] - at_mm
    crossed = triangles[(height.min(axis=1) < 0) & (height.max(axis=1) >= 0)]
    p = points[crossed]
    h = p[:, :, axis] - at_mm
    q, k = np.roll(p, -1, axis=1), np.roll(h, -1, axis=1)
    cuts = (h < 0) != (k < 0)
    t = np.where(cuts, h / np.where(cuts, h - k, 1), 0)
    ends = p + t[..., None] * (q - p)
    return ends[cuts].reshape(-1, 2, 3)


def pieces(segments: np.ndarray, *, shortest_mm: float = SCRAP_MM) -> list[np.ndarray]:
    """Segments (n, 2, 3) joined to lines, each (k, 3), but for those that reach less far than shortest_mm.

    A plane that grazes a fold or the rim of the skin cuts scraps from it, which are no outline.
    """
    places, number = np.unique(np.round(segments.reshape(-1, 3), 6), axis=0, return_inverse=True)
    links: list[list[int]] = [[] for _ in places]
    ends = number.reshape(-1, 2)
    for k, (a, b) in enumerate(ends):
        links[a].append(k)
        links[b].append(k)
    used, lines = np.zeros(len(ends), bool), []
    # Free ends first: what then is left is closed.
    for start in sorted(range(len(places)), key=lambda place: len(links[place]) != 1):
        path = _walk(start, links, ends, used)
        line = places[path]
        if np.linalg.norm(np.ptp(line, axis=0)) >= shortest_mm:
            lines.append(line)
    return lines


def _walk(start: int, links: list[list[int]], ends: np.ndarray, used: np.ndarray) -> list[int]:
    """Places from a start along segments that no line has used yet, which are marked."""
    path = [start]
    while True:
        k = next((k for k in links[path[-1]] if not used[k]), None)
        if k is None:
            return path
        used[k] = True
        a, b = ends[k]
        path.append(int(b if a == path[-1] else a))


def colours_of_shapes(names: Iterable[str]) -> dict[str, str]:
    """Colours of outlines: the truth in black, and of many the measured one in grey."""
    shown = list(names)
    own = {name: QUIET for name in shown if name.startswith("measured")} if len(shown) > MOST else {}
    own["truth"] = INK
    return colours(name for name in shown if name not in own) | own


def draw_outlines(ax: Axes, shapes: Mapping[str, TetMesh], plane: str, at_mm: float) -> None:
    """The skin of each shape in one plane, the first ones broader, so that all show where they coincide."""
    cut, across, along = PLANES[plane]
    colour = colours_of_shapes(shapes)
    for number, (name, mesh) in enumerate(shapes.items()):
        segments = outline(mesh.points, boundary_triangles(mesh.boundaries["skin"]), 2 - cut, at_mm)
        lines = LineCollection(
            [piece[:, [across, along]] for piece in pieces(segments)],
            colors=colour[name],
            linestyles="--" if name == "truth" else "-",
            linewidths=max(3.6 - 0.8 * number, 1.0),
            label=name,
            capstyle="round",
        )
        ax.add_collection(lines)
    picture_axes(ax)
    ax.set_anchor("W")
    ax.autoscale_view()
    for axis in (ax.xaxis, ax.yaxis):
        apart = TICKS_MM if np.ptp(axis.get_view_interval()) >= 1.5 * TICKS_MM else None
        axis.set_major_locator(MultipleLocator(apart) if apart else MaxNLocator(2))
    ax.set(xlabel=AXIS_LABELS[across], ylabel=AXIS_LABELS[along])
    if plane == "axial":
        ax.yaxis.set_inverted(True)
