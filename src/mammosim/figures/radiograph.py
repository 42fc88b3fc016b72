"""X-rays: the voxels of the compressed breast, the mammogram, dose and scatter."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from mammosim.core.labels import Label
from mammosim.core.volume import LabelMap
from mammosim.figures.slices import draw_labels, tissue_legend
from mammosim.figures.style import ORANGE, new_figure, styled

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
        extent=(0, width, height, 0),
        interpolation="antialiased",
    )
    ax.grid(False)
    ax.set(xlabel="from the chest wall (mm)", ylabel="across (mm)", title=f"{side} breast, craniocaudal")
    if lesion is not None and lesion.any():
        v, u = np.argwhere(lesion).mean(axis=0) + 0.5
        x, y = v * pixel_mm, (u - c0) * pixel_mm
        centre = (x, y) if side == "left" else (width - x, height - y)
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
