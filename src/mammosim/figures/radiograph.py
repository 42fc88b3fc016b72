"""X-rays: the voxels of the compressed breast, the mammogram, and slices of tomosynthesis."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from mammosim.core.labels import Label
from mammosim.core.volume import Image, LabelMap
from mammosim.figures.slices import draw_labels, tissue_legend
from mammosim.figures.style import ORANGE, SERIES, new_figure, styled

# Attenuation, -ln(transmission), above which a pixel is breast: more than the beam falls towards the corners
# of the field, less than 1 cm of fat.
IN_BREAST = 0.5


@styled
def phantom_slices(labels: LabelMap) -> Figure:
    """Three slices of the voxels of a compressed breast, through its lesion if it has one."""
    here = np.argwhere(labels.values == Label.LESION)
    here = here if len(here) else np.argwhere(labels.values != Label.AIR)
    x, y, z = labels.grid.points(here.mean(axis=0, keepdims=True))[0]
    nz, ny, nx = labels.grid.shape * labels.grid.spacing[::-1]
    figure = new_figure(1.1 + 7.0 * (nz + ny) / (nx + ny))
    axes = figure.subplots(2, 2, width_ratios=(nx, ny), height_ratios=(ny, nz))
    for ax, plane, at in zip(axes.ravel()[[0, 2, 3]], ("axial", "coronal", "sagittal"), (z, y, x)):
        draw_labels(ax, labels, plane, at, opacity=1.0)
        ax.set_title({"axial": "from below", "coronal": "from the front", "sagittal": "from the side"}[plane])
    axes[0, 1].set_axis_off()
    axes[0, 1].legend(handles=tissue_legend(labels), loc="center", fontsize=8.5)
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
    figure = new_figure(5.0, width=7.0 if row else 4.6)
    axes = figure.subplots(1, 2 if row else 1, width_ratios=(2.2, 1) if row else None, squeeze=False)[0]
    crop = shown[: r1 + 1, c0 : c1 + 1].T
    # As if facing the patient: the chest wall of the right breast is at the right; lateral is above for both.
    crop = crop if side == "left" else crop[::-1, ::-1]
    width, height = crop.shape[1] * pixel_mm, crop.shape[0] * pixel_mm
    ax = axes[0]
    ax.imshow(
        crop,
        cmap="gray",
        vmin=low * 0.55,
        vmax=high,
        extent=(*((0, width) if side == "left" else (width, 0)), height, 0),
        interpolation="antialiased",
    )
    ax.grid(False)
    ax.set(xlabel="from the chest wall (mm)", ylabel="across (mm)", title=f"{side} breast, craniocaudal")
    if lesion is not None and lesion.any():
        v, u = np.argwhere(lesion).mean(axis=0) + 0.5
        x, y = v * pixel_mm, (u - c0) * pixel_mm
        centre = (x, y if side == "left" else height - y)
        radius = 2.2 * np.sqrt(lesion.sum() / np.pi) * pixel_mm
        ax.add_patch(Circle(centre, radius, fill=False, color=ORANGE, lw=1.1, ls=(0, (4, 3))))
    if row:
        _draw_facts(axes[1], row)
    return figure


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
        ax.text(0, y, name, transform=ax.transAxes, fontsize=8, color="#5b6570")
        ax.text(0, y - 0.045, text.format(**row), transform=ax.transAxes, fontsize=10)


def _fields(text: str) -> list[str]:
    return [part.split(":")[0] for part in text.split("{")[1:]]


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
        _draw_slice_of_breast(ax, image, lesion, 0.0, side)
        ax.set_title(f"{TITLES[method]}, through the lesion", fontsize=8.5)
    _draw_slice_of_breast(axes[1, 0], slices["sart"], lesion, AWAY_MM, side)
    axes[1, 0].set_title(f"SART, {AWAY_MM:g} mm higher", fontsize=8.5)
    for colour, (method, rows) in zip(SERIES, profiles.groupby("method", sort=False)):
        peak = rows.difference_per_mm[rows.height_mm == 0].iloc[0]
        axes[1, 1].plot(
            rows.height_mm,
            rows.difference_per_mm / peak,
            color=colour,
            label=TITLES[str(method)],
        )
    axes[1, 1].axhline(0, color="0.7", lw=0.8)
    axes[1, 1].set(xlabel="above the lesion (mm)", ylabel="contrast, of that in its own slice")
    axes[1, 1].legend()
    return figure


def _draw_slice_of_breast(ax: Axes, image: Image, lesion: np.ndarray, above_mm: float, side: str) -> None:
    """One slice, chest wall at the side of the breast, as a mammogram is hung."""
    grid = image.grid
    k, j, i = grid.indices((lesion + np.array([0, 0, above_mm]))[None])[0]
    V = image.values[int(np.clip(np.rint(k), 0, grid.shape[0] - 1))]
    low, high = np.percentile(V[V != 0], (5, 99.5)) if np.any(V != 0) else (0.0, 1.0)
    # Rows of the slice run to posterior, columns to the left: the chest wall to the left, lateral above.
    shown, x, y = V.T[::-1, ::-1], grid.shape[1] - 1 - j, grid.shape[2] - 1 - i
    step = grid.spacing[0]
    height, width = np.array(shown.shape) * step
    if side == "right":
        shown, y = shown[::-1, ::-1], shown.shape[0] - 1 - y
    extent = (*((0, width) if side == "left" else (width, 0)), height, 0)
    ax.imshow(shown, cmap="gray", vmin=low, vmax=high, extent=extent, interpolation="antialiased")
    if above_mm == 0:
        ax.add_patch(
            Circle(
                ((x + 0.5) * step, (y + 0.5) * step), 9.0, fill=False, color=ORANGE, lw=1.1, ls=(0, (4, 3))
            )
        )
    ax.grid(False)
    ax.set(xlabel="from the chest wall (mm)", ylabel="across (mm)")
