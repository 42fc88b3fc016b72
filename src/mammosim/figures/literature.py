"""Where this study's numbers fall among those that others reported."""

from collections.abc import Mapping

import pandas as pd
from matplotlib.figure import Figure

from mammosim.figures.style import BLUE, GREEN, ORANGE, PURPLE, QUIET, VERMILION, new_figure, styled

OTHERS = (BLUE, GREEN, PURPLE, ORANGE)


@styled
def moduli(published: pd.DataFrame, here: Mapping[str, tuple[float, float]]) -> Figure:
    """Young's moduli in the literature (the report's table 1.1) and in this study, on a logarithmic axis.

    published: the table `published_biomechanics`; here: name -> lowest and highest modulus used, kPa.
    """
    rows = published.sort_values(["loading", "low_kpa"], ignore_index=True)
    used = pd.DataFrame(
        [("this study", name, low, high, "this study", "") for name, (low, high) in here.items()],
        columns=["source", "tissue", "low_kpa", "high_kpa", "loading", "status"],
    )
    rows = pd.concat([rows, used], ignore_index=True)
    figure = new_figure(0.9 + 0.24 * len(rows))
    ax = figure.subplots()
    for number, (loading, group) in enumerate(rows.groupby("loading", sort=False)):
        colour = VERMILION if loading == "this study" else OTHERS[number % len(OTHERS)]
        ax.hlines(group.index, group.low_kpa, group.high_kpa, colors=colour, lw=5)
        for ends in (group.low_kpa, group.high_kpa):
            ax.scatter(ends, group.index, color=colour, s=28, zorder=3)
        ax.plot([], [], color=colour, lw=5, label=loading)
    for place in rows.index[rows.status == "unverified"]:
        at = (rows.high_kpa[place], place)
        ax.annotate(
            "from memory", at, (9, 0), textcoords="offset points", va="center", fontsize=7, color=QUIET
        )
    ax.set_xscale("log")
    ax.set_yticks(rows.index, rows.source + ", " + rows.tissue)
    ax.set_xlabel("Young's modulus (kPa)")
    ax.legend(loc="upper right")
    ax.grid(False, axis="y")
    ax.invert_yaxis()
    return figure
