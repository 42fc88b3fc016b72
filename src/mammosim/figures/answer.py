"""What each strategy does to one breast, what it costs, and how far compression can be reduced."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from mammosim.chain.conditions import UNDER_GRAVITY
from mammosim.chain.strategies import STANDARD
from mammosim.core.errors import MissingResult
from mammosim.figures.series import add_legend, colours, numbered, some
from mammosim.figures.style import GREEN, INK, QUIET, new_figure, styled
from mammosim.study.report.answer import NEARLY_NONE, slow
from mammosim.study.report.pressed_breast import DONE, FORCE, PRESSURE, STRAIN, of_breast
from mammosim.study.report.strategy_costs import CALCIFICATIONS, COSTS, DOSE, MASS

WIDTH_IN, HEIGHT_IN = 6.7, 7.4  # 17 cm; letters are as large as a phone, 9 cm wide, needs them
LETTERS = 11
# What she feels on the left, what it costs on the right.
PANELS: Mapping[str, str] = {
    STRAIN: "discomfort: strain",
    DOSE: "glandular dose (mGy)",
    FORCE: "force (N)",
    MASS: "d' of the mass",
    PRESSURE: "mean pressure (kPa)",
    CALCIFICATIONS: "d' of the calcifications",
}
SAME_MM = 0.5  # strategies whose thicknesses differ by less are told apart by their force
MARGIN = 0.08  # of the axis beside the strategies


@styled
def answer(
    answers: pd.DataFrame,
    costs: pd.DataFrame,
    compression: pd.DataFrame,
    path: pd.DataFrame,
    *,
    volunteer: str,
    side: str,
    loss_percent: Mapping[str, float],
) -> Figure:
    """A panel per quantity over the compressed thickness, or over the force where thicknesses are the same.

    answers, costs, compression, path: rows of answer.csv, answer_strategies.csv, compression.csv,
    compression_path.csv; loss_percent: the limits. Bars and bands: intervals; dashed: the limit; shaded:
    where all losses are less than their limits, at least and at most.
    Raises MissingResult where this breast was not pressed.
    """
    answers, costs, compression, path = (
        of_breast(table, volunteer, side) for table in (answers, costs, compression, path)
    )
    if costs.empty:
        raise MissingResult("; ".join(answers.why) or f"no answer of {volunteer}, {side}")
    force = costs[costs["quantity"] == FORCE].set_index("strategy").value
    costs = costs.assign(force_n=costs.strategy.map(force))
    figure = new_figure(HEIGHT_IN, width=WIDTH_IN)
    axes = dict(zip(PANELS, figure.subplots(3, 2, sharex=True).ravel()))
    over = _axis(costs)
    named = [name for name in dict.fromkeys(compression.strategy) if name in set(costs.strategy)]
    marker, hue = numbered(named), colours([UNDER_GRAVITY, *_others(compression)])
    for quantity, ax in axes.items():
        rows = costs[costs["quantity"] == quantity]
        if quantity in DONE:
            _draw_done(ax, rows, compression, path, hue, over)
        else:
            _draw_limit(ax, rows, loss_percent[COSTS[quantity][0]])
        if over == "thickness_mm":
            _draw_band(ax, rows, *((QUIET, 0.15) if quantity in DONE else (hue[UNDER_GRAVITY], 0.2)))
        _mark(ax, rows, marker, hue[UNDER_GRAVITY], over)
        _finish(ax, PANELS[quantity])
    if over == "thickness_mm":
        for ax in axes.values():
            _shade(ax, answers.iloc[0])
            ax.set_xlim(*_ends(costs.thickness_mm))
    for ax in figure.axes[-2:]:
        ax.set_xlabel("thickness (mm)" if over == "thickness_mm" else "force (N)", fontsize=LETTERS)
    add_legend(figure, _legend(marker, hue, answers.iloc[0], over), ncols=2, fontsize=LETTERS - 1)
    return figure


def _others(compression: pd.DataFrame) -> list[str]:
    return [name for name in compression.moduli.unique() if name != UNDER_GRAVITY]


def _axis(costs: pd.DataFrame) -> str:
    """The column that tells strategies apart."""
    every = costs.drop_duplicates("strategy").thickness_mm
    return "thickness_mm" if len(every) < 2 or np.ptp(every) >= SAME_MM else FORCE


def _draw_done(
    ax: Axes,
    rows: pd.DataFrame,
    compression: pd.DataFrame,
    path: pd.DataFrame,
    hue: Mapping[str, str],
    over: str,
) -> None:
    """The load path of the standard with each set of moduli, or a line through the strategies."""
    quantity = str(rows["quantity"].iloc[0])
    column = DONE[quantity]
    for moduli, colour in hue.items():
        pressed = compression[compression.moduli == moduli].sort_values("thickness_mm")
        line = path[(path.moduli == moduli) & (path.strategy == STANDARD)]
        if over == "thickness_mm":
            curve = pressed if quantity == STRAIN else line
            ax.plot(curve.thickness_mm, curve[column], color=colour, lw=1.2, alpha=0.8, zorder=1)
        if moduli != UNDER_GRAVITY:
            at = pressed.thickness_mm if over == "thickness_mm" else pressed.force_n
            ax.plot(at, pressed[column], "o", color=colour, mfc="white", ms=4.5, zorder=2)


def _draw_band(ax: Axes, rows: pd.DataFrame, colour: str, alpha: float) -> None:
    """Between the chords of the intervals, through strategies with level plates."""
    level = rows[rows.level & rows.low.notna()].sort_values("thickness_mm")
    if level.empty:
        return
    t = level.thickness_mm.to_numpy(float)
    fine = np.unique([*np.linspace(t[0], t[-1], 200), *t])
    low = np.interp(fine, t, level.low)
    if str(rows["quantity"].iloc[0]) == DOSE:
        place = np.interp(fine, t, np.arange(len(t)))
        least = np.maximum(level.low, (1 + NEARLY_NONE / 100) * level.value)
        low = np.exp(np.interp(np.floor(place) + slow(place % 1), np.arange(len(t)), np.log(least)))
    ax.fill_between(fine, low, np.interp(fine, t, level.high), color=colour, alpha=alpha, lw=0, zorder=0.5)


def _draw_limit(ax: Axes, rows: pd.DataFrame, limit: float) -> None:
    """What the value may be, by the limit in percent of that of the standard."""
    standard = rows[rows.strategy == STANDARD].value
    if len(standard) and np.isfinite(standard.iloc[0]):
        sign = COSTS[str(rows["quantity"].iloc[0])][1]
        ax.axhline(standard.iloc[0] * (1 + sign * limit / 100), color=INK, ls=(0, (4, 2)), lw=1.0)


def _mark(ax: Axes, rows: pd.DataFrame, marker: Mapping[str, str], colour: str, over: str) -> None:
    """A mark for each strategy, with its interval where that is one of the value itself."""
    for _, row in rows.iterrows():
        x = float(row[over])
        if row["quantity"] in COSTS and np.isfinite(row.low):
            ax.plot([x, x], [row.low, row.high], color=colour, lw=1.4)
        ax.plot(
            x, row.value, ls="", marker=marker[str(row.strategy)], color=colour, ms=6, mec="white", mew=0.5
        )


def _finish(ax: Axes, label: str) -> None:
    ax.set_title(label, fontsize=LETTERS, fontweight="normal")
    ax.tick_params(labelsize=LETTERS - 1)
    shown = ax.dataLim.y1
    ax.set_ylim(0, 1.1 * shown if np.isfinite(shown) and shown > 0 else 1)
    if not np.isfinite(shown):
        ax.text(0.5, 0.5, "not computed", transform=ax.transAxes, ha="center", color=QUIET, fontsize=LETTERS)


def _shade(ax: Axes, row: pd.Series) -> None:
    """Where every loss is less than its limit: at least, and at most."""
    start = row.standard_mm
    certain = row.certain_mm if np.isfinite(row.certain_mm) else start
    if certain > start:
        ax.axvspan(start, certain, color=GREEN, alpha=0.45, lw=0, zorder=0)
    if row.possible_mm > certain:
        ax.axvspan(certain, row.possible_mm, color=GREEN, alpha=0.18, lw=0, zorder=0)


def _ends(t: pd.Series) -> tuple[float, float]:
    room = MARGIN * max(float(np.ptp(t)), 10.0)
    return float(t.min()) - room, float(t.max()) + room


def _legend(marker: Mapping[str, str], hue: Mapping[str, str], row: pd.Series, over: str) -> list[Artist]:
    marks: list[Artist] = [
        Line2D([], [], ls="", marker=each, color=QUIET, label=name) for name, each in marker.items()
    ]
    sets: list[Artist] = [
        Line2D([], [], color=colour, label=f"{name} moduli") for name, colour in hue.items()
    ]
    found = [
        *some(marks, "strategies"),
        *sets,
        Line2D([], [], color=INK, ls=(0, (4, 2)), lw=1.0, label="loss allowed"),
    ]
    if over == "thickness_mm" and row.possible_mm > row.standard_mm:
        found += [
            Patch(color=GREEN, alpha=0.45, label="less, at least here"),
            Patch(color=GREEN, alpha=0.18, label="may be less"),
        ]
    return found
