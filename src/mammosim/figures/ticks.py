"""Names of ticks that do not run into each other, however many there are."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis, XAxis, YAxis
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullFormatter

DPI = 160  # of a figure, as it is laid out
GAP = 1.1  # of the room that a name takes
LINE_HEIGHT = 1.2  # of the size of its letters
# Numbers of a decade that have a name, where an axis shows less than so many decades.
DECADES: Mapping[float, tuple[float, ...]] = {
    0.4: tuple(range(1, 10)), 1.1: (1, 2, 3, 5, 7), 2.0: (1, 2, 5), np.inf: (1,)
}  # fmt: skip
LEVEL_DEGREES = 5.0  # names that are turned by less lie one beside the other
SHORT = 34  # letters of a label


def written(name: object) -> str:
    """A name that a person has given, as it is to be read: a dollar begins no formula, and it has an end."""
    words = str(name) if len(str(name)) <= SHORT else f"{str(name)[:SHORT]}…"
    return words.replace("$", r"\$")


def plain_log(axis: Axis) -> None:
    """A logarithmic scale with plain numbers, as many in a decade as its view has room for."""
    low, high = sorted(axis.get_view_interval())
    decades = float(np.log10(high / low)) if 0 < low < high else 1.0
    subs = next(subs for most, subs in DECADES.items() if decades < most)
    axis.set_major_locator(LogLocator(subs=subs, numticks=7))
    axis.set_major_formatter(
        FuncFormatter(lambda value, _: np.format_float_positional(value, precision=12, trim="-"))
    )
    axis.set_minor_formatter(NullFormatter())


def keep_names_apart(figure: Figure) -> None:
    """Turn names of ticks that overlap upright; where they still do, name some of them, and say how many.

    All ticks stay. Only ticks that a figure has placed itself are looked at.
    """
    every: list[Axis] = [axis for ax in figure.axes for axis in (ax.xaxis, ax.yaxis)]
    axes = [axis for axis in every if _is_named(axis)]
    if not axes:
        return
    figure.draw_without_rendering()
    turned = [each for each in axes if _are_level(each) and isinstance(each, XAxis) and _too_close(each)]
    if turned:
        # What stands upright takes its room from a figure that is so much higher.
        figure.set_figheight(figure.get_figheight() + max(map(_room, turned)) / GAP / DPI)
        for each in turned:
            each.set_tick_params(rotation=90)
        figure.draw_without_rendering()
    for axis in axes:
        if _too_close(axis):
            _name_some(axis)


def _is_named(axis: Axis) -> bool:
    return isinstance(axis.get_major_locator(), FixedLocator) and len(axis.get_majorticklocs()) > 1


def _shown(axis: Axis) -> dict[float, str]:
    """The names that can be read, by where their ticks are."""
    low, high = sorted(axis.get_view_interval())
    ticks = [tick for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
    return {
        float(tick.get_loc()): tick.label1.get_text()
        for tick in ticks
        if tick.label1.get_visible() and tick.label1.get_text() and axis.get_visible()
    }


def _are_level(axis: Axis) -> bool:
    return abs(axis.get_major_ticks()[0].label1.get_rotation()) < LEVEL_DEGREES


def _pixels(axis: Axis, places: list[float]) -> np.ndarray:
    """Where ticks are along their axis (n,), pixels."""
    ax: Axes = axis.axes
    along = 0 if isinstance(axis, XAxis) else 1
    points = np.zeros((len(places), 2))
    points[:, along] = places
    transform = ax.get_xaxis_transform() if along == 0 else ax.get_yaxis_transform()
    pixels: np.ndarray = transform.transform(points)[:, along]
    return pixels


def _room(axis: Axis) -> float:
    """What the largest name takes along its axis, pixels."""
    names = [tick.label1 for tick in axis.get_major_ticks() if tick.label1.get_text()]
    rotation = np.radians(names[0].get_rotation())
    boxes = [name.get_window_extent() for name in names]
    if isinstance(axis, YAxis):
        return GAP * max(box.height for box in boxes)
    if _are_level(axis):
        return GAP * max(box.width for box in boxes)
    lines = max(name.get_text().count("\n") + 1 for name in names)
    height = lines * LINE_HEIGHT * float(names[0].get_fontsize()) * DPI / 72
    # Names that lean lie one behind the other: their distance across the lines of text is what counts.
    return float(GAP * height / abs(np.sin(rotation)))


def _too_close(axis: Axis) -> bool:
    shown = _shown(axis)
    return len(shown) > 1 and bool(np.diff(np.sort(_pixels(axis, list(shown)))).min() < _room(axis))


def _name_some(axis: Axis) -> None:
    """Leave out the names that have no room beside the last one that has."""
    shown = _shown(axis)
    room, last, kept = _room(axis), -np.inf, set()
    places = sorted(shown)
    for pixel, place in zip(_pixels(axis, places), places):
        if abs(pixel - last) >= room:
            kept.add(place)
            last = pixel
    ticks = [float(place) for place in axis.get_majorticklocs()]
    axis.set_ticks(ticks, [shown[place] if place in kept else "" for place in ticks])
    if not all(_is_number(name) for name in shown.values()):
        label = axis.get_label().get_text()
        axis.set_label_text(f"{label}\n({len(kept)} of {len(shown)} named)".strip())


def _is_number(name: str) -> bool:
    try:
        float(name)
    except ValueError:
        return False
    return True
