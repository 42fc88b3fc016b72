"""What was understood of the data of one position, for a person to look at before anything is computed."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from mammosim.core.fiducials import Fiducials
from mammosim.core.volume import Image, LabelMap
from mammosim.figures.slices import (
    PLANES,
    draw_gravity,
    draw_labels,
    draw_sides,
    draw_slice,
    in_axes_of,
    labels_in_slice,
    straight,
    tissue_legend,
)
from mammosim.figures.style import INK, ORANGE, QUIET, SMALLEST, new_figure, picture_axes, styled
from mammosim.figures.volunteers import MARKS, NEAR_MM, draw_fiducials

# The slices are chosen on blocks of voxels, of which those brighter than this part of the brightest are body.
BLOCK_MM, BODY = 8.0, 0.2
# The coronal slice lies this far behind the foremost tissue.
BEHIND_MM = 25.0
APART_MM = 40.0  # of points whose names can both be read


@styled
def understood(
    image: Image,
    *,
    gravity: np.ndarray,
    title: str,
    labels: LabelMap | None = None,
    fiducials: Fiducials | None = None,
) -> Figure:
    """Three planes through the foremost tissue: gravity, the sides, outlines of the tissues, points by name.

    gravity (3,): unit vector, frame of the image; labels: on any grid; title: whose position, at what
    spacing. A slice shows rows and columns of the image, whose axes may be turned against the patient's.
    """
    figure = new_figure(5.6)
    shown, g = straight(image), gravity @ image.grid.direction
    at = in_axes_of(image.grid, _place(image, fiducials)[None])[0]
    points = fiducials and Fiducials(
        fiducials.names, fiducials.kinds, in_axes_of(image.grid, fiducials.points)
    )
    panels = figure.subplots(2, 2).ravel()
    for ax, plane in zip(panels, PLANES):
        axis = 2 - PLANES[plane][0]
        draw_slice(ax, shown, plane, at[axis])
        if labels is not None:
            tissues = labels_in_slice(labels, image.grid, plane, at[axis])
            draw_labels(ax, tissues, plane, at[axis], filled=False)
        draw_gravity(ax, g, plane)
        _draw_upright_gravity(ax, g, plane)
        draw_sides(ax, plane)
        if points is not None:
            draw_fiducials(ax, points, plane, at[axis], far=True)
            _name(ax, points, plane, at[axis])
        ax.set_title(f"{plane}, {'xyz'[axis]} = {at[axis]:.0f} mm")
    panels[3].remove()
    _legend(figure, labels, fiducials)
    figure.suptitle(title, fontsize=10, weight="bold")
    return figure


@styled
def one_slice(values: np.ndarray, *, title: str) -> Figure:
    """One stored slice (n_row, n_column) of a series that makes no volume."""
    figure = new_figure(3.3)
    ax = figure.subplots()
    picture_axes(ax)
    ax.imshow(values, cmap="gray", vmin=0, vmax=float(np.percentile(values, 99.5)) or 1.0)
    ax.set(title=title, xlabel="column (voxels)", ylabel="row (voxels)")
    return figure


def _place(image: Image, fiducials: Fiducials | None) -> np.ndarray:
    """Where the slices meet (3,) mm, patient frame: behind the left nipple, or behind the foremost tissue."""
    if fiducials is not None and "nipple_left" in fiducials.names:
        front = fiducials.point("nipple_left")
    else:
        front = _foremost(image)
    return front + np.array([0.0, BEHIND_MM, 0.0])


def _foremost(image: Image) -> np.ndarray:
    """The middle (3,) mm of the foremost row of bright blocks of voxels; of the image where none is."""
    steps = np.maximum(np.rint(BLOCK_MM / image.grid.spacing[::-1]).astype(int), 1)
    nz, ny, nx = np.maximum(np.array(image.grid.shape) // steps, 1)
    dz, dy, dx = np.minimum(steps, image.grid.shape)
    whole = image.values[: nz * dz, : ny * dy, : nx * dx]
    blocks = whole.reshape(nz, dz, ny, dy, nx, dx).mean(axis=(1, 3, 5))
    bright = np.argwhere(blocks > BODY * np.percentile(blocks, 99))
    if len(bright) == 0:
        return image.grid.points(np.array(image.grid.shape)[None] / 2)[0]
    first = bright[bright[:, 1] == bright[:, 1].min()]
    # Of two breasts one: their middle is between them.
    side = first[first[:, 2] >= np.median(first[:, 2])]
    return image.grid.points((side.mean(axis=0) * [dz, dy, dx])[None])[0]


def _draw_upright_gravity(ax: Axes, g: np.ndarray, plane: str) -> None:
    """Gravity that stands on the slice: a dot towards the eye, a cross away from it."""
    _, across, along = PLANES[plane]
    normal = np.cross(np.eye(3)[across], (-1 if plane == "axial" else 1) * np.eye(3)[along])
    if abs(g @ normal) > 0.9:
        mark = "⊙ g" if g @ normal > 0 else "⊗ g"
        ax.text(0.72, 0.15, mark, fontsize=11, color=ORANGE, transform=ax.transAxes, ha="center")


def _name(ax: Axes, fiducials: Fiducials, plane: str, at: float) -> None:
    """The names of the nipples beside them: whose they are is what a person can tell.

    Of two that would be written over each other, that of the one nearer to the slice.
    """
    axis, across, along = PLANES[plane]
    nipples = [
        (name, point)
        for name, kind, point in zip(fiducials.names, fiducials.kinds, fiducials.points)
        if kind == "nipple"
    ]
    named: list[np.ndarray] = []
    for name, point in sorted(nipples, key=lambda each: abs(each[1][2 - axis] - at)):
        if all(np.linalg.norm((point - other)[[across, along]]) > APART_MM for other in named):
            named.append(point)
            ax.annotate(
                name.removeprefix("nipple_"),
                tuple(point[[across, along]]),
                xytext=(4, 4),
                textcoords="offset points",
                fontsize=SMALLEST,
                color="w",
                path_effects=[withStroke(linewidth=1.2, foreground=INK)],
            )


def _legend(figure: Figure, labels: LabelMap | None, fiducials: Fiducials | None) -> None:
    handles = [] if labels is None else tissue_legend(labels)
    kinds = () if fiducials is None else fiducials.kinds
    for kind, (colour, marker) in MARKS.items():
        if kind in kinds:
            handles.append(Line2D([], [], ls="", marker=marker, color=colour, mec="k", label=kind))
    if kinds:
        far = f"farther than {NEAR_MM:g} mm\nfrom the slice, projected"
        handles.append(Line2D([], [], ls="", marker="o", mfc="none", color=QUIET, label=far))
    if handles:
        # In the quarter that no plane takes.
        figure.legend(handles=handles, loc="center", bbox_to_anchor=(0.77, 0.25))
