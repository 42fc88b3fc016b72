"""What accuracy costs: errors against time, orders of convergence, the error budget of the chain."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from mammosim.figures.series import panels
from mammosim.figures.style import (
    BLUE,
    INK,
    ORANGE,
    QUIET,
    SERIES,
    SMALLEST,
    VERMILION,
    WIDTH,
    new_figure,
    styled,
)
from mammosim.study.accuracy.errors import on_front
from mammosim.study.accuracy.trial import CHAIN

NOTHING = 0.3  # of the smallest error above zero: where an error of zero is drawn
LEAST_SPAN = 2.0  # of the time axis to either side: less would be all noise of timing
UNITS = {"mm": "mm", "n": "N", "kpa": "kPa", "percent": "%"}
SHOWN = 4  # parameters with a colour of their own in a budget
ORDERS_SHOWN = (-7.0, 9.0)
LETTERS = 4.9  # of a name, in an inch of the page
SMALL_SHARE = 8.0  # percent; parts below bear no name


@styled
def accuracy(table: pd.DataFrame, quantity: str) -> Figure:
    """One picture per parameter, both axes logarithmic: error in a quantity against processor time.

    table: of accuracy.errors.accuracy. Filled: on the Pareto front of the parameter; ring: today's setting;
    dotted: what the reference leaves; triangle: an error of zero, below all others.
    """
    rows = table[(table["quantity"] == quantity) & table.error.notna()]
    parameters = list(dict.fromkeys(rows.parameter))
    figure, axes = panels(len(parameters), 1.9, extra=0.9)
    for ax, parameter in zip(axes, parameters):
        _curve(ax, rows[rows.parameter == parameter].reset_index(drop=True))
        ax.set_title(parameter.replace("_", " "))
    figure.supxlabel("processor time of what the setting touches (s)", fontsize=9)
    figure.supylabel(
        f"error of {quantity.rpartition('_')[0].replace('_', ' ')} ({unit_of(quantity)})", fontsize=9
    )
    figure.legend(handles=_legend(), ncols=3, loc="outside upper center")
    return figure


def unit_of(quantity: str) -> str:
    """The unit in a quantity's name."""
    return UNITS.get(quantity.rpartition("_")[2], "-")


def _curve(ax: Axes, rows: pd.DataFrame) -> None:
    """The values of one parameter, from draft to reference."""
    above = rows.error[rows.error > 0]
    lowest = NOTHING * float(above.min()) if len(above) else 1.0
    drawn = rows.error.clip(lower=lowest)
    seconds = rows.seconds.clip(lower=1e-3)
    front = on_front(rows.seconds, rows.error)
    ax.plot(seconds, drawn, color=QUIET, lw=0.8, zorder=1)
    ax.errorbar(
        seconds,
        drawn,
        xerr=rows.seconds_spread.clip(upper=0.9 * seconds),
        yerr=rows.noise.clip(upper=0.9 * drawn),
        fmt="none", ecolor=QUIET, elinewidth=0.8, zorder=2,
    )  # fmt: skip
    for place, row in rows.iterrows():
        x, y = seconds[place], drawn[place]
        fill = BLUE if front[place] else "white"
        ax.plot(x, y, "v" if row.error <= 0 else "o", color=BLUE, mfc=fill, zorder=3)
        if row.today:
            ax.plot(x, y, "o", ms=11, mfc="none", mec=VERMILION, mew=1.6, zorder=4)
    if rows.left.max() > 0:
        ax.axhline(rows.left.max(), color=INK, lw=0.8, ls=":", zorder=1)
    ax.set(xscale="log", yscale="log")
    ax.margins(0.16)
    middle = float(np.exp(np.log(seconds).mean()))
    low, high = ax.get_xlim()
    ax.set_xlim(min(low, middle / LEAST_SPAN), max(high, middle * LEAST_SPAN))
    _plain_ticks(ax)


def _plain_ticks(ax: Axes) -> None:
    """At most four ticks on an axis, as plain numbers."""
    for axis in (ax.xaxis, ax.yaxis):
        low, high = sorted(axis.get_view_interval())
        decades = np.log10(high / low)
        axis.set_major_locator(LogLocator(subs=(1, 2, 5) if decades < 1.5 else (1,), numticks=5))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


def _legend() -> list[Line2D]:
    return [
        Line2D([], [], ls="", marker="o", color=BLUE, label="on the Pareto front"),
        Line2D([], [], ls="", marker="o", color=BLUE, mfc="white", label="not"),
        Line2D([], [], ls="", marker="v", color=BLUE, label="none that is known"),
        Line2D([], [], color=INK, lw=0.8, ls=":", label="left by the reference"),
        Line2D([], [], ls="", marker="o", ms=10, mfc="none", mec=VERMILION, mew=1.6, label="today's setting"),
    ]


@styled
def orders(table: pd.DataFrame) -> Figure:
    """A line per parameter and quantity: p of error ~ size^p, q of seconds ~ size^-q, with standard errors.

    table: of accuracy.errors.orders. Without bar: too few points for an error.
    """
    table = table.iloc[::-1].reset_index(drop=True)
    figure = new_figure(1.0 + 0.19 * max(len(table), 1))
    left, right = figure.subplots(1, 2, sharey=True)
    place = np.arange(len(table))
    for ax, name, colour in ((left, "order", BLUE), (right, "exponent", ORANGE)):
        ax.errorbar(table[name], place, xerr=table[f"{name}_se"], fmt="o", color=colour, elinewidth=1.2)
        ax.axvline(0, color=INK, lw=0.8)
        ax.grid(False, axis="y")
    names = [f"{row.parameter.replace('_', ' ')}: {row.quantity}" for row in table.itertuples()]
    left.set_yticks(place, names)
    left.set(title="order of convergence", xlabel="p of error ~ size$^p$")
    right.set(title="exponent of cost", xlabel="q of seconds ~ size$^{-q}$")
    left.set_xlim(*ORDERS_SHOWN)
    left.margins(y=0.02)
    return figure


@styled
def memory(table: pd.DataFrame) -> Figure:
    """A line per parameter: the largest memory of each value's job, dots growing from draft to reference.

    table: of accuracy.errors.accuracy. Ring: today's setting.
    """
    rows = table[table.parameter != CHAIN].drop_duplicates(["parameter", "value"])
    parameters = list(dict.fromkeys(rows.parameter))[::-1]
    figure = new_figure(0.9 + 0.24 * max(len(parameters), 1))
    ax = figure.subplots()
    for place, parameter in enumerate(parameters):
        values = rows[rows.parameter == parameter]
        ax.plot(values.memory_mb, np.full(len(values), place), color=QUIET, lw=0.8, zorder=1)
        ax.scatter(
            values.memory_mb, np.full(len(values), place), s=np.linspace(8, 40, len(values)), color=BLUE
        )
        today = values[values.today.astype(bool)]
        ax.plot(today.memory_mb, np.full(len(today), place), "o", ms=10, mfc="none", mec=VERMILION, mew=1.4)
    ax.set_yticks(range(len(parameters)), [parameter.replace("_", " ") for parameter in parameters])
    ax.set(xlabel="largest memory of the job (MB)", xlim=(0, None))
    ax.grid(False, axis="y")
    return figure


@styled
def budget(table: pd.DataFrame) -> Figure:
    """A bar per quantity: shares of the squared error by parameter; beside it the total and the next step.

    table: of accuracy.error_budget.budget.
    """
    quantities = list(dict.fromkeys(table["quantity"]))[::-1]
    figure = new_figure(0.7 + 0.62 * max(len(quantities), 1))
    ax, words = figure.subplots(1, 2, sharey=True, width_ratios=(5, 4))
    for place, quantity in enumerate(quantities):
        rows = table[table["quantity"] == quantity]
        _stack(ax, place, rows)
        words.text(0, place, _words(rows), va="center", fontsize=SMALLEST)
    ax.set_yticks(range(len(quantities)), [name.replace("_", " ") for name in quantities])
    ax.set(xlim=(0, 100), xlabel="share of the squared error (%)", title="where the error comes from")
    ax.grid(False, axis="y")
    words.set(xlim=(0, 1), title="error today, and the best next step")
    words.set_axis_off()
    words.set_title("error today, and the best next step")
    return figure


def _stack(ax: Axes, place: int, rows: pd.DataFrame) -> None:
    """The shares of one quantity, the largest first."""
    start = 0.0
    for number, row in enumerate(rows.itertuples()):
        colour = SERIES[number] if number < SHOWN else QUIET
        ax.barh(place, row.share_percent, left=start, color=colour, height=0.55, edgecolor="white", lw=0.6)
        if row.share_percent >= SMALL_SHARE:
            name = row.parameter.replace("_", " ")
            room = int(row.share_percent / 100 * WIDTH * LETTERS)
            name = name if len(name) <= room else f"{name[: max(room - 1, 1)]}…"
            ax.text(
                start + row.share_percent / 2,
                place,
                name,
                ha="center",
                va="center",
                fontsize=SMALLEST,
                color="white",
            )
        start += row.share_percent


def _words(rows: pd.DataFrame) -> str:
    """Total error, and the step that lowers it most per second."""
    first, step = rows.iloc[0], rows[rows["next"]]
    total = f"{first.total_error:.2g} {unit_of(first['quantity'])}".removesuffix(" -")
    if step.empty:
        return f"{total}; no step lowers it"
    best = step.iloc[0]
    return (
        f"{total}\n{best.parameter.replace('_', ' ')} {best.value} to {best.step_to}: "
        f"{best.error_after:.2g} for {best.seconds_more:+.1f} s"
    )
