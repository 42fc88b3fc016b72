"""Slices of tomosynthesis as they are read, and how far the lesion is seen above and below its own."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from mammosim.core.volume import Image
from mammosim.figures.style import ORANGE, new_figure, series_colour, styled

TITLES = {"filtered_backprojection": "filtered backprojection", "sart": "SART"}
AWAY_MM = 12.0


@styled
def tomosynthesis(
    slices: Mapping[str, Image], profiles: pd.DataFrame, lesion: np.ndarray, *, side: str
) -> Figure:
    """The slice through the lesion by each method, one AWAY_MM higher, and the lesion's depth profile.

    slices: method -> 1/mm; profiles: height_mm, difference_per_mm, method; lesion: (3,) mm, its middle.
    """
    figure = new_figure(6.4)
    axes = figure.subplots(2, 2)
    for ax, (method, image) in zip(axes[0], slices.items()):
        _draw(ax, image, lesion, 0.0, side)
        ax.set_title(f"{TITLES[method]}, through the lesion", fontsize=8.5)
    _draw(axes[1, 0], slices["sart"], lesion, AWAY_MM, side)
    axes[1, 0].set_title(f"SART, {AWAY_MM:g} mm higher", fontsize=8.5)
    for number, (method, rows) in enumerate(profiles.groupby("method", sort=False)):
        peak = rows.difference_per_mm[rows.height_mm == 0].iloc[0]
        axes[1, 1].plot(
            rows.height_mm,
            rows.difference_per_mm / peak,
            color=series_colour(number),
            label=TITLES[str(method)],
        )
    axes[1, 1].axhline(0, color="0.7", lw=0.8)
    axes[1, 1].set(xlabel="above the lesion (mm)", ylabel="contrast, of that in its own slice")
    axes[1, 1].legend()
    return figure


def _draw(ax: Axes, image: Image, lesion: np.ndarray, above_mm: float, side: str) -> None:
    """One slice, chest wall at the side of the breast, as a mammogram is hung."""
    grid = image.grid
    k, j, i = grid.indices((lesion + np.array([0, 0, above_mm]))[None])[0]
    V = image.values[int(np.clip(np.rint(k), 0, grid.shape[0] - 1))]
    low, high = np.percentile(V[V != 0], (5, 99.5)) if np.any(V != 0) else (0.0, 1.0)
    # Rows of the slice run to posterior, columns to the left: the chest wall to the left, lateral above.
    shown, x, y = V.T[::-1, ::-1], grid.shape[1] - 1 - j, grid.shape[2] - 1 - i
    if side == "right":
        shown, x, y = shown[::-1, ::-1], shown.shape[1] - 1 - x, shown.shape[0] - 1 - y
    step = grid.spacing[0]
    extent = (0, shown.shape[1] * step, shown.shape[0] * step, 0)
    ax.imshow(shown, cmap="gray", vmin=low, vmax=high, extent=extent, interpolation="antialiased")
    if above_mm == 0:
        ax.add_patch(
            Circle(
                ((x + 0.5) * step, (y + 0.5) * step), 9.0, fill=False, color=ORANGE, lw=1.1, ls=(0, (4, 3))
            )
        )
    ax.grid(False)
    ax.set(xlabel="from the chest wall (mm)", ylabel="across (mm)")
