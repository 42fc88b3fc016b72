"""A picture that says why another one is not there."""

import textwrap

from matplotlib.figure import Figure

from mammosim.figures.style import QUIET, VERMILION, new_figure, styled

LINE = 95  # characters


@styled
def notice(reason: str) -> Figure:
    """The reason, in the place of a figure whose results are missing."""
    lines = textwrap.wrap(reason, LINE)
    figure = new_figure(0.9 + 0.17 * len(lines))
    figure.text(0.02, 0.93, "This figure is missing.", color=VERMILION, weight="bold", va="top")
    figure.text(0.02, 0.70, "\n".join(lines), color=QUIET, fontsize=8, va="top", parse_math=False)
    return figure
