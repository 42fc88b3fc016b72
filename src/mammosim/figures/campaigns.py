"""What a campaign answers, against what it varies: any number of values, by colours and facets."""

from collections.abc import Callable, Iterator, Sequence
from itertools import combinations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from mammosim.figures.series import COLUMNS
from mammosim.figures.style import BLUE, INK, ORANGE, QUIET, SEQUENTIAL, WIDTH, new_figure, styled
from mammosim.figures.ticks import SHORT, written
from mammosim.study.campaigns.axes import LOG
from mammosim.study.campaigns.campaign import Campaign
from mammosim.study.campaigns.table import ERROR, SUBJECT
from mammosim.study.report.pages import heading

INTERVAL = (0.1, 0.9)  # quantiles between which 80 % of the points lie
FACETS = 9  # panels at most: what is more is a mean over the last names
PAIRS = 6
BINS = 12  # of a setting that a design samples
DENSE = 2000  # points from which they are pixels in a vector file
TICKS = 12  # names along an axis; of more every second, third...
CONFIDENCE = 1.96  # standard errors of a 95 % interval
FEW = 6  # values of a map that each have room for theirs


def label(key: str) -> str:
    """A setting as an axis names it: the last words of its key, with the unit."""
    key = key.replace("youngs_modulus", "Young's_modulus")
    words = heading(key.removeprefix("load.").removeprefix("tissues.").replace(".", " ").replace(" ", "_"))
    return words if len(words) <= SHORT else f"…{words[-SHORT:]}"


def varied(campaign: Campaign, table: pd.DataFrame) -> list[str]:
    """The columns that differ between points: settings, then whose breast."""
    return [name for name in (*campaign.keys, *SUBJECT) if table[name].nunique() > 1]


def is_line(campaign: Campaign, key: str) -> bool:
    """Whether a setting has numbers to draw along an axis."""
    return key not in SUBJECT and next(each for each in campaign.axes if each.key == key).is_numeric


def is_log(campaign: Campaign, key: str) -> bool:
    """Whether its axis is logarithmic."""
    return any(each.key == key and each.scale == LOG for each in campaign.axes)


@styled
def against(campaign: Campaign, table: pd.DataFrame, name: str) -> Figure:
    """One answer against each setting: every point, and the middle and 80 % of the points at each value."""
    keys = varied(campaign, table)
    across = min(COLUMNS, len(keys))
    down = -(-len(keys) // across)
    figure = new_figure(2.3 * down, width=WIDTH if across > 1 else 0.6 * WIDTH)
    panels = figure.subplots(down, across, squeeze=False, sharey=True).ravel()
    for ax, key in zip(panels, keys):
        _against(ax, campaign, table, key, name)
    for ax in panels[len(keys) :]:
        ax.remove()
    for ax in panels[::across]:
        ax.set_ylabel(heading(name))
    return figure


def _against(ax: Axes, campaign: Campaign, table: pd.DataFrame, key: str, name: str) -> None:
    numeric = is_line(campaign, key)
    names = list(dict.fromkeys(map(str, table[key])))
    place = table[key] if numeric else table[key].astype(str).map({n: i for i, n in enumerate(names)})
    there = table[name].notna()
    ax.plot(
        place[there],
        table[name][there],
        ".",
        color=QUIET,
        ms=2.5,
        alpha=max(0.05, min(0.6, 60 / len(table))),
        rasterized=len(table) > DENSE,
    )
    grouped = table[name][there].groupby(_binned(place[there]) if numeric else place[there])
    low, middle, high = (grouped.quantile(q) for q in (INTERVAL[0], 0.5, INTERVAL[1]))
    if numeric:
        ax.fill_between(middle.index, low, high, color=BLUE, alpha=0.18, lw=0)
        ax.plot(middle.index, middle, "-o", color=BLUE, ms=3)
    else:
        ax.errorbar(middle.index, middle, yerr=[middle - low, high - middle], fmt="o", color=BLUE, capsize=3)
        step = -(-len(names) // TICKS)
        words = [written(each) for each in names[::step]]
        ax.set_xticks(range(0, len(names), step), words, rotation=30, ha="right")
        ax.set_xlim(-0.6, len(names) - 0.4)
    if numeric:
        gaps = table[table[name].isna()][key].unique()
        hollow = middle[middle.index.isin(gaps)]
        ax.plot(hollow.index, hollow, "o", color=BLUE, mfc="white", ms=4, label="gaps")
    if is_log(campaign, key):
        _log_ticks(ax.set_xscale, ax.xaxis)
    ax.set_xlabel(label(key))


def _log_ticks(scale: Callable[[str], None], axis: Axis) -> None:
    """A logarithmic axis with plain numbers at 1, 2 and 5 times powers of ten, which have room."""
    scale("log")
    axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def _binned(values: pd.Series) -> pd.Series:
    """The values themselves, or where there are many the middle of those in each of BINS equal groups."""
    if values.nunique() <= max(2 * BINS, 45):
        return values
    group = pd.qcut(values, BINS, duplicates="drop")
    return values.groupby(group, observed=True).transform("median")


@styled
def lines(campaign: Campaign, table: pd.DataFrame, name: str) -> Figure | None:
    """One answer along the setting with most values, coloured by another, a panel per combination of names.

    With 95 % intervals where the answer has an error. None where no setting has numbers.
    """
    keys = varied(campaign, table)
    numeric = sorted((k for k in keys if is_line(campaign, k)), key=lambda k: -table[k].nunique())
    if campaign.design is not None or not numeric:
        return None
    x, *colours = numeric
    panels = list(_facets(table, [key for key in keys if key not in numeric]))
    across = min(COLUMNS, len(panels))
    down = -(-len(panels) // across)
    figure = new_figure(2.5 * down, width=WIDTH if across > 1 or colours else 0.7 * WIDTH)
    axes = figure.subplots(down, across, squeeze=False, sharey=True, sharex=True).ravel()
    norm = _norm(campaign, table, colours[0]) if colours else None
    for ax, (title, rows) in zip(axes, panels):
        _lines(ax, rows, x, name, colours[0] if colours else "", norm)
        ax.set_title(title)
        ax.set_xlabel(label(x))
        if is_log(campaign, x):
            _log_ticks(ax.set_xscale, ax.xaxis)
    for ax in axes[len(panels) :]:
        ax.remove()
    for ax in axes[::across]:
        ax.set_ylabel(heading(name))
    if norm is not None:
        figure.colorbar(
            ScalarMappable(norm, SEQUENTIAL), ax=list(axes[: len(panels)]), label=label(colours[0])
        )
    return figure


def _facets(table: pd.DataFrame, names: Sequence[str]) -> Iterator[tuple[str, pd.DataFrame]]:
    """The rows of each combination of names, with its words; names that would make too many are left out."""
    names = list(names)
    while names and table[names].drop_duplicates().shape[0] > FACETS:
        names.pop()
    if not names:
        yield "", table
        return
    for key, rows in table.groupby(names, sort=False):
        yield ", ".join(map(written, key)), rows


def _lines(ax: Axes, rows: pd.DataFrame, x: str, name: str, colour: str, norm: Normalize | None) -> None:
    from matplotlib import colormaps

    error = f"{name}{ERROR}"
    groups = rows.groupby(colour) if norm is not None else [(None, rows)]
    for value, group in groups:
        shade = BLUE if norm is None or value is None else colormaps[SEQUENTIAL](norm(value))
        mean = group.groupby(x)[name].mean()
        ax.plot(mean.index, mean, "-", color=shade, lw=1.2, marker="." if len(mean) <= 60 else "")
        if error in group:
            # The mean of several points has the error of one over the root of their number.
            each = group.groupby(x)[error]
            spread = CONFIDENCE * np.sqrt(each.apply(lambda e: (e**2).sum())) / each.size()
            ax.fill_between(mean.index, mean - spread, mean + spread, color=shade, alpha=0.25, lw=0)


def _norm(campaign: Campaign, table: pd.DataFrame, key: str) -> Normalize:
    kind = LogNorm if is_log(campaign, key) else Normalize
    return kind(float(table[key].min()), float(table[key].max()))


@styled
def pairs(campaign: Campaign, table: pd.DataFrame, name: str) -> Figure | None:
    """One answer over pairs of settings: means over all others, or every point of a design. None of one."""
    keys = varied(campaign, table)
    shown = list(combinations(sorted(keys, key=lambda k: -table[k].nunique()), 2))[:PAIRS]
    if not shown:
        return None
    across = min(COLUMNS, len(shown))
    down = -(-len(shown) // across)
    figure = new_figure(2.5 * down, width=WIDTH if across > 1 else 0.65 * WIDTH)
    axes = figure.subplots(down, across, squeeze=False).ravel()
    there = table.dropna(subset=[name])
    norm = Normalize(there[name].min(), there[name].max())
    for ax, (one, other) in zip(axes, shown):
        sampled = {one, other} & set(campaign.spans)
        (_scattered if sampled else _map)(ax, campaign, there, one, other, name, norm)
        ax.set(xlabel=label(one), ylabel=label(other))
        ax.grid(False)
    for ax in axes[len(shown) :]:
        ax.remove()
    figure.colorbar(ScalarMappable(norm, SEQUENTIAL), ax=list(axes[: len(shown)]), label=heading(name))
    return figure


def _map(
    ax: Axes, campaign: Campaign, table: pd.DataFrame, one: str, other: str, name: str, norm: Normalize
) -> None:
    """A cell for each pair of values: many numbers along their own scale, few and names side by side."""
    order = {key: list(dict.fromkeys(table[key].sort_values() if is_line(campaign, key) else table[key]))
             for key in (one, other)}  # fmt: skip
    means = table.pivot_table(name, other, one, aggfunc="mean", observed=True)
    means = means.reindex(index=order[other], columns=order[one])
    scaled = {key: is_line(campaign, key) and len(values) > FEW for key, values in order.items()}
    x, y = (
        _edges(values, log=is_log(campaign, key)) if scaled[key] else np.arange(len(values) + 1) - 0.5
        for key, values in order.items()
    )
    ax.pcolormesh(x, y, means.to_numpy(), norm=norm, cmap=SEQUENTIAL, rasterized=True)
    axes = ((one, ax.set_xticks, ax.set_xscale, ax.xaxis), (other, ax.set_yticks, ax.set_yscale, ax.yaxis))
    for key, ticks, scale, axis in axes:
        if not scaled[key]:
            step = -(-len(order[key]) // FEW)
            ticks(range(0, len(order[key]), step), map(_short, order[key][::step]))
        elif is_log(campaign, key):
            _log_ticks(scale, axis)


def _short(value: object) -> str:
    return f"{value:.3g}" if isinstance(value, (int, float)) else written(value)


def _edges(values: Sequence[float], *, log: bool) -> np.ndarray:
    """Between which the cells of rising values lie, half-way to their neighbours; log: in the logarithm."""
    centres = np.log(values) if log else np.asarray(values, float)
    middle = (centres[1:] + centres[:-1]) / 2
    edges = np.concatenate([[2 * centres[0] - middle[0]], middle, [2 * centres[-1] - middle[-1]]])
    return np.exp(edges) if log else edges


def _scattered(
    ax: Axes, campaign: Campaign, table: pd.DataFrame, one: str, other: str, name: str, norm: Normalize
) -> None:
    ax.scatter(
        table[one],
        table[other],
        c=table[name],
        norm=norm,
        cmap=SEQUENTIAL,
        s=9,
        lw=0,
        rasterized=len(table) > DENSE,
    )
    for key, scale, axis in ((one, ax.set_xscale, ax.xaxis), (other, ax.set_yscale, ax.yaxis)):
        if is_log(campaign, key):
            _log_ticks(scale, axis)


@styled
def explained(shares: pd.DataFrame) -> Figure:
    """What part of the variance of each answer each setting explains, with its interval and total, if any."""
    names = list(dict.fromkeys(shares.quantity))
    sizes = [len(shares[shares.quantity == name]) for name in names]
    totals = shares.total.notna().any()
    figure = new_figure(sum(0.19 * size + 0.55 for size in sizes) + 0.3 * totals)
    panels = figure.subplots(len(names), 1, squeeze=False, sharex=True, height_ratios=sizes)[:, 0]
    for ax, name in zip(panels, names):
        rows = shares[shares.quantity == name].reset_index(drop=True)
        place = np.arange(len(rows))
        ax.barh(place, rows.share, color=BLUE, height=0.6, label="share")
        if rows.total.notna().any():
            ax.plot(rows.total, place, "D", color=ORANGE, ms=4, label="in total")
            # An interval of few samples, corrected for its bias, may leave out what it is the interval of.
            reach = [(rows.share - rows.low).clip(lower=0), (rows.high - rows.share).clip(lower=0)]
            ax.errorbar(rows.share, place, xerr=reach, fmt="none", color=INK)
        words = [" x ".join(label(key) for key in setting.split(" x ")) for setting in rows.setting]
        ax.set_yticks(place, words)
        ax.invert_yaxis()
        ax.grid(False, axis="y")
        ax.set_title(heading(name))
    panels[-1].set_xlabel("share of the variance")
    if totals:
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    return figure
