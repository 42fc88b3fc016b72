"""A predicted position over the measured one, and how far their skins lie apart."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from mammosim.core.mesh import TetMesh
from mammosim.figures.bodies import coloured_skin
from mammosim.figures.render import Camera, render
from mammosim.figures.series import add_legend, colours, labelled, panels, some
from mammosim.figures.style import BAR_ROOM_MM, SEQUENTIAL, SERIES, new_figure, scale_bar, styled
from mammosim.figures.surfaces import draw_outlines

NOT_COMPARED = (0.84, 0.85, 0.87)
FRONT = Camera.at(0, 12)
# Quantities of validation.csv that are compared between models.
QUANTITIES = {
    "nipple_left": "nipple, left",
    "nipple_right": "nipple, right",
    "marker_mean": "markers, mean",
    "skin_mean": "skin, mean",
    "skin_p95": "skin, 95 %",
}


@dataclass(frozen=True)
class SkinMap:
    """A measured skin and, at its nodes, the distance (n,) mm to the predicted one, NaN where none."""

    mesh: TetMesh
    distance: np.ndarray

    def on_faces(self) -> np.ndarray:
        """Mean distance (n_face,) mm of the nodes of each face that have one, NaN where none has."""
        at_node = np.full(len(self.mesh.points), np.nan)
        at_node[self.mesh.boundary_nodes("skin")] = self.distance
        values = at_node[self.mesh.boundaries["skin"]]
        known = np.isfinite(values)
        count = known.sum(axis=1)
        return np.where(count > 0, np.where(known, values, 0).sum(axis=1) / np.maximum(count, 1), np.nan)


@styled
def prediction(
    shapes: Mapping[str, TetMesh],
    skin: SkinMap,
    distances: Mapping[str, np.ndarray],
    *,
    x_mm: float,
    z_mm: float,
) -> Figure:
    """Outlines of a predicted and a measured position in two planes, a map of the distance, its distribution.

    shapes: name -> mesh, e.g. measured and predicted; distances: position -> (n,) mm between the two skins.
    """
    figure = new_figure(5.2)
    axes = figure.subplots(2, 2, width_ratios=(1.3, 1))
    draw_outlines(axes[0, 0], shapes, "axial", z_mm)
    draw_outlines(axes[0, 1], shapes, "sagittal", x_mm)
    axes[0, 0].set_title(f"axial, z = {z_mm:.0f} mm")
    axes[0, 1].set_title(f"sagittal, x = {x_mm:.0f} mm")
    add_legend(figure, labelled(axes[0, 0]))
    _draw_map(axes[1, 0], skin)
    _draw_shares(axes[1, 1], distances)
    return figure


def _draw_map(ax: Axes, skin: SkinMap) -> None:
    """The measured skin from the front, coloured by its distance to the predicted one."""
    d = skin.on_faces()
    known = np.isfinite(d)
    scale = Normalize(0, float(np.percentile(d[known], 99)) if known.any() else 1.0)
    rgb = np.where(known[:, None], colormaps[SEQUENTIAL](scale(d))[:, :3], NOT_COMPARED)
    render((coloured_skin(skin.mesh, rgb),), FRONT).show(ax)
    scale_bar(ax, room_mm=BAR_ROOM_MM)
    ax.set_title("distance of the measured skin")
    figure = ax.get_figure()
    if figure is not None:
        bar = figure.colorbar(
            ScalarMappable(scale, SEQUENTIAL), ax=ax, shrink=0.9, label="distance (mm)", extend="max"
        )
        bar.outline.set_visible(False)


def _draw_shares(ax: Axes, distances: Mapping[str, np.ndarray]) -> None:
    """How much of the skin lies nearer than a distance."""
    colour = colours(distances)
    for name, d in distances.items():
        share = 100 * np.arange(1, len(d) + 1) / max(len(d), 1)
        ax.plot(np.sort(d), share, color=colour[name], label=name)
    ax.set(xlabel="distance of the skins (mm)", ylabel="skin nearer than that (%)", ylim=(0, 101))
    ax.set_xlim(left=0)
    ax.set_title("all positions")
    if distances:
        ax.legend(handles=some(labelled(ax), "positions"), loc="lower right")


@styled
def wrong_model(table: pd.DataFrame) -> Figure:
    """Errors of every position with the right and with the wrong model, a panel for each.

    table: rows of study.identification.validation.costs.
    """
    positions = list(dict.fromkeys(table.position))
    figure, axes = panels(len(positions), 2.9, sharey=True)
    for ax, position in zip(axes, positions):
        rows = table[table.position == position].groupby("quantity").mean(numeric_only=True)
        rows = rows.reindex(QUANTITIES)
        place = np.arange(len(rows))
        for number, (column, name) in enumerate((("right_mm", "right model"), ("wrong_mm", "wrong model"))):
            ax.barh(place + 0.38 * (number - 0.5), rows[column], 0.36, color=SERIES[number], label=name)
        fitted = bool(table.fitted[table.position == position].iloc[0])
        ax.set_title(f"{position.replace('_', ' ')}, {'fitted' if fitted else 'held out'}")
        ax.set_yticks(place, QUANTITIES.values())
        ax.set_xlabel("error (mm)")
        ax.grid(False, axis="y")
    axes[0].invert_yaxis()
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure
