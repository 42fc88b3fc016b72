"""How far compression of one breast can be reduced before it costs more than a stated loss.

Thickness t rises from the standard's. There every loss is 0; at the thicknesses computed with level plates it
has an interval, and in between it lies between chords, of the upper and of the lower ends; with s from 0 to 1
between two of them, the lower end of a dose D is that of

    ln D = ln D0 + (s + s^2) / 2 ln(D1 / D0),

which rises half as steeply at first as on average. Compression may be reduced at least until the upper end of
one loss meets its limit, and no further than where a lower one does.
"""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd

from mammosim.chain.conditions import UNDER_GRAVITY
from mammosim.chain.strategies import STANDARD
from mammosim.study.report.pressed_breast import FORCE, PressedBreast, of_breast
from mammosim.study.report.strategy_costs import (
    COSTS,
    DOSE,
    LESS,
    MAY,
    MORE,
    UNKNOWN,
    WORDS,
    LossLimits,
    together,
)

STRATEGIES, BETWEEN = "strategies", "interpolation"
NEARLY_NONE = -99.9  # percent: an interval of photons may reach below it, and no dose is less than none


@dataclass(frozen=True)
class Reach:
    """How far one loss allows, as its intervals have it: `certain` at least, `possible` at most, mm.

    by: STRATEGIES, where nothing is taken in between, or BETWEEN; ended: whether a limit is the end, and not
    the thickest that was computed; complete: whether the intervals hold every error of a change. NaN: nothing
    is known.
    """

    certain: float = float("nan")
    possible: float = float("nan")
    by: str = STRATEGIES
    ended: bool = False
    complete: bool = True


def reach(t: np.ndarray, low: np.ndarray, high: np.ndarray, limit: float, *, growing: bool) -> Reach:
    """Of a loss with intervals low to high (n,) percent, at rising thicknesses t (n,) mm from the standard's.

    growing: whether the lower ends in between are those of a dose. Values in between are taken where
    the intervals allow a loss that only rises, or only falls.
    """
    there = np.isfinite(low) & np.isfinite(high)
    t, low, high = t[there], low[there], high[there]
    if len(t) < 2:
        return Reach()
    if not monotone(low, high):
        ends = _last_within(t, high, limit), _last_within(t, low, limit)
        return Reach(*ends, STRATEGIES, bool(high.max() > limit))
    certain = _first_above(t, high, limit)
    # ASSUME: a loss of detectability is between the chords of its intervals: measured of one thickness in
    # between (docs/decisions/answer.md).
    least = np.maximum(low, NEARLY_NONE)
    lower, most = (np.log1p(least / 100), np.log1p(limit / 100)) if growing else (low, limit)
    possible = _first_above(t, lower, most, slow=growing)
    return Reach(certain, max(certain, possible), BETWEEN, bool(certain < t[-1]))


def slow(s: np.ndarray | float) -> np.ndarray | float:
    """The least part of its rise that the logarithm of a dose has after the part s of a way."""
    # ASSUME: with exposure control the dose is convex in the thickness, and rises at first at least half as
    # steeply, in its logarithm, as on average: measured, 0.7 and 1.0 times (docs/decisions/answer.md).
    return s * (1 + s) / 2


def monotone(low: np.ndarray, high: np.ndarray) -> bool:
    """Whether values inside these intervals (n,) can only rise, or only fall."""
    rises = np.all(np.maximum.accumulate(low) <= high)
    falls = np.all(np.minimum.accumulate(high) >= low)
    return bool(rises or falls)


def _first_above(t: np.ndarray, y: np.ndarray, limit: float, *, slow: bool = False) -> float:
    """Where lines through the points, or slow curves, first come above the limit, or the last t."""
    for (t0, y0), (t1, y1) in pairwise(zip(t, y)):
        if y1 > limit:
            part = max(limit - y0, 0.0) / (y1 - y0) if y1 > y0 else 0.0
            s = (np.sqrt(1 + 8 * part) - 1) / 2 if slow else part
            return float(t0 + (t1 - t0) * s)
    return float(t[-1])


def _last_within(t: np.ndarray, y: np.ndarray, limit: float) -> float:
    """The last point before the first one above the limit."""
    above = np.flatnonzero(y > limit)
    return float(t[above[0] - 1] if len(above) else t[-1])


@dataclass(frozen=True)
class Answer:
    """One breast: the row of answer.csv. Thicknesses in mm, forces in N, with the moduli that are X-rayed.

    verdict: LESS, MAY or MORE of what a strategy that was computed costs at best, or UNKNOWN; certain,
    possible: Reach of all losses together, certain NaN where one of them, or its error, is not known;
    complete: whether possible holds every error of the losses that are known; decides: the quantity that
    ends it; less, may_be_less, more, not_known: names of the strategies by what
    they cost; shown: the one that is told; why: what is lacking for an answer.
    """

    volunteer: str
    side: str
    verdict: str = UNKNOWN
    standard_mm: float = float("nan")
    standard_n: float = float("nan")
    standard_low_n: float = float("nan")
    standard_high_n: float = float("nan")
    certain_mm: float = float("nan")
    certain_n: float = float("nan")
    possible_mm: float = float("nan")
    possible_n: float = float("nan")
    complete: bool = True
    decides: str = ""
    by: str = ""
    ended: bool = False
    less: str = ""
    may_be_less: str = ""
    more: str = ""
    not_known: str = ""
    shown: str = ""
    why: str = ""


def answers(
    table: pd.DataFrame,
    known: Mapping[tuple[str, str], PressedBreast],
    limits: LossLimits,
    *,
    asked: Iterable[tuple[str, str]],
    why_not: Mapping[tuple[str, str], str],
) -> list[Answer]:
    """One for each breast that is asked about.

    table: rows of strategy_costs of the breasts known; why_not: why a breast is not among them.
    """
    found = []
    for volunteer, side in asked:
        if (volunteer, side) in known:
            rows = of_breast(table, volunteer, side)
            found.append(_answer(volunteer, side, rows, known[volunteer, side], limits))
        else:
            found.append(Answer(volunteer, side, why=why_not.get((volunteer, side), "it was not pressed")))
    return found


def _answer(
    volunteer: str, side: str, rows: pd.DataFrame, breast: PressedBreast, limits: LossLimits
) -> Answer:
    force = rows[(rows.strategy == STANDARD) & (rows["quantity"] == FORCE)].iloc[0]
    begun: dict[str, Any] = {
        "standard_mm": float(force.thickness_mm), "standard_n": float(force.value),
        "standard_low_n": float(force.low), "standard_high_n": float(force.high),
    }  # fmt: skip
    reduced = rows[rows.thickness_mm > force.thickness_mm]
    if reduced.empty:
        why = "no strategy with less compression than the standard was computed"
        return Answer(volunteer, side, **begun, why=why)
    each = reduced[reduced.costs != ""].groupby("strategy", sort=False).costs
    by_cost: dict[str, list[str]] = {word: [] for word in (LESS, MAY, MORE, UNKNOWN)}
    for name, costs in each:
        by_cost[together(list(costs))].append(str(name))
    best = next(word for word, names in by_cost.items() if names)
    ends = {quantity: _reach(rows, quantity, limits) for quantity in COSTS}
    return Answer(
        volunteer, side, best, **begun, **_together(ends, breast),
        less=" ".join(by_cost[LESS]), may_be_less=" ".join(by_cost[MAY]),
        more=" ".join(by_cost[MORE]), not_known=" ".join(by_cost[UNKNOWN]),
        # The thickest that costs less; where none does, what the least reduction costs.
        shown=_shown(reduced, by_cost[best], thickest=best in (LESS, MAY)),
        why=_lacking(reduced, best),
    )  # fmt: skip


def _shown(reduced: pd.DataFrame, names: list[str], *, thickest: bool) -> str:
    """The thickest or the thinnest of these strategies, of those with level plates where there are any."""
    rows = reduced[reduced.strategy.isin(names)]
    rows = rows[rows.level] if rows.level.any() else rows
    return str(rows.strategy.iloc[rows.thickness_mm.argmax() if thickest else rows.thickness_mm.argmin()])


def _reach(rows: pd.DataFrame, quantity: str, limits: LossLimits) -> Reach:
    """Of one loss, by the strategies with level plates that are no thinner than the standard."""
    limit, sign = COSTS[quantity]
    mine = rows[(rows["quantity"] == quantity) & rows.level].sort_values("thickness_mm")
    mine = mine[mine.thickness_mm >= float(mine.thickness_mm[mine.strategy == STANDARD].iloc[0])]
    ends = mine[["change_low_percent", "change_high_percent"]].to_numpy(float)
    low, high = ends.T if sign > 0 else -ends.T[::-1]
    t = mine.thickness_mm.to_numpy(float)
    found = reach(t, low, high, getattr(limits, limit), growing=quantity == DOSE)
    return replace(found, complete=bool(mine.complete.all()))


def _together(ends: Mapping[str, Reach], breast: PressedBreast) -> dict[str, Any]:
    """The columns certain_mm to ended of all losses together."""
    known = {quantity: end for quantity, end in ends.items() if np.isfinite(end.certain)}
    if not known:
        return {}
    decides = min(known, key=lambda quantity: (known[quantity].certain, known[quantity].possible))
    possible = min(end.possible for end in known.values())
    complete = all(end.complete for end in known.values())
    certain = known[decides].certain if complete and len(known) == len(ends) else float("nan")
    return {
        "certain_mm": certain,
        "certain_n": breast.at(UNDER_GRAVITY, FORCE, certain),
        "possible_mm": possible,
        "possible_n": breast.at(UNDER_GRAVITY, FORCE, possible),
        "complete": complete,
        "decides": decides if known[decides].ended else "",
        "by": known[decides].by,
        "ended": known[decides].ended,
    }


def _lacking(reduced: pd.DataFrame, best: str) -> str:
    """What is lacking where nothing can be said of a strategy with less compression."""
    if best != UNKNOWN:
        return ""
    costs = reduced[reduced["quantity"].isin(COSTS)]
    if costs.value.isna().all():
        return "no strategy with less compression than the standard has an image and a dose"
    if costs.change_percent.isna().all():
        return "the standard strategy, which the others are compared with, has no image and no dose"
    gone = costs.groupby("quantity", sort=False).change_low_percent.apply(lambda each: each.isna().all())
    return f"nothing is known of: {', '.join(WORDS[str(name)] for name in gone[gone].index)}"


def answer_table(found: Iterable[Answer]) -> pd.DataFrame:
    """The rows of answer.csv but for its sentence."""
    return pd.DataFrame([asdict(each) for each in found], columns=list(Answer.__dataclass_fields__))
