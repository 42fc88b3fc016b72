"""Outlines: where the skin of a mesh crosses a plane."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from mammosim.core.mesh import TetMesh
from mammosim.figures.slices import AXIS_LABELS, PLANES
from mammosim.figures.style import SERIES, picture_axes
from mammosim.figures.surfaces import boundary_triangles


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
    for number, (name, mesh) in enumerate(shapes.items()):
        segments = outline(mesh.points, boundary_triangles(mesh.boundaries["skin"]), 2 - cut, at_mm)
        lines = LineCollection(
            segments[:, :, [across, along]].tolist(),
            colors=SERIES[number % len(SERIES)],
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
