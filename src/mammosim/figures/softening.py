"""What softer and stiffer moduli change: nipple upright, force, and thickness and dose at the same force."""

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from mammosim.figures.style import INK, new_figure, series_colour, styled

PANELS = {
    "nipple_moved_mm": ("nipple upright", "moved (mm)"),
    "force_n": ("to the same thickness", "force (N)"),
    "thickness_mm": ("at the same force", "between the plates (mm)"),
    "agd_mgy": ("at the same force", "glandular dose (mGy)"),
}
LINES = {"glandular": "-", "all": ":"}


@styled
def softening(table: pd.DataFrame) -> Figure:
    """A panel per quantity against the factor of the moduli.

    table: rows of study.identification.softening with volunteer and side.
    """
    figure = new_figure(4.6)
    breasts = list(table.groupby(["volunteer", "side"], sort=False))
    for ax, (column, (title, label)) in zip(figure.subplots(2, 2).ravel(), PANELS.items()):
        for number, (_, part) in enumerate(breasts):
            today = part[part.factor == 1.0]
            for tissue, line in LINES.items():
                rows = pd.concat([today, part[(part.tissue == tissue) & (part.factor != 1.0)]])
                rows = rows.sort_values("factor")
                ax.plot(
                    100 * (rows.factor - 1), rows[column], line, marker="o", ms=4, color=series_colour(number)
                )
        ax.set(title=title, ylabel=label, xlabel="change of the moduli (%)")
    marks = [
        Line2D([], [], color=series_colour(number), label=" ".join(name))
        for number, (name, _) in enumerate(breasts)
    ]
    marks += [Line2D([], [], color=INK, ls=line, label=f"{name} changed") for name, line in LINES.items()]
    figure.legend(handles=marks, loc="outside lower center", ncols=4)
    return figure
