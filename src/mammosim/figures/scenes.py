"""Effects and what they do to the answers of scenes; the answers with and without those that do little."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from mammosim.figures.series import add_legend, labelled
from mammosim.figures.style import BLUE, INK, QUIET, VERMILION, new_figure, styled

LEAST, MOST = 1e-3, 1e1  # of the tolerance, that the colours span


@styled
def effects(table: pd.DataFrame) -> Figure:
    """A cell per effect and answer: change without it over its tolerance; framed what is kept.

    table: of study.scenes.screening. Dark: no answer without it. A dash: the effect does not act on it,
    or what is asked means nothing without it.
    """
    answers = list(table[["scene", "quantity"]].drop_duplicates().itertuples(index=False, name=None))
    names = list(dict.fromkeys(table.effect))
    figure = new_figure(1.9 + 0.27 * len(answers))
    ax = figure.subplots()
    rows = table.set_index(["scene", "quantity", "effect"])
    parts = (rows.change / rows.tolerance).unstack("effect").reindex(index=answers, columns=names)
    shown = ax.imshow(
        parts.clip(LEAST, MOST), cmap="YlGnBu", norm=LogNorm(LEAST, MOST), aspect="auto", interpolation="none"
    )
    for (scene, quantity, effect), row in rows.iterrows():
        place = (names.index(effect), answers.index((scene, quantity)))
        _mark(ax, place, row)
    ax.set_xticks(range(len(names)), [n.replace("_", " ") for n in names], rotation=45, ha="right")
    ax.set_yticks(range(len(answers)), [f"{s.replace('_', ' ')}: {q}" for s, q in answers])
    ax.grid(False)
    figure.colorbar(shown, ax=ax, label="change / tolerance (-)", pad=0.01)
    return figure


def _mark(ax: Axes, place: tuple[int, int], row: pd.Series) -> None:
    """A frame for what is kept; a cross where there is no answer without it, a dash where it is needed."""
    x, y = place
    if row.included:
        ax.add_patch(Rectangle((x - 0.46, y - 0.46), 0.92, 0.92, fill=False, edgecolor=VERMILION, lw=1.4))
    if np.isnan(row.change):
        ax.text(x, y, "x" if "no answer" in row.reason else "–", ha="center", va="center", color=INK)


@styled
def scenes(table: pd.DataFrame) -> Figure:
    """How far the screened answers are from the full ones, and the processor time of both.

    table: study.scenes.answers.rows.
    """
    figure = new_figure(1.3 + 0.26 * len(table))
    apart, time = figure.subplots(1, 2, sharey=True, width_ratios=(3, 2))
    place = np.arange(len(table))[::-1]
    apart.barh(
        place,
        table.difference / table.tolerance,
        height=0.55,
        color=[BLUE if ok else VERMILION for ok in table.within],
    )
    apart.axvline(1.0, color=INK, lw=1)
    apart.set(xlabel="difference to the full model / tolerance (-)", title="answer", xlim=(0, None))
    apart.set_yticks(place, [f"{r.scene.replace('_', ' ')}: {r.quantity}" for r in table.itertuples()])
    time.barh(place + 0.18, table.seconds_full, height=0.32, color=QUIET, label="all effects")
    time.barh(place - 0.18, table.seconds_screened, height=0.32, color=BLUE, label="those that matter")
    time.set(xlabel="processor time (s)", title="time", xlim=(0, None))
    add_legend(figure, labelled(time))
    for ax in (apart, time):
        ax.grid(False, axis="y")
    return figure
