"""The one style of every figure: sizes, fonts, and colours that colour-blind readers can tell apart."""

from collections.abc import Callable, Mapping
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from mammosim.core.labels import Label
from mammosim.figures.ticks import DPI, keep_names_apart

P = ParamSpec("P")
R = TypeVar("R")

WIDTH = 6.7  # inches, 17 cm: the text width of a printed page
SMALLEST = 8.0  # points of a letter, at that width
TALLEST = 100.0  # inches of a figure; a picture holds 65536 pixels
INK = "#22272e"
QUIET = "#8a939e"
# Okabe & Ito 2008: eight colours that stay distinct for all common kinds of colour blindness.
BLUE, ORANGE, GREEN, VERMILION = "#0072b2", "#e69f00", "#009e73", "#d55e00"
PURPLE, SKY = "#cc79a7", "#56b4e9"
SERIES = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)

SEQUENTIAL = "viridis"
TISSUE_COLOURS: Mapping[Label, str] = {
    Label.AIR: "#ffffff",
    Label.ADIPOSE: "#f3d27a",
    Label.GLANDULAR: "#b5487f",
    Label.SKIN: "#e8a98a",
    Label.MUSCLE: "#7a2f33",
    Label.THORAX: "#9aa5b1",
    Label.MARKER: "#009e73",
    Label.LESION: "#0072b2",
}
STYLE: Mapping[str, str | float | bool] = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.titlesize": 8.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9,
    "axes.edgecolor": QUIET,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e4e8ec",
    "grid.linewidth": 0.7,
    "lines.linewidth": 1.8,
    "lines.markersize": 5.5,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "text.color": INK,
    "svg.hashsalt": "mammosim",
}


def styled(draw: Callable[P, R]) -> Callable[P, R]:
    """Draw with this style, whatever the settings of the session; names of ticks do not overlap."""

    @wraps(draw)
    def drawn(*args: P.args, **kwargs: P.kwargs) -> R:
        settings: Any = {**mpl.rcParamsDefault, "backend": "agg", **STYLE}
        with mpl.rc_context(settings):
            result = draw(*args, **kwargs)
            if isinstance(result, Figure):
                letter_panels(result)
                keep_names_apart(result)
            return result

    return drawn


def new_figure(height: float, *, width: float = WIDTH) -> Figure:
    """An empty figure, inches, TALLEST at most."""
    return Figure(figsize=(width, min(height, TALLEST)), dpi=DPI, layout="constrained")


def letter_panels(figure: Figure) -> None:
    """A letter before the title of each panel, where there are several: a, b ... z, aa, ab ...

    Axes without data are no panels, nor are scales of colours and second scales.
    """
    panels: dict[Any, Axes] = {}
    for ax in figure.axes:
        if ax.has_data() and ax.get_visible() and ax.get_subplotspec() is not None:
            panels.setdefault(ax.get_subplotspec(), ax)
    for number, ax in enumerate(panels.values() if len(panels) > 1 else ()):
        first, last = divmod(number, 26)
        letter = (chr(ord("a") + first - 1) if first else "") + chr(ord("a") + last)
        ax.set_title(f"{letter}  {ax.get_title(loc='left')}".strip())


def picture_axes(ax: Axes) -> None:
    """Axes of a picture in mm: no grid, no spines, equal scales."""
    ax.grid(False)
    ax.set_aspect("equal")
    ax.set_anchor("C")
    for spine in ax.spines.values():
        spine.set_visible(False)
    ax.tick_params(length=2, color=QUIET)


BAR_ROOM_MM = 25.0  # of a body


def scale_bar(ax: Axes, length_mm: float = 50.0, *, colour: str = INK, room_mm: float = 0.0) -> None:
    """A bar of known length at the lower left, in place of axes; its text is legible on light and dark.

    room_mm: that the axes grow by below what they show, where the bar would lie on it.
    """
    ax.set_axis_off()
    (x0, x1), (y0, y1) = ax.get_xlim(), ax.get_ylim()
    y0 -= room_mm if y1 > y0 else -room_mm
    ax.set_ylim(y0, y1)
    x, y = x0 + 0.04 * (x1 - x0), y0 + 0.04 * (y1 - y0)
    sign = 1 if x1 > x0 else -1
    ax.plot([x, x + sign * length_mm], [y, y], color=colour, lw=2, solid_capstyle="butt")
    ax.annotate(
        f"{length_mm:g} mm",
        (x + sign * length_mm / 2, y),
        xytext=(0, 3),
        textcoords="offset points",
        ha="center",
        va="bottom",
        fontsize=SMALLEST,
        color=colour,
        path_effects=[withStroke(linewidth=1.5, foreground="white" if colour == INK else INK)],
    )
