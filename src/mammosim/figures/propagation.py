"""What the interval of fitted moduli means for what follows from them."""

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mammosim.figures.style import BLUE, INK, VERMILION, new_figure, styled

NIPPLE = {"nipple_x_mm": "x", "nipple_y_mm": "y", "nipple_z_mm": "z"}


@styled
def propagation(table: pd.DataFrame) -> Figure:
    """Intervals of the nipples about the fit, and of force and dose, each side of each volunteer a line.

    table: volunteer, side and rows of study.identification.propagation; what was measured is a cross.
    """
    lines = table[["volunteer", "side"]].drop_duplicates()
    figure = new_figure(1.9 + 0.62 * len(lines))
    nipple, force, dose = figure.subplots(1, 3, width_ratios=(1.7, 1, 1))
    places = table[table.quantity.isin(NIPPLE)]
    names = places.volunteer + ", " + places.side + ", " + places.quantity.map(NIPPLE)
    _draw_intervals(nipple, places.assign(name=names), about_fit=True)
    nipple.set(xlabel="nipple, from where the fit predicts it (mm)", title="nipple, held-out position")
    for ax, quantity, label, title in (
        (force, "force_n", "force (N)", "compression"),
        (dose, "agd_mgy", "glandular dose (mGy)", "dose"),
    ):
        rows = table[table.quantity == quantity]
        _draw_intervals(ax, rows.assign(name=rows.volunteer + ", " + rows.side))
        ax.set(xlabel=label, title=title)
        ax.set_xlim(0, 1.15 * ax.get_xlim()[1])
    figure.legend(*nipple.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _draw_intervals(ax: Axes, rows: pd.DataFrame, *, about_fit: bool = False) -> None:
    """A bar from low to high, the fit on it, and what was measured."""
    zero = rows.fit if about_fit else 0.0
    place = range(len(rows))
    ax.hlines(place, rows.low - zero, rows.high - zero, colors=BLUE, lw=5, alpha=0.55, label="all draws")
    ax.plot(rows.fit - zero, place, "o", color=INK, ms=4.5, label="fit")
    ax.plot(rows.measured - zero, place, "x", color=VERMILION, mew=1.8, label="measured")
    ax.set_yticks(place, rows.name)
    ax.set_ylim(len(rows) - 0.4, -0.6)
    ax.grid(False, axis="y")
