"""Processor time of several programs for the same problems."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from mammosim.figures.style import INK, QUIET, SERIES, new_figure, styled
from mammosim.study.peers.aims import OURS

THOUSANDS = np.array([20, 50, 100, 200, 500])


@styled
def processor_time(table: pd.DataFrame) -> Figure:
    """Processor seconds against unknowns, one picture per case, one line per program, ours in black.

    table: rows (case, program, unknowns, cpu_s, outcome); what did not converge is left out, and so are cases
    that only one program solved.
    """
    table = table[table.outcome == "converged"].sort_values("unknowns", kind="stable")
    solved = table.groupby("case", sort=False).program.nunique()
    cases = [case for case in dict.fromkeys(table.case) if solved[case] > 1]
    programs = [name for name in dict.fromkeys(table.program) if name != OURS]
    colours = {OURS: INK, **{name: (*SERIES, QUIET)[i % 7] for i, name in enumerate(programs)}}
    columns = min(3, len(cases))
    rows = -(-len(cases) // columns)
    figure = new_figure(0.7 + 2.1 * rows)
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    lines = {}
    for ax, case in zip(axes, cases):
        for name, part in table[table.case == case].groupby("program"):
            width = 2.4 if name == OURS else 1.4
            (lines[name],) = ax.plot(part.unknowns, part.cpu_s, "o-", color=colours[name], lw=width)
        ax.set(xscale="log", yscale="log", title=case.replace("_", " ").replace(" with", "\nwith"))
        ax.set_xticks(THOUSANDS * 1000, [f"{n:g}" for n in THOUSANDS])
        ax.xaxis.set_minor_locator(NullLocator())
    for ax in axes[len(cases) :]:
        ax.set_axis_off()
    figure.supxlabel("unknowns (thousands)", fontsize=9)
    figure.supylabel("processor time (s)", fontsize=9)
    order = [name for name in colours if name in lines]
    labels = [name.replace("_", " ") for name in order]
    figure.legend([lines[name] for name in order], labels, ncols=4, loc="outside upper center")
    return figure
