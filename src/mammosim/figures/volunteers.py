"""The volunteers: their images in each position, their registration, their tissues."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mammosim.core.fiducials import Fiducials
from mammosim.core.volume import Image, LabelMap
from mammosim.figures.series import colours
from mammosim.figures.slices import (
    PLANES,
    draw_gravity,
    draw_labels,
    draw_slice,
    extent_of,
    frame_slice,
    slice_of,
    tissue_legend,
    voxels_or_mean,
    window,
)
from mammosim.figures.style import BLUE, GREEN, ORANGE, SKY, SMALLEST, new_figure, styled

NEAR_MM = 8.0  # from a slice: what lies farther would seem to float beside the body
RESIDUALS = {
    "marker_residual_mm": "mean",
    "marker_residual_max_mm": "largest",
    "error_95_mm": "error, 95 % below",
}
MARKS = {"chest": (SKY, "s"), "breast": (GREEN, "o"), "nipple": (ORANGE, "D")}


@styled
def positions(
    images: Mapping[str, Image], fiducials: Mapping[str, Fiducials], gravity: Mapping[str, np.ndarray]
) -> Figure:
    """One volunteer: an axial and a sagittal slice through the left nipple (or the middle), and markers.

    gravity: unit vectors (3,) in the frame of each image; drawn as an arrow.
    """
    figure = new_figure(0.6 + 1.8 * len(images))
    axes = figure.subplots(len(images), 2, squeeze=False, width_ratios=(1.25, 1))
    for k, (row, (position, image)) in enumerate(zip(axes, images.items())):
        nipple = left_nipple(fiducials[position], image)
        for ax, plane, at in zip(row, ("axial", "sagittal"), (nipple[2], nipple[0])):
            draw_slice(ax, image, plane, at)
            draw_fiducials(ax, fiducials[position], plane, at)
            draw_gravity(ax, gravity[position], plane)
            ax.set_title(f"{position.replace('_', ' ')}, {'z' if plane == 'axial' else 'x'} = {at:.0f} mm")
        if k < len(axes) - 1:
            for ax in row:
                ax.set_xlabel("")
    marked = {kind for each in fiducials.values() for kind in each.kinds}
    shown = {kind: mark for kind, mark in MARKS.items() if kind in marked}
    handles = [axes[0, 0].plot([], [], m, color=c, mec="k", label=kind)[0] for kind, (c, m) in shown.items()]
    where = f"markers within {NEAR_MM:g} mm of the slice"
    figure.legend(handles=handles, loc="outside lower center", ncols=3, title=where, title_fontsize=SMALLEST)
    return figure


def left_nipple(fiducials: Fiducials, image: Image) -> np.ndarray:
    """Where an image is cut (3,) mm: at the left nipple, or in its middle when nobody marked one."""
    if "nipple_left" in fiducials.names:
        return fiducials.point("nipple_left")
    middle: np.ndarray = image.grid.points((np.array(image.grid.shape) - 1)[None] / 2)[0]
    return middle


def draw_fiducials(ax: Axes, fiducials: Fiducials, plane: str, at_mm: float, *, far: bool = False) -> None:
    """Markers within NEAR_MM of a slice; far: all others too, small and hollow, projected onto it."""
    cut, across, along = PLANES[plane]
    for kind, point in zip(fiducials.kinds, fiducials.points):
        colour, marker = MARKS[kind]
        if abs(point[2 - cut] - at_mm) < NEAR_MM:
            ax.plot(*point[[across, along]], marker, ms=5, mfc=colour, mec="k", mew=0.7)
        elif far:
            ax.plot(*point[[across, along]], marker, ms=3.5, mfc="none", mec=colour, mew=0.7)


@styled
def registration(fixed: Image, before: Image, after: Image, steps: pd.DataFrame, *, at_mm: float) -> Figure:
    """Checkerboards of the fixed and the moving image, unmoved and registered; what each step leaves.

    before, after: on the grid of `fixed`. steps: columns step, and one or more ending in _mm, of which those
    with numbers are drawn: residuals of markers, or the limits of the error without them; and
    correlation, if any. at_mm: z.
    """
    figure = new_figure(4.6)
    axes = figure.subplots(2, 2, height_ratios=(1, 0.95))
    for ax, image, title in zip(axes[0], (before, after), ("as scanned", "registered")):
        _draw_checkerboard(ax, fixed, image, at_mm)
        ax.set_title(title)
    axes[0, 1].set_ylabel("")
    _draw_residuals(axes[1, 0], steps)
    _draw_correlation(axes[1, 1], steps)
    return figure


def _draw_residuals(ax: Axes, steps: pd.DataFrame) -> None:
    """Bars of what is left in mm after each step."""
    known = steps.dropna(axis="columns", how="all").select_dtypes("number")
    columns = [column for column in known.columns if column.endswith("_mm")]
    marked = any(column.startswith("marker") for column in columns)
    width, colour = 0.8 / max(len(columns), 1), colours(columns)
    for k, column in enumerate(columns):
        place = np.arange(len(steps)) + (k - (len(columns) - 1) / 2) * width
        label = RESIDUALS.get(column, column.removesuffix("_mm").replace("_", " "))
        ax.bar(place, steps[column], 0.92 * width, color=colour[column], label=label)
    title = "markers on the chest" if marked or not columns else "no markers: limits of the error"
    ax.set(ylabel="distance (mm)", title=title)
    _name_steps(ax, steps)
    ax.margins(y=0.45)
    ax.legend(loc="upper left", ncols=2)


def _draw_correlation(ax: Axes, steps: pd.DataFrame) -> None:
    """What the step by images maximises."""
    if "correlation" not in steps:
        ax.set_axis_off()
        return
    ax.plot(range(len(steps)), steps.correlation, "o-", color=GREEN)
    ax.set(ylabel="correlation of the images (-)", title="inside the rib cage", xlim=(-0.5, len(steps) - 0.5))
    ax.margins(y=0.2)
    _name_steps(ax, steps)


def _name_steps(ax: Axes, steps: pd.DataFrame) -> None:
    ax.set_xticks(range(len(steps)), [f"after {str(s).replace('_', ' ')}" for s in steps["step"]])
    ax.grid(False, axis="x")


def _draw_checkerboard(ax: Axes, fixed: Image, moving: Image, at_mm: float, square_mm: float = 32.0) -> None:
    draw_slice(ax, fixed, "axial", at_mm)
    a, b = (slice_of(v, "axial", at_mm) / window(v)[1] for v in (fixed, moving))
    rows, columns = (np.arange(n) * s // square_mm for n, s in zip(a.shape, fixed.grid.spacing[1::-1]))
    odd = (rows[:, None] + columns) % 2 > 0
    warm, cool = np.array([1.0, 0.93, 0.8]), np.array([0.78, 0.9, 1.0])
    rgb = np.clip(np.where(odd, b, a), 0, 1)[..., None] * np.where(odd[..., None], cool, warm)
    ax.imshow(rgb, extent=extent_of(fixed.grid, "axial"), origin="lower", interpolation=voxels_or_mean(fixed))
    frame_slice(ax, fixed.grid, "axial")


@styled
def segmentation(
    image: Image, labels: LabelMap, dice: pd.DataFrame | None = None, *, point: np.ndarray
) -> Figure:
    """Tissues over the image in three planes through a point (3,) mm, and Dice where the truth is known.

    dice: columns tissue, dice; None when there is no truth.
    """
    figure = new_figure(5.4)
    axes = figure.subplots(2, 2).ravel()
    x, y, z = point
    for ax, plane, at in zip(axes, ("axial", "coronal", "sagittal"), (z, y, x)):
        draw_slice(ax, image, plane, at)
        draw_labels(ax, labels, plane, at, opacity=0.38)
        draw_labels(ax, labels, plane, at, filled=False)
        ax.set_title(f"{plane}, {'xyz'[2 - PLANES[plane][0]]} = {at:.0f} mm")
    if dice is None:
        draw_slice(axes[3], image, "axial", z)
        axes[3].set_title("the image alone")
    else:
        _draw_dice(axes[3], dice)
    figure.legend(handles=tissue_legend(labels), loc="outside lower center", ncols=6)
    return figure


def _draw_dice(ax: Axes, dice: pd.DataFrame) -> None:
    rows = dice[dice.tissue != "air"]
    bars = ax.barh(rows.tissue, rows.dice, color=BLUE, height=0.62)
    ax.bar_label(bars, fmt="%.3f", padding=3, fontsize=SMALLEST)
    ax.set(xlim=(0, 1.25), xlabel="Dice overlap with the truth (-)", title="overlap")
    ax.set_xticks(np.linspace(0, 1, 6))
    ax.invert_yaxis()
    ax.grid(False, axis="y")
