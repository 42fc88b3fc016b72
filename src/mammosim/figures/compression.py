"""A compressed breast between its plates."""

from dataclasses import dataclass

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from mammosim.core.mesh import TetMesh
from mammosim.figures.bodies import box_solid, coloured_skin, cut_solids, skin_solid
from mammosim.figures.render import Camera, Solid, render
from mammosim.figures.style import BAR_ROOM_MM, SEQUENTIAL, new_figure, scale_bar, styled

OBLIQUE, ABOVE = Camera.at(48, 20), Camera.at(0, 89.9)


@dataclass(frozen=True)
class Plate:
    """A compression plate to draw: centre (3,), axes (3, 3) in columns, half sizes (3,), mm."""

    centre: np.ndarray
    axes: np.ndarray
    half_sizes: np.ndarray

    @property
    def solid(self) -> Solid:
        """See-through."""
        return box_solid(self.centre, self.axes, self.half_sizes)


@styled
def compressed_breast(
    mesh: TetMesh,
    compressed: TetMesh,
    plates: tuple[Plate, ...],
    *,
    strain: np.ndarray,
    pressure: np.ndarray,
    cut_x_mm: float,
) -> Figure:
    """Before and after compression, the largest strain on a cut through the breast, the pressure on the skin.

    mesh: without load; strain (n_cell,): largest principal Green-Lagrange strain; pressure (n_face,) kPa on
    the faces of the skin; cut_x_mm: what lies at a larger x is cut away.
    """
    figure = new_figure(5.6)
    axes = figure.subplots(2, 2)
    draw_between_plates(axes[0, 0], (skin_solid(mesh),), ())
    axes[0, 0].set_title("without load")
    draw_between_plates(axes[0, 1], (skin_solid(compressed),), plates)
    axes[0, 1].set_title("between the plates")
    draw_strain(axes[1, 0], compressed, strain, cut_x_mm)
    draw_pressure(axes[1, 1], compressed, pressure)
    return figure


def draw_between_plates(ax: Axes, solids: tuple[Solid, ...], plates: tuple[Plate, ...]) -> None:
    """Solids with see-through plates."""
    render((*solids, *(plate.solid for plate in plates)), OBLIQUE).show(ax)
    scale_bar(ax)


def draw_strain(ax: Axes, mesh: TetMesh, strain: np.ndarray, cut_x_mm: float) -> None:
    """The largest principal strain of the elements, where a plane cuts them."""
    scale = Normalize(0, float(np.percentile(strain, 99)) or 1.0)
    rgb = colormaps[SEQUENTIAL](scale(strain))[:, :3]
    render(cut_solids(mesh, cut_x_mm, rgb), Camera.at(62, 14)).show(ax)
    scale_bar(ax)
    ax.set_title(f"strain, cut at x = {cut_x_mm:.0f} mm")
    _add_bar(ax, scale, SEQUENTIAL, "largest principal strain (-)")


def draw_pressure(ax: Axes, mesh: TetMesh, pressure: np.ndarray) -> None:
    """The contact pressure on the skin, seen from above."""
    scale = Normalize(0, float(pressure.max()) or 1.0)
    rgb = colormaps["plasma"](scale(pressure))[:, :3]
    rgb[pressure <= 0] = (0.88, 0.86, 0.84)
    render((coloured_skin(mesh, rgb),), ABOVE).show(ax)
    scale_bar(ax, room_mm=BAR_ROOM_MM)
    ax.set_title("pressure of the upper plate")
    _add_bar(ax, scale, "plasma", "contact pressure (kPa)")


def _add_bar(ax: Axes, scale: Normalize, colours: str, label: str) -> None:
    figure = ax.get_figure()
    if figure is not None:
        bar = figure.colorbar(ScalarMappable(scale, colours), ax=ax, shrink=0.75, pad=0.05, label=label)
        bar.outline.set_visible(False)
