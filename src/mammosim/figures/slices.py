"""Slices of images in mm, laid out as in radiology: the patient's left at the right, posterior below."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, to_rgb
from matplotlib.lines import Line2D

from mammosim.core.labels import Label
from mammosim.core.volume import Grid, Image, LabelMap
from mammosim.figures.style import ORANGE, TISSUE_COLOURS, picture_axes

# Of each plane: the array axis that is cut, and the patient axes (x 0, y 1, z 2) to the right and up or down.
PLANES: Mapping[str, tuple[int, int, int]] = {"axial": (0, 0, 1), "coronal": (1, 0, 2), "sagittal": (2, 1, 2)}
SEEN = 600  # voxels that half a page shows side by side
ENDS = ("RL", "AP", "IS")  # of the patient axes, low and high
AXIS_LABELS = ("x to the left (mm)", "y to posterior (mm)", "z to superior (mm)")


def slice_of(volume: Image | LabelMap, plane: str, at_mm: float) -> np.ndarray:
    """Values (rows, columns) of an axis-aligned volume in the slice nearest to at_mm along its normal."""
    cut, _, _ = PLANES[plane]
    k = round(float((at_mm - volume.grid.origin[2 - cut]) / volume.grid.spacing[2 - cut]))
    return np.take(volume.values, np.clip(k, 0, volume.values.shape[cut] - 1), axis=cut)


def extent_of(grid: Grid, plane: str) -> tuple[float, float, float, float]:
    """(left, right, first row, last row) mm of a slice, edges of the voxels."""
    low = grid.origin - grid.spacing / 2
    high = low + grid.spacing * np.array(grid.shape[::-1])
    _, across, along = PLANES[plane]
    return float(low[across]), float(high[across]), float(low[along]), float(high[along])


def draw_slice(
    ax: Axes, image: Image, plane: str, at_mm: float, *, limits: tuple[float, float] | None = None
) -> None:
    """A grey slice; limits are the intensities of black and white, by default 0 and the 99.5th percentile."""
    low, high = limits or window(image)
    frame_slice(ax, image.grid, plane)
    ax.imshow(
        slice_of(image, plane, at_mm),
        extent=extent_of(image.grid, plane),
        origin="lower",
        cmap="gray",
        vmin=low,
        vmax=high,
        interpolation=voxels_or_mean(image),
    )
    frame_slice(ax, image.grid, plane)


def voxels_or_mean(image: Image) -> str:
    """How an image is drawn: voxel by voxel, also in a vector file, or means of more voxels than are seen."""
    return "none" if max(image.grid.shape) <= SEEN else "antialiased"


def window(image: Image) -> tuple[float, float]:
    """Black and white of an image: 0 and the 99.5th percentile."""
    return 0.0, float(np.percentile(image.values, 99.5)) or 1.0


def draw_labels(
    ax: Axes, labels: LabelMap, plane: str, at_mm: float, *, filled: bool = True, opacity: float = 0.45
) -> None:
    """Tissues over a slice: filled, or as outlines."""
    values = slice_of(labels, plane, at_mm)
    extent = extent_of(labels.grid, plane)
    if filled:
        colours = np.array([(*to_rgb(TISSUE_COLOURS[label]), opacity) for label in Label])
        colours[Label.AIR, 3] = 0
        ax.imshow(
            values,
            extent=extent,
            origin="lower",
            cmap=ListedColormap(colours),
            vmin=-0.5,
            vmax=len(Label) - 0.5,
            interpolation="none",
        )
    else:
        for label in set(np.unique(values)) - {Label.AIR}:
            mask = np.where(values == label, 1.0, 0.0)
            ax.contour(
                mask,
                [0.5],
                extent=extent,
                origin="lower",
                colors=TISSUE_COLOURS[Label(label)],
                linewidths=1.1,
            )
    frame_slice(ax, labels.grid, plane)


def tissue_legend(labels: LabelMap) -> list[Line2D]:
    """Legend handles of the tissues present."""
    present = [Label(v) for v in np.unique(labels.values) if v != Label.AIR]
    return [
        Line2D([], [], marker="s", ls="", ms=8, color=TISSUE_COLOURS[label], label=label.tissue)
        for label in present
    ]


def frame_slice(ax: Axes, grid: Grid, plane: str) -> None:
    """Axes in mm around a slice; axial slices have posterior below."""
    left, right, low, high = extent_of(grid, plane)
    _, across, along = PLANES[plane]
    picture_axes(ax)
    ax.set(xlim=(left, right), xlabel=AXIS_LABELS[across], ylabel=AXIS_LABELS[along])
    ax.set_ylim((high, low) if plane == "axial" else (low, high))


def draw_gravity(ax: Axes, g: np.ndarray, plane: str) -> None:
    """Its arrow g (3,), a unit vector in the frame of the slice; nothing where it stands upright on it."""
    _, across, along = PLANES[plane]
    (x0, x1), (y0, y1) = ax.get_xlim(), ax.get_ylim()
    direction = np.array([g[across] * np.sign(x1 - x0), g[along] * np.sign(y1 - y0)])
    if np.hypot(*direction) < 0.3:
        return
    start = np.array([0.72, 0.15]) - 0.07 * direction
    ax.annotate(
        "",
        tuple(start + 0.18 * direction),
        tuple(start),
        xycoords="axes fraction",
        arrowprops={"arrowstyle": "-|>", "color": ORANGE, "lw": 1.8},
    )
    x, y = start - 0.04 * direction
    ax.text(x, y, "g", color=ORANGE, transform=ax.transAxes, ha="center", va="center")


def draw_sides(ax: Axes, plane: str) -> None:
    """R and L, A and P, I and S at the edges of a framed slice."""
    _, across, along = PLANES[plane]
    (x0, x1), (y0, y1) = ax.get_xlim(), ax.get_ylim()
    horizontal = ENDS[across] if x1 > x0 else ENDS[across][::-1]
    vertical = ENDS[along] if y1 > y0 else ENDS[along][::-1]
    places = ((0.03, 0.5), (0.97, 0.5), (0.5, 0.04), (0.5, 0.96))
    for letter, (x, y) in zip(horizontal + vertical, places):
        ax.text(x, y, letter, color=ORANGE, weight="bold", transform=ax.transAxes, ha="center", va="center")


def straight(image: Image) -> Image:
    """The image in axes of its own: its voxels where they are, seen along its rows, columns and slices."""
    return Image(Grid(image.grid.shape, image.grid.spacing, image.grid.origin), image.values)


def in_axes_of(grid: Grid, points: np.ndarray) -> np.ndarray:
    """Patient points (n, 3) mm in the axes of a grid that `straight` draws, (n, 3) mm."""
    found: np.ndarray = grid.origin + (points - grid.origin) @ grid.direction
    return found


def labels_in_slice(labels: LabelMap, grid: Grid, plane: str, at_mm: float) -> LabelMap:
    """Labels at the voxels of one slice of another grid, as `straight` draws it; air outside of them."""
    cut = PLANES[plane][0]
    k = round(float((at_mm - grid.origin[2 - cut]) / grid.spacing[2 - cut]))
    counts = list(grid.shape)
    index = np.indices([1 if axis == cut else n for axis, n in enumerate(counts)]).reshape(3, -1).T
    index[:, cut] = np.clip(k, 0, counts[cut] - 1)
    there = np.rint(labels.grid.indices(grid.points(index.astype(float)))).astype(int)
    inside = np.all((there >= 0) & (there < labels.grid.shape), axis=1)
    values = np.zeros(len(index), labels.values.dtype)
    values[inside] = labels.values[tuple(there[inside].T)]
    nz, ny, nx = (1 if axis == cut else n for axis, n in enumerate(counts))
    origin = grid.origin.copy()
    origin[2 - cut] += index[0, cut] * grid.spacing[2 - cut]
    return LabelMap(Grid((nz, ny, nx), grid.spacing, origin), values.reshape(nz, ny, nx))
