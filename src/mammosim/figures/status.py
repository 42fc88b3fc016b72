"""What a study shows of itself: what its rules cost, and why a figure is missing."""

import textwrap

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from mammosim.figures.style import BLUE, ORANGE, QUIET, SMALLEST, VERMILION, new_figure, styled


@styled
def time_and_memory(table: pd.DataFrame) -> Figure:
    """Seconds of all jobs of each rule together, and the largest memory of one of them.

    table: one row per job, columns rule, s, max_rss (MB), as Snakemake's benchmarks have them.
    """
    rules = table.groupby("rule").agg(seconds=("s", "sum"), memory=("max_rss", "max"), jobs=("s", "size"))
    rules = rules.sort_values("seconds")
    figure = new_figure(0.9 + 0.21 * len(rules))
    time, memory = figure.subplots(1, 2, sharey=True)
    place = np.arange(len(rules))
    bars = time.barh(place, rules.seconds, color=BLUE, height=0.65)
    labels = [f"{s:.0f} s" + (f" ({n} jobs)" if n > 1 else "") for s, n in zip(rules.seconds, rules.jobs)]
    time.bar_label(bars, labels, padding=3, fontsize=SMALLEST)
    time.set_yticks(place, [name.replace("_", " ") for name in rules.index])
    time.set(xlabel="time of all jobs (s)", title="time")
    bars = memory.barh(place, rules.memory, color=ORANGE, height=0.65)
    memory.bar_label(bars, fmt="%.0f", padding=3, fontsize=SMALLEST)
    memory.set(xlabel="largest resident memory (MB)", title="memory")
    for ax in (time, memory):
        ax.margins(x=0.25, y=0.02)
        ax.grid(False, axis="y")
    return figure


LINE = 95  # characters


@styled
def notice(reason: str) -> Figure:
    """The reason, in the place of a figure whose results are missing."""
    lines = textwrap.wrap(reason, LINE)
    figure = new_figure(0.9 + 0.17 * len(lines))
    figure.text(0.02, 0.93, "This figure is missing.", color=VERMILION, weight="bold", va="top")
    figure.text(0.02, 0.70, "\n".join(lines), color=QUIET, fontsize=SMALLEST, va="top", parse_math=False)
    return figure
