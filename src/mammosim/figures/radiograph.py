"""X-rays: the voxels of the compressed breast, the mammogram, and slices of tomosynthesis."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from mammosim.core.labels import Label
from mammosim.core.volume import Image, LabelMap
from mammosim.figures.series import add_legend, labelled
from mammosim.figures.slices import draw_labels, tissue_legend
from mammosim.figures.style import ORANGE, SERIES, SMALLEST, WIDTH, new_figure, scale_bar, styled

# Attenuation, -ln(transmission), above which a pixel is breast: more than the beam falls towards the corners
# of the field, less than 1 cm of fat.
IN_BREAST = 0.5
HUNG_BAR_MM = 20.0
BAR_ROOM = 0.09  # of the height of a view, below it for the scale bar
TALL, FACTS = 4.6, 2.6  # inches of a mammogram's height, and of what is told of it


@styled
def phantom_slices(labels: LabelMap) -> Figure:
    """Three slices of the voxels of a compressed breast, through its lesion if it has one."""
    here = np.argwhere(labels.values == Label.LESION)
    here = here if len(here) else np.argwhere(labels.values != Label.AIR)
    x, y, z = labels.grid.points(here.mean(axis=0, keepdims=True))[0]
    nz, ny, nx = labels.grid.shape * labels.grid.spacing[::-1]
    figure = new_figure(1.1 + 5.0 * (nz + ny) / (nx + ny))
    axes = figure.subplots(2, 2, width_ratios=(nx, ny), height_ratios=(ny, nz))
    for ax, plane, at in zip(axes.ravel()[[0, 2, 3]], ("axial", "coronal", "sagittal"), (z, y, x)):
        draw_labels(ax, labels, plane, at, opacity=1.0)
        ax.set_title({"axial": "from below", "coronal": "from the front", "sagittal": "from the side"}[plane])
    axes[0, 1].set_axis_off()
    axes[0, 1].legend(handles=tissue_legend(labels), loc="center")
    return figure


@styled
def mammogram(
    image: np.ndarray,
    *,
    pixel_mm: float,
    unobstructed: float | None = None,
    lesion: np.ndarray | None = None,
    row: dict[str, float] | None = None,
    side: str = "left",
) -> Figure:
    """A mammogram as it is read: dense is bright, the chest wall at the side of the breast, nipple outwards.

    image: (nv, nu), signal per pixel, rows from the chest wall to the nipple, columns towards the patient's
    right; unobstructed: signal where nothing is in the way, by default the brightest per cent of the image;
    lesion: (nv, nu) bool; row: of chain.mammogram.
    """
    unobstructed = unobstructed or float(np.percentile(image, 99))
    shown = np.log(unobstructed / np.maximum(image, unobstructed * 1e-6))
    breast = shown > IN_BREAST
    rows, columns = np.nonzero(breast)
    r1 = min(rows.max() + 12, image.shape[0] - 1)
    c0, c1 = max(columns.min() - 12, 0), min(columns.max() + 12, image.shape[1] - 1)
    low, high = np.percentile(shown[breast], (3, 99.7))
    tall = TALL * (r1 + 1) / (c1 - c0 + 1)
    figure = new_figure(TALL + 0.4, width=tall + (FACTS if row else 0.9))
    axes = figure.subplots(1, 2 if row else 1, width_ratios=(tall, FACTS) if row else None, squeeze=False)[0]
    values = shown[: r1 + 1, c0 : c1 + 1].T
    _hang(axes[0], values, pixel_mm, side, limits=(low * 0.55, high))
    if lesion is not None and lesion.any():
        v, u = np.argwhere(lesion).mean(axis=0) + 0.5
        radius = 2.2 * np.sqrt(lesion.sum() / np.pi) * pixel_mm
        _circle(axes[0], (v * pixel_mm, (u - c0) * pixel_mm), radius, values.shape, pixel_mm, side)
    axes[0].set_title(f"{side} breast, craniocaudal")
    if row:
        _draw_facts(axes[1], row)
    return figure


def _hang(ax: Axes, values: np.ndarray, pixel_mm: float, side: str, *, limits: tuple[float, float]) -> None:
    """A craniocaudal view as it hangs in the clinic, where both breasts stand with the chest between them.

    values: (across towards the patient's right, from the chest wall). The chest wall of the left breast is at
    the left, that of the right breast at the right, lateral is above for both. Axes: mm.
    """
    hung = values if side == "left" else values[::-1, ::-1]
    height, width = np.array(hung.shape) * pixel_mm
    ax.imshow(
        hung,
        cmap="gray",
        vmin=limits[0],
        vmax=limits[1],
        extent=(0, width, height, 0),
        interpolation="antialiased",
    )
    ax.grid(False)
    scale_bar(ax, HUNG_BAR_MM, room_mm=BAR_ROOM * height)
    outward, inward = (0.97, -0.04) if side == "left" else (0.03, 1.04)
    # Across in parts of the axes, down in mm.
    place, ends = ax.get_yaxis_transform(), "right" if side == "left" else "left"
    words: dict[str, Any] = {"color": "white", "transform": place, "fontsize": SMALLEST, "ha": ends}
    ax.text(outward, 0.02 * height, f"{side[0].upper()} CC\nlateral", va="top", **words)
    ax.text(outward, 0.98 * height, "medial", va="bottom", **words)
    ax.text(inward, height / 2, "chest wall", rotation=90, transform=place, ha="center", va="center")


def _circle(
    ax: Axes,
    centre: tuple[float, float],
    radius: float,
    shape: tuple[int, ...],
    pixel_mm: float,
    side: str,
) -> None:
    """Around a lesion at (from the chest wall, across) mm of values of that shape, as they are hung."""
    x, y = centre
    if side == "right":
        x, y = shape[1] * pixel_mm - x, shape[0] * pixel_mm - y
    ax.add_patch(Circle((x, y), radius, fill=False, color=ORANGE, lw=1.1, ls=(0, (4, 3))))


def _draw_facts(ax: Axes, row: dict[str, float]) -> None:
    ax.set_axis_off()
    facts = (
        ("exposure", "{mas:.0f} mAs"),
        ("glandular dose", "{dose_mgy:.2f} ± {dose_se_mgy:.2f} mGy"),
        ("thickness at the lesion", "{thickness_at_lesion_mm:.0f} mm"),
        ("scatter / primary", "{scatter_to_primary:.2f}"),
        ("lesion contrast", "{contrast_percent:.1f} %"),
        ("CNR", "{cnr:.2f} ± {cnr_se:.2f}"),
        ("CNR, quantum limit", "{cnr_quantum:.2f}"),
    )
    known = [(name, text) for name, text in facts if all(k in row for k in _fields(text))]
    for n, (name, text) in enumerate(known):
        y = 0.93 - 0.11 * n
        ax.text(0, y, name, transform=ax.transAxes, fontsize=SMALLEST, color="#5b6570")
        ax.text(0, y - 0.045, text.format(**row), transform=ax.transAxes, fontsize=10)


def _fields(text: str) -> list[str]:
    return [part.split(":")[0] for part in text.split("{")[1:]]


TITLES = {"filtered_backprojection": "filtered backprojection", "sart": "SART"}
AWAY_MM, CIRCLE_MM = 12.0, 9.0


@styled
def tomosynthesis(
    slices: Mapping[str, Image], profiles: pd.DataFrame, lesion: np.ndarray, *, side: str
) -> Figure:
    """The slice through the lesion by each method, one AWAY_MM higher, and the lesion's depth profile.

    slices: method -> 1/mm; profiles: height_mm, difference_per_mm, method; lesion: (3,) mm, its middle.
    """
    names: Any = [[*slices, "higher"], ["profile"] * (len(slices) + 1)]
    grid = next(iter(slices.values())).grid
    high = min(WIDTH / (len(slices) + 1) * 0.72 * grid.shape[2] / grid.shape[1], 4.5)
    figure = new_figure(3.0 + high)
    axes = figure.subplot_mosaic(names, height_ratios=(high, 2.2))
    for method, image in slices.items():
        _draw_slice_of_breast(axes[method], image, lesion, 0.0, side)
        axes[method].set_title(f"{TITLES[method]},\nthrough the lesion")
    _draw_slice_of_breast(axes["higher"], slices["sart"], lesion, AWAY_MM, side)
    axes["higher"].set_title(f"SART,\n{AWAY_MM:g} mm higher")
    profile = axes["profile"]
    for colour, (method, rows) in zip(SERIES, profiles.groupby("method", sort=False)):
        peak = rows.difference_per_mm[rows.height_mm == 0].iloc[0]
        profile.plot(rows.height_mm, rows.difference_per_mm / peak, color=colour, label=TITLES[str(method)])
    profile.set_title("the lesion in all slices")
    profile.axhline(0, color="0.7", lw=0.8)
    profile.set(xlabel="above the lesion (mm)", ylabel="contrast, of that\nin its own slice (-)")
    add_legend(figure, labelled(profile))
    return figure


def _draw_slice_of_breast(ax: Axes, image: Image, lesion: np.ndarray, above_mm: float, side: str) -> None:
    """One slice, hung as a mammogram."""
    grid = image.grid
    k, j, i = grid.indices((lesion + np.array([0, 0, above_mm]))[None])[0]
    V = image.values[int(np.clip(np.rint(k), 0, grid.shape[0] - 1))]
    limits = np.percentile(V[V != 0], (5, 99.5)) if np.any(V != 0) else (0.0, 1.0)
    step = float(grid.spacing[0])
    # Rows of the slice run to posterior, columns to the left: turned, from the chest wall and from lateral.
    values = V.T[::-1, ::-1]
    _hang(ax, values, step, side, limits=(limits[0], limits[1]))
    if above_mm == 0:
        place = (grid.shape[1] - 0.5 - j) * step, (grid.shape[2] - 0.5 - i) * step
        _circle(ax, place, CIRCLE_MM, values.shape, step, side)
