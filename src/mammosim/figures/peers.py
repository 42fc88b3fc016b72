"""Processor time of several programs for the same problems, and X-ray tasks beside their targets."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from mammosim.core.errors import MissingResult
from mammosim.figures.series import add_legend, colours, panels, some
from mammosim.figures.style import INK, QUIET, new_figure, styled
from mammosim.study.peers.summary import FOLLOWED, OURS

LIMITS = {"seconds": "at most", "histories_per_s": "at least"}
THOUSANDS = np.array([20, 50, 100, 200, 500])


@styled
def processor_time(table: pd.DataFrame) -> Figure:
    """Processor seconds against unknowns, one picture per case, one line per program, ours in black.

    table: rows (case, program, unknowns, cpu_s, outcome); what did not converge is left out, and so are cases
    that only one program solved. Raises MissingResult where no case is left.
    """
    table = table[table.outcome == "converged"].sort_values("unknowns", kind="stable")
    solved = table.groupby("case", sort=False).program.nunique()
    cases = [case for case in dict.fromkeys(table.case) if solved[case] > 1]
    if not cases:
        raise MissingResult("no case was solved by two programs; their table says why")
    programs = [name for name in dict.fromkeys(table.program) if name != OURS]
    colour = {OURS: INK, **colours(programs)}
    figure, axes = panels(len(cases), 2.1, extra=0.7, sharex=True, sharey=True)
    lines = {}
    for ax, case in zip(axes, cases):
        for name, part in table[table.case == case].groupby("program"):
            width = 2.4 if name == OURS else 1.4
            (lines[name],) = ax.plot(part.unknowns, part.cpu_s, "o-", color=colour[name], lw=width)
        ax.set(xscale="log", yscale="log", title=case.replace("_", " ").replace(" with", "\nwith"))
        ax.set_xticks(THOUSANDS * 1000, [f"{n:g}" for n in THOUSANDS])
        ax.xaxis.set_minor_locator(NullLocator())
    figure.supxlabel("unknowns (thousands)", fontsize=9)
    figure.supylabel("processor time (s)", fontsize=9)
    for name, line in lines.items():
        line.set_label(name.replace("_", " "))
    handles = [lines[name] for name in colour if name in lines]
    add_legend(figure, some(handles, "programs"), loc="outside upper center")
    return figure


@styled
def tasks(table: pd.DataFrame, targets: pd.DataFrame) -> Figure:
    """Seconds, and histories per second, of every program (ours in black), a line per task; bars: the goals.

    table: rows (task, kind, program, seconds, histories_per_s, outcome); targets: rows (what, task, target).
    """
    table = table[table.outcome == "converged"]
    programs = [name for name in dict.fromkeys(table.program) if name != OURS]
    colour = {OURS: INK, **colours(programs)}
    rated = table.kind == FOLLOWED
    parts = {"seconds": table[~rated], "histories_per_s": table[rated]}
    heights = [max(part.task.nunique(), 1) for part in parts.values()]
    figure = new_figure(1.3 + 0.36 * sum(heights))
    axes = figure.subplots(2, 1, height_ratios=heights)
    for ax, (column, part) in zip(axes, parts.items()):
        _lines(ax, part, column, colour)
        _targets(ax, part, targets[targets.what == column], LIMITS[column])
    axes[0].set(xscale="log", xlabel="processor time (s)")
    axes[1].set_xlim(0, 1.1 * axes[1].get_xlim()[1])
    axes[1].set_xlabel("histories per processor-second")
    handles = {line.get_label(): line for ax in axes for line in ax.lines if line.get_label()[0] != "_"}
    add_legend(figure, some(list(handles.values()), "programs"), ncols=5, loc="outside upper center")
    return figure


def _lines(ax: Axes, part: pd.DataFrame, column: str, colour: dict[str, str]) -> None:
    names = list(dict.fromkeys(part.task))
    for program, rows in part.groupby("program", sort=False):
        y = [names.index(task) for task in rows.task]
        size = 8 if program == OURS else 6
        ax.plot(
            rows[column],
            y,
            "o",
            ms=size,
            color=colour[str(program)],
            label=str(program).replace("_", " "),
            zorder=3,
        )
    ax.set_yticks(range(len(names)), [name.replace("_", " ") for name in names])
    ax.set_ylim(len(names) - 0.5, -0.5)


def _targets(ax: Axes, part: pd.DataFrame, targets: pd.DataFrame, limit: str) -> None:
    """A bar where each task should end."""
    names = list(dict.fromkeys(part.task))
    for row in targets[targets.task.isin(names)].itertuples():
        target, y = float(str(row.target).removeprefix(limit)), names.index(row.task)
        ax.plot([target, target], [y - 0.35, y + 0.35], color=QUIET, lw=2.5, label="_target")
