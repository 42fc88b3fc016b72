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
    window,
)
from mammosim.figures.style import BLUE, GREEN, ORANGE, SKY, new_figure, styled

MARKS = {"chest": (SKY, "s"), "breast": (GREEN, "o"), "nipple": (ORANGE, "D")}


@styled
def positions(
    images: Mapping[str, Image], fiducials: Mapping[str, Fiducials], gravity: Mapping[str, np.ndarray]
) -> Figure:
    """One volunteer: an axial and a sagittal slice through the left nipple (or the middle), with markers.

    gravity: unit vectors (3,) in the frame of each image; drawn as an arrow.
    """
    figure = new_figure(4.6)
    axes = figure.subplots(2, len(images), squeeze=False)
    for column, (position, image) in enumerate(images.items()):
        nipple = left_nipple(fiducials[position], image)
        for ax, plane, at in zip(axes[:, column], ("axial", "sagittal"), (nipple[2], nipple[0])):
            draw_slice(ax, image, plane, at)
            draw_fiducials(ax, fiducials[position], plane, at)
            draw_gravity(ax, gravity[position], plane)
            where = f"{plane}, {'z' if plane == 'axial' else 'x'} = {at:.0f} mm"
            ax.text(0.02, 0.97, where, transform=ax.transAxes, color="w", fontsize=7, va="top")
        axes[0, column].set_title(position.replace("_", " "))
        if column:
            for ax in axes[:, column]:
                ax.set_ylabel("")
    marked = {kind for each in fiducials.values() for kind in each.kinds}
    shown = {kind: mark for kind, mark in MARKS.items() if kind in marked}
    handles = [axes[0, 0].plot([], [], m, color=c, mec="k", label=kind)[0] for kind, (c, m) in shown.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def left_nipple(fiducials: Fiducials, image: Image) -> np.ndarray:
    """Where an image is cut (3,) mm: at the left nipple, or in its middle when nobody marked one."""
    if "nipple_left" in fiducials.names:
        return fiducials.point("nipple_left")
    middle: np.ndarray = image.grid.points((np.array(image.grid.shape) - 1)[None] / 2)[0]
    return middle


def draw_fiducials(ax: Axes, fiducials: Fiducials, plane: str, at_mm: float, within_mm: float = 12.0) -> None:
    """Markers within a slab are filled, all others hollow."""
    cut, across, along = PLANES[plane]
    for kind, point in zip(fiducials.kinds, fiducials.points):
        colour, marker = MARKS[kind]
        near = abs(point[2 - cut] - at_mm) < within_mm
        ax.plot(
            *point[[across, along]],
            marker,
            ms=5 if near else 3.5,
            mfc=colour if near else "none",
            mec="k" if near else colour,
            mew=0.7,
        )


@styled
def registration(fixed: Image, before: Image, after: Image, steps: pd.DataFrame, *, at_mm: float) -> Figure:
    """Checkerboards of the fixed and the moving image, unmoved and registered; what is left after each step.

    before, after: on the grid of `fixed`. steps: columns step, and one or more ending in _mm, of which those
    with numbers are drawn: residuals of markers, or the limits of the error without them; at_mm: z.
    """
    figure = new_figure(2.5)
    axes = figure.subplots(1, 3, width_ratios=(1, 1, 0.72))
    for ax, image, title in zip(axes, (before, after), ("as scanned", "registered")):
        _draw_checkerboard(ax, fixed, image, at_mm)
        ax.set_title(title)
    known = steps.dropna(axis="columns", how="all").select_dtypes("number")
    columns = [column for column in known.columns if column.endswith("_mm")]
    marked = any(column.startswith("marker") for column in columns)
    width, colour = 0.8 / max(len(columns), 1), colours(columns)
    for k, column in enumerate(columns):
        place = np.arange(len(steps)) + (k - (len(columns) - 1) / 2) * width
        axes[2].bar(place, steps[column], 0.92 * width, color=colour[column], label=_words(column))
    axes[2].set(ylabel="distance (mm)", title="residual" if marked or not columns else "no markers: limits")
    axes[2].set_xticks(range(len(steps)), [str(s).replace("_", " ") for s in steps["step"]], rotation=20)
    axes[2].grid(False, axis="x")
    axes[2].margins(y=0.4)
    axes[2].legend(fontsize=7, loc="upper right")
    axes[1].set_ylabel("")
    return figure


def _draw_checkerboard(ax: Axes, fixed: Image, moving: Image, at_mm: float, square_mm: float = 32.0) -> None:
    draw_slice(ax, fixed, "axial", at_mm)
    a, b = (slice_of(v, "axial", at_mm) / window(v)[1] for v in (fixed, moving))
    rows, columns = (np.arange(n) * s // square_mm for n, s in zip(a.shape, fixed.grid.spacing[1::-1]))
    odd = (rows[:, None] + columns) % 2 > 0
    warm, cool = np.array([1.0, 0.93, 0.8]), np.array([0.78, 0.9, 1.0])
    rgb = np.clip(np.where(odd, b, a), 0, 1)[..., None] * np.where(odd[..., None], cool, warm)
    ax.imshow(rgb, extent=extent_of(fixed.grid, "axial"), origin="lower", interpolation="nearest")
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
        ax.set_title(f"{plane}, {at:.0f} mm")
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
    ax.bar_label(bars, fmt="%.3f", padding=-30, fontsize=8, color="w")
    ax.set(xlim=(0, 1), xlabel="Dice overlap with the truth (-)", title="overlap")
    ax.invert_yaxis()
    ax.grid(False, axis="y")


def _words(column: str) -> str:
    return column.removesuffix("_mm").replace("_", " ")
