"""Pressure of the plates on the skin, by strategy, and how it differs from that of one of them."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from mammosim.core.mesh import TetMesh
from mammosim.figures.bodies import coloured_skin
from mammosim.figures.render import Camera
from mammosim.figures.strategies import ABOVE, UNTOUCHED, show_near
from mammosim.figures.style import new_figure, styled

CAMERAS = {"paddle_kpa": ABOVE, "support_kpa": Camera.at(0, -89.9)}
PRESSURE, DIFFERENCE = "plasma", "RdBu_r"


@dataclass(frozen=True)
class Pressures:
    """A pressed mesh, and the mean pressure of paddle and support on each face of its skin (n_face,), kPa."""

    mesh: TetMesh
    paddle_kpa: np.ndarray
    support_kpa: np.ndarray


@styled
def pressure(pressed: Mapping[str, Pressures], *, centre: np.ndarray, against: str = "standard") -> Figure:
    """Pressure of the paddle from above and of the support from below, then each less that of `against`.

    pressed: strategy -> one mesh in its pressed shapes, a row each; centre (3,) mm of the plates. The first
    scale is that of all pressures, the second that of all differences; grey: no contact. Where `against` is
    not among them there are no differences.
    """
    reference = pressed.get(against)
    differences = {
        (name, plate): getattr(each, plate) - getattr(reference, plate)
        for name, each in pressed.items()
        for plate in (CAMERAS if reference is not None else ())
    }
    most = max(float(getattr(each, plate).max()) for each in pressed.values() for plate in CAMERAS)
    off = max((float(np.abs(each).max()) for each in differences.values()), default=0.0)
    scale, apart = Normalize(0.0, most or 1.0), Normalize(-(off or 1.0), off or 1.0)
    figure = new_figure(0.7 + 1.5 * len(pressed))
    axes = figure.subplots(len(pressed), 2 if reference is None else 4, squeeze=False)
    for row, (name, each) in zip(axes, pressed.items()):
        for column, (plate, camera) in enumerate(CAMERAS.items()):
            words, values = plate.removesuffix("_kpa"), getattr(each, plate)
            show = partial(_show, mesh=each.mesh, camera=camera, centre=centre)
            show(row[column], colormaps[PRESSURE](scale(values)), values > 0, title=f"{name}, {words}")
            if reference is not None:
                met = (values > 0) | (getattr(reference, plate) > 0)
                rgb = colormaps[DIFFERENCE](apart(differences[name, plate]))
                show(row[column + 2], rgb, met, title=f"less {against}")
    _add_bar(figure, axes[:, :2], ScalarMappable(scale, PRESSURE), "pressure (kPa)")
    if reference is not None:
        _add_bar(figure, axes[:, 2:], ScalarMappable(apart, DIFFERENCE), "difference (kPa)")
    return figure


def _show(
    ax: Axes,
    rgba: np.ndarray,
    met: np.ndarray,
    *,
    mesh: TetMesh,
    camera: Camera,
    centre: np.ndarray,
    title: str,
) -> None:
    """The skin in colours (n_face, 4) where it is met (n_face,)."""
    rgb = np.where(met[:, None], rgba[:, :3], UNTOUCHED)
    show_near(ax, (coloured_skin(mesh, rgb),), camera, centre)
    ax.set_title(title)


def _add_bar(figure: Figure, axes: np.ndarray, shown: ScalarMappable, label: str) -> None:
    bar = figure.colorbar(shown, ax=list(axes.ravel()), location="top", aspect=22, shrink=0.85, label=label)
    bar.outline.set_visible(False)
