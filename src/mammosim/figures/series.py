"""Any number of series in one figure: their colours and marks, panels, and a legend that has room.

Up to MOST of them are told apart by colours and marks that differ. More take their colours from a continuous
scale, in their order, and a legend of more than LISTED names a part of them, evenly spaced, and says so.
"""

from collections.abc import Hashable, Iterable, Sequence
from typing import Any, TypeVar

import numpy as np
from matplotlib import colormaps
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from mammosim.figures.style import QUIET, SEQUENTIAL, SERIES, WIDTH, new_figure

Name = TypeVar("Name", bound=Hashable)

MOST = len(SERIES)
MARKERS = ("o", "s", "D", "^", "v", "P")
LINES = ("-", "--", ":", "-.")
COLUMNS = 2  # of panels: more are too small to read on a phone
PALEST = 0.92  # of the scale of colours: what lies beyond is too pale on white
LISTED, SAMPLE = 24, 9  # names of a legend at most, and those of more that are taken from them
ROW, ROWS = 0.17, 4  # inches of a row of a legend; a figure has room for so many
LETTER, HANDLE = 0.063, 0.55  # inches, of a legend


def colours(names: Iterable[Name]) -> dict[Name, str]:
    """A colour for each name, in their order."""
    each = list(dict.fromkeys(names))
    if len(each) <= MOST:
        return dict(zip(each, SERIES, strict=False))
    scale = colormaps[SEQUENTIAL](np.linspace(0, PALEST, len(each)))
    return {name: to_hex(colour) for name, colour in zip(each, scale, strict=True)}


def markers(names: Iterable[Name]) -> dict[Name, str]:
    """A mark for each name: of MARKERS; of more the same for all, which colours tell apart."""
    each = list(dict.fromkeys(names))
    few = len(each) <= len(MARKERS)
    return {name: MARKERS[number if few else 0] for number, name in enumerate(each)}


def numbered(names: Iterable[Name]) -> dict[Name, str]:
    """A mark for each name where no colour tells them apart: of MARKERS; of more their numbers."""
    each = list(dict.fromkeys(names))
    few = len(each) <= len(MARKERS)
    return {name: MARKERS[n] if few else f"${n + 1}$" for n, name in enumerate(each)}


def lines(names: Iterable[Name]) -> dict[Name, dict[str, Any]]:
    """Style and width of a line for each name: of LINES, or a thin one for all where there are more."""
    each = list(dict.fromkeys(names))
    if len(each) > len(LINES):
        return {name: {"ls": "-", "lw": 0.6, "alpha": 0.6} for name in each}
    return {name: {"ls": line, "lw": 1.3} for name, line in zip(each, LINES, strict=False)}


def line_handles(names: Iterable[str], what: str) -> list[Line2D]:
    """What lines() gives, for a legend; what: the names' noun in the plural."""
    styles = lines(names)
    if len(styles) > len(LINES):
        return [Line2D([], [], color=QUIET, lw=0.6, label=f"{len(styles)} {what}, a thin line each")]
    return [Line2D([], [], color=QUIET, ls=style["ls"], label=name) for name, style in styles.items()]


def some(handles: Sequence[Artist], what: str) -> list[Artist]:
    """Up to LISTED handles; of more SAMPLE, evenly spaced, behind a line that says how many there are."""
    if len(handles) <= LISTED:
        return list(handles)
    at = np.linspace(0, len(handles) - 1, SAMPLE).round().astype(int)
    words = Line2D([], [], ls="", label=f"{len(handles)} {what}, {SAMPLE} named:")
    return [words, *(handles[k] for k in at)]


def add_legend(
    figure: Figure,
    handles: Sequence[Artist],
    *,
    ncols: int = 4,
    loc: Any = "outside lower center",
    **options: Any,
) -> None:
    """A legend beside the axes, for which the figure grows where it has more than ROWS rows."""
    labels = [str(handle.get_label()) for handle in handles]
    if len(handles) > MOST:
        widest = LETTER * max(map(len, labels)) + HANDLE
        ncols = max(1, min(ncols, int(WIDTH / widest)))
    rows = -(-len(handles) // ncols)
    figure.set_figheight(figure.get_figheight() + ROW * max(rows - ROWS, 0))
    figure.legend(handles, labels, loc=loc, ncols=ncols, **options)


def labelled(ax: Axes) -> list[Artist]:
    """What is drawn in axes and has a name."""
    return list(ax.get_legend_handles_labels()[0])


def panels(number: int, height: float, *, extra: float = 0.0, **shared: Any) -> tuple[Figure, np.ndarray]:
    """A figure of panels in rows of COLUMNS, and its axes (number,); what is left over is off.

    height, extra: inches of a row, and beside them.
    """
    wide = max(1, min(number, COLUMNS))
    rows = max(1, -(-number // wide))
    figure = new_figure(extra + height * rows)
    axes = figure.subplots(rows, wide, squeeze=False, **shared).ravel()
    for ax in axes[number:]:
        ax.set_axis_off()
    _number_below(axes[max(number - wide, 0) : number])
    return figure, axes[:number]


def blocks(
    number: int, of: int, height: float, *, extra: float = 0.0, **shared: Any
) -> tuple[Figure, np.ndarray]:
    """A figure of blocks, each of `of` panels in rows of COLUMNS, and their axes (number, of).

    height, extra: inches of a row, and beside them. What is left over is off.
    """
    wide = min(of, COLUMNS)
    rows = -(-of // wide)
    figure = new_figure(extra + height * rows * number)
    axes = figure.subplots(rows * number, wide, squeeze=False, **shared).reshape(number, rows * wide)
    for ax in axes[:, of:].ravel():
        ax.set_axis_off()
    _number_below(axes[-1, max(of - wide, 0) : of])
    return figure, axes[:, :of]


def _number_below(axes: np.ndarray) -> None:
    """Ticks of the lowest panel of each column have numbers, also where panels share them."""
    for ax in axes:
        ax.tick_params(labelbottom=True)
