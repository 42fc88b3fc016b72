"""Processor time of several programs for X-ray tasks, beside what was aimed at."""

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mammosim.figures.style import INK, QUIET, SERIES, new_figure, styled
from mammosim.study.peers.aims import OURS
from mammosim.study.peers.xray_summary import FOLLOWED

LIMITS = {"seconds": "at most", "histories_per_s": "at least"}


@styled
def tasks(table: pd.DataFrame, aims: pd.DataFrame) -> Figure:
    """Seconds, and histories per second, of every program (ours in black), a line per task; bars: the goals.

    table: rows (task, kind, program, seconds, histories_per_s, outcome); aims: rows (what, task, goal).
    """
    table = table[table.outcome == "converged"]
    programs = [name for name in dict.fromkeys(table.program) if name != OURS]
    colours = {OURS: INK, **{name: (*SERIES, QUIET)[i % 7] for i, name in enumerate(programs)}}
    rated = table.kind == FOLLOWED
    parts = {"seconds": table[~rated], "histories_per_s": table[rated]}
    heights = [max(part.task.nunique(), 1) for part in parts.values()]
    figure = new_figure(1.3 + 0.36 * sum(heights))
    axes = figure.subplots(2, 1, height_ratios=heights)
    for ax, (column, part) in zip(axes, parts.items()):
        _lines(ax, part, column, colours)
        _goals(ax, part, aims[aims.what == column], LIMITS[column])
    axes[0].set(xscale="log", xlabel="processor time (s)")
    axes[1].set_xlim(0, 1.1 * axes[1].get_xlim()[1])
    axes[1].set_xlabel("histories per processor-second")
    handles = {line.get_label(): line for ax in axes for line in ax.lines if line.get_label()[0] != "_"}
    labels = [name.replace("_", " ") for name in handles]
    figure.legend(list(handles.values()), labels, ncols=5, loc="outside upper center")
    return figure


def _lines(ax: Axes, part: pd.DataFrame, column: str, colours: dict[str, str]) -> None:
    names = list(dict.fromkeys(part.task))
    for program, rows in part.groupby("program", sort=False):
        y = [names.index(task) for task in rows.task]
        size = 8 if program == OURS else 6
        ax.plot(rows[column], y, "o", ms=size, color=colours[str(program)], label=str(program), zorder=3)
    ax.set_yticks(range(len(names)), [name.replace("_", " ") for name in names])
    ax.set_ylim(len(names) - 0.5, -0.5)


def _goals(ax: Axes, part: pd.DataFrame, aims: pd.DataFrame, limit: str) -> None:
    """A bar where each task should end."""
    names = list(dict.fromkeys(part.task))
    for row in aims[aims.task.isin(names)].itertuples():
        goal, y = float(str(row.goal).removeprefix(limit)), names.index(row.task)
        ax.plot([goal, goal], [y - 0.35, y + 0.35], color=QUIET, lw=2.5, label="_goal")
