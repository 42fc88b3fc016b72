"""Where this study's numbers fall among those that others reported."""

from collections.abc import Mapping

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mammosim.figures.style import (
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    QUIET,
    SKY,
    SMALLEST,
    VERMILION,
    new_figure,
    styled,
)
from mammosim.figures.ticks import plain_log
from mammosim.io.tabulated import tabulated
from mammosim.study.identification.published import beside

UNDER = {"gravity": BLUE, "compression": VERMILION, "ex vivo": GREEN, "assumed": ORANGE}
FITTED, USED = "this study, fitted under gravity", "this study, assumed elsewhere"
COLOURS = {**UNDER, FITTED: SKY, USED: PURPLE}


@styled
def moduli(fitted: pd.DataFrame, here: Mapping[str, tuple[float, float]]) -> Figure:
    """Young's moduli in the literature (table 1.1 of Mira 2018) and in this study, on a logarithmic axis.

    fitted: volunteer, side, tissue, fitted_kpa, low_kpa, high_kpa, identifiable; here: name -> lowest and
    highest modulus that this study assumes, kPa. A fit that is not identifiable is hollow; one that has only
    an upper end begins at the axis.
    """
    used = pd.DataFrame(
        [("this study", name, low, high, USED, "") for name, (low, high) in here.items()],
        columns=["source", "tissue", "low_kpa", "high_kpa", "under", "status"],
    )
    rows = beside(tabulated("published_biomechanics"), fitted)
    kind = rows.under.where(~rows.source.str.startswith("this study"), FITTED)
    rows = pd.concat([rows.assign(under=kind), used], ignore_index=True)
    order = rows.under.map(list(COLOURS).index)
    rows = rows.assign(order=order).sort_values(["order", "tissue", "source"], ignore_index=True)
    figure = new_figure(1.2 + 0.22 * len(rows))
    ax = figure.subplots()
    for under, group in rows.groupby("under", sort=False):
        _draw_ranges(ax, group, COLOURS[str(under)], _lowest(rows))
        ax.plot([], [], color=COLOURS[str(under)], lw=5, label=under)
    _remark(ax, rows, "unverified", "from memory")
    ax.plot([], [], "o", mfc="none", color=COLOURS[FITTED], label="not identifiable")
    ax.set_xscale("log")
    ax.margins(y=0.01)
    plain_log(ax.xaxis)
    ax.set_xlim(_lowest(rows), 2 * rows.high_kpa.max())
    ax.set_yticks(rows.index, rows.source + ", " + rows.tissue)
    ax.set_xlabel("Young's modulus (kPa)")
    figure.legend(loc="outside lower center", ncols=3)
    ax.grid(False, axis="y")
    ax.invert_yaxis()
    return figure


def _lowest(rows: pd.DataFrame) -> float:
    """Where a logarithmic axis of these moduli begins, kPa."""
    return float(rows.low_kpa[rows.low_kpa > 0].min()) / 2


def _draw_ranges(ax: Axes, rows: pd.DataFrame, colour: str, lowest: float) -> None:
    """A bar from low to high, with its ends; hollow where the data do not identify it."""
    for place, row in rows.iterrows():
        hollow = row.status == "not identifiable"
        ax.hlines(place, max(row.low_kpa, lowest), row.high_kpa, colors=colour, lw=1.5 if hollow else 5)
        face = "none" if hollow else colour
        for end in (end for end in (row.low_kpa, row.high_kpa) if end > 0):
            ax.scatter(end, place, facecolors=face, edgecolors=colour, s=28, zorder=3)
        if row.low_kpa < row.middle_kpa < row.high_kpa:
            ax.plot(row.middle_kpa, place, "|", color="white" if not hollow else colour, ms=7, zorder=4)


def _remark(ax: Axes, rows: pd.DataFrame, status: str, text: str) -> None:
    for place in rows.index[rows.status == status]:
        at = (rows.high_kpa[place], place)
        ax.annotate(text, at, (9, 0), textcoords="offset points", va="center", fontsize=SMALLEST, color=QUIET)


@styled
def gravity_and_compression(fitted: pd.DataFrame, ratios: pd.DataFrame) -> Figure:
    """Moduli fitted under gravity beside those used under compression, a column per tissue, with their ratio.

    fitted: as of moduli; ratios: of study.identification.published.ratios.
    """
    rows = beside(tabulated("published_biomechanics"), fitted)
    figure = new_figure(3.8)
    ax = figure.subplots()
    tissues = [t for t in ("breast", "adipose", "glandular", "skin", "lesion") if t in set(rows.tissue)]
    shown = rows[rows.under.isin(["gravity", "compression"]) & rows.tissue.isin(tissues)]
    for tissue, group in shown.groupby("tissue", sort=False):
        step = min(0.08, 0.5 / len(group))
        for number, row in enumerate(group.itertuples()):
            fits = str(row.source).startswith("this study")
            place = tissues.index(str(tissue)) + (0.3 if row.under == "compression" else step * number - 0.3)
            colour = COLOURS[FITTED] if fits else UNDER[str(row.under)]
            fill = "none" if row.status == "not identifiable" else "full"
            ax.vlines(place, row.low_kpa, row.high_kpa, colors=colour, lw=3)
            ax.plot(place, row.middle_kpa, "o", color=colour, fillstyle=fill)
    ratio = {
        row.tissue: f"\nx {row.ratio:.1f}\n({row.ratio_low:.1f} to {row.ratio_high:.1f})"
        for row in ratios.itertuples()
    }
    for label in ("gravity", "compression", FITTED):
        ax.plot([], [], "o", color=COLOURS[label], label=label)
    ax.set_yscale("log")
    plain_log(ax.yaxis)
    ax.set_xticks(range(len(tissues)), [f"{tissue}{ratio.get(tissue, '')}" for tissue in tissues])
    ax.set_xlim(-0.5, len(tissues) - 0.5)
    ax.set_ylabel("Young's modulus (kPa)")
    ax.grid(False, axis="x")
    figure.legend(loc="outside lower center", ncols=3)
    return figure
