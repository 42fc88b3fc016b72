"""Meshes as solids to render: skin, tissues on a cut, points, plates; and outlines of the skin in a plane."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from mammosim.core.fiducials import Fiducials
from mammosim.core.labels import Label
from mammosim.core.mesh import FACES, SUBTRIANGLES, TetMesh
from mammosim.figures.render import Camera, Solid, render
from mammosim.figures.series import colours
from mammosim.figures.slices import AXIS_LABELS, PLANES
from mammosim.figures.style import (
    INK,
    ORANGE,
    TISSUE_COLOURS,
    new_figure,
    picture_axes,
    scale_bar,
    styled,
)

SKIN_COLOUR = "#e3b79c"


def boundary_triangles(faces: np.ndarray) -> np.ndarray:
    """Four linear triangles (4 n, 3) for each quadratic one, faces (n, 6)."""
    return faces[:, SUBTRIANGLES].reshape(-1, 3)


def skin_solid(mesh: TetMesh, *, colour: str = SKIN_COLOUR, opacity: float = 1.0) -> Solid:
    """The skin as a smooth surface."""
    return Solid.of(mesh.points, boundary_triangles(mesh.boundaries["skin"]), colour, opacity=opacity)


def coloured_skin(mesh: TetMesh, rgb: np.ndarray) -> Solid:
    """The skin with a colour (n_face, 3) for each of its faces."""
    return Solid(mesh.points, boundary_triangles(mesh.boundaries["skin"]), np.repeat(rgb, 4, axis=0))


def cut_solid(mesh: TetMesh, kept: np.ndarray, rgb: np.ndarray | None = None) -> Solid:
    """The outside of the elements kept (n_cell,) bool, flat, coloured by tissue or by rgb (n_cell, 3)."""
    cells = np.flatnonzero(kept)
    faces = mesh.cells[cells][:, np.array(FACES)].reshape(-1, 6)
    _, index, count = np.unique(np.sort(faces[:, :3], axis=1), axis=0, return_index=True, return_counts=True)
    outer = index[count == 1]
    colours = tissue_rgb(mesh.tissue) if rgb is None else rgb
    return Solid(mesh.points, faces[outer, :3], colours[np.repeat(cells, 4)[outer]], smooth=False)


def tissue_rgb(tissue: np.ndarray) -> np.ndarray:
    """Colours (n, 3) of tissues (n,)."""
    return np.array([to_rgb(TISSUE_COLOURS[label]) for label in Label])[tissue]


def left_breast(fiducials: Fiducials, mesh: TetMesh) -> np.ndarray:
    """Where a body is cut (3,) mm: at the left nipple, or amid its left half when nobody marked one."""
    if "nipple_left" in fiducials.names:
        return fiducials.point("nipple_left")
    points = mesh.points
    middle: np.ndarray = points[points[:, 0] >= (points[:, 0].min() + points[:, 0].max()) / 2].mean(axis=0)
    return middle


def balls_solid(points: np.ndarray, colour: str, *, radius_mm: float = 3.5) -> Solid:
    """A small ball at each of points (n, 3) mm."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, 13), np.linspace(0, 2 * np.pi, 25)[:-1], indexing="ij")
    ball = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(12), np.arange(24), indexing="ij"))
    a, b, c, d = i * 24 + j, (i + 1) * 24 + j, (i + 1) * 24 + (j + 1) % 24, i * 24 + (j + 1) % 24
    triangles = np.vstack([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    surfaces = points[:, None] + radius_mm * ball.reshape(-1, 3)
    numbers = triangles + np.arange(len(points))[:, None, None] * len(surfaces[0])
    return Solid.of(surfaces.reshape(-1, 3), numbers.reshape(-1, 3), colour)


def box_solid(centre: np.ndarray, axes: np.ndarray, half_sizes: np.ndarray, *, opacity: float = 0.3) -> Solid:
    """A plate: box with axes (3, 3) in columns."""
    signs = np.array([[(k & 1) * 2 - 1, (k >> 1 & 1) * 2 - 1, (k >> 2) * 2 - 1] for k in range(8)])
    quads = ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6))
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    points = centre + (signs * half_sizes) @ axes.T
    return Solid.of(points, triangles, "#8fb4d6", smooth=False, opacity=opacity)


@styled
def mesh_with_tissues(mesh: TetMesh, *, cut_x_mm: float, nipples: np.ndarray | None = None) -> Figure:
    """The skin of a mesh, and its elements on the right of a sagittal cut, in the colours of their tissues.

    cut_x_mm: elements whose middle lies at a larger x are taken away; nipples (n, 3) mm are marked.
    """
    figure = new_figure(3.1)
    axes = figure.subplots(1, 2)
    balls = () if nipples is None else (balls_solid(nipples, ORANGE),)
    draw_solids(axes[0], (skin_solid(mesh), *balls), Camera.at(28, 16))
    axes[0].set_title("skin")
    kept = mesh.points[mesh.cells[:, :4]].mean(axis=1)[:, 0] <= cut_x_mm
    draw_solids(axes[1], (cut_solid(mesh, kept),), Camera.at(52, 20))
    axes[1].set_title(f"tissues, cut at x = {cut_x_mm:.0f} mm")
    present = [Label(v) for v in np.unique(mesh.tissue)]
    handles = [
        Line2D([], [], marker="s", ls="", ms=8, color=TISSUE_COLOURS[label], label=label.tissue)
        for label in present
    ]
    caption = f"{len(mesh.cells):,} quadratic tetrahedra, {len(mesh.points):,} nodes"
    figure.legend(handles=handles, loc="outside lower center", ncols=5, title=caption, title_fontsize=8)
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


def draw_outlines(ax: Axes, shapes: Mapping[str, TetMesh], plane: str, at_mm: float) -> None:
    """The skin of each shape in one plane, the first ones broader, so that all show where they coincide."""
    cut, across, along = PLANES[plane]
    colour = colours(name for name in shapes if name != "truth") | {"truth": INK}
    for number, (name, mesh) in enumerate(shapes.items()):
        segments = outline(mesh.points, boundary_triangles(mesh.boundaries["skin"]), 2 - cut, at_mm)
        lines = LineCollection(
            segments[:, :, [across, along]].tolist(),
            colors=colour[name],
            linestyles="--" if name == "truth" else "-",
            linewidths=max(3.6 - 0.8 * number, 1.0),
            label=name,
            capstyle="round",
        )
        ax.add_collection(lines)
    picture_axes(ax)
    ax.autoscale_view()
    ax.set(xlabel=AXIS_LABELS[across], ylabel=AXIS_LABELS[along])
    if plane == "axial":
        ax.yaxis.set_inverted(True)
