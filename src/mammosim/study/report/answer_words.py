"""The answer of each breast in sentences, and every strategy in a row that is read at a glance."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from mammosim.chain.strategies import STANDARD
from mammosim.core.marks import literal
from mammosim.study.report.answer import BETWEEN, Answer
from mammosim.study.report.pressed_breast import BREAST, FORCE, PRESSURE, STRAIN
from mammosim.study.report.strategy_costs import (
    CALCIFICATIONS,
    COSTS,
    DOSE,
    LESS,
    MASS,
    MAY,
    MORE,
    UNKNOWN,
    WORDS,
    LossLimits,
    together,
)

ROLES: Mapping[str, str] = {
    LESS: "the largest reduction that surely costs less than allowed",
    MAY: "the largest reduction that may cost less than allowed",
    MORE: "the smallest reduction that was computed, costs more than allowed",
    UNKNOWN: "a strategy with less compression",
}


def sentence(answer: Answer, table: pd.DataFrame, limits: LossLimits) -> str:
    """What a supervisor is told of one breast, with `code` and **bold**. table: rows of strategy_costs."""
    rows = table[(table.volunteer == answer.volunteer) & (table.side == answer.side)]
    parts = [_head(answer, limits)]
    if answer.shown:
        parts.append(_shown(answer, rows[rows.strategy == answer.shown]))
    if answer.standard_low_n < answer.standard_high_n:
        low, high = _newton(answer.standard_low_n), _newton(answer.standard_high_n)
        where = f"At {answer.standard_mm:.1f} mm the force is between {low} and {high} N"
        parts.append(f"{where}, as far as her moduli are known.")
    return " ".join(parts)


def loss_words(limits: LossLimits) -> str:
    """What is allowed."""
    return f"{limits.dose:g} % more dose or {limits.detectability:g} % less detectability"


def _head(a: Answer, limits: LossLimits) -> str:
    """How far thickness may rise, or that this cannot be said."""
    who = f"{a.volunteer}, {a.side}"
    if not np.isfinite(a.possible_mm):
        why = literal(a.why) or "no losses are known"
        return f"**{who}: it cannot be said how far compression can be reduced**: {why}."
    begin, cost = f"**{who}: thickness may rise from {a.standard_mm:.1f} to", loss_words(limits)
    if not np.isfinite(a.certain_mm):
        about, most = ("", " at most") if a.complete else ("about ", "")
        end = f"{about}{a.possible_mm:.1f} mm{most}{_force(a, a.possible_n)}**"
        why = "not every loss is known" if a.complete else "not every numerical error was measured"
        why += ", so that no thickness is certain"
        return f"{begin} {end} before it costs {cost}; {why}."
    if not a.ended:
        end = f"{a.certain_mm:.1f} mm at least{_force(a, a.certain_n)}**"
        return f"{begin} {end}, the thickest that was computed, for less than {cost}."
    certain, possible = f"{a.certain_mm:.1f} mm", f"{a.possible_mm:.1f} mm"
    ends = [certain] if certain == possible else [f"{certain} at least", f"{possible} at most"]
    how = "interpolated between strategies" if a.by == BETWEEN else "among the strategies that were computed"
    forces = _force(a, *[a.certain_n, a.possible_n][: len(ends)])
    return f"{begin} {', '.join(ends)}{forces}** before it costs {cost}; {WORDS[a.decides]} decides, {how}."


def _force(a: Answer, *to: float) -> str:
    known = [_newton(each) for each in to if np.isfinite(each)]
    return f" (force {_newton(a.standard_n)} to {' or '.join(dict.fromkeys(known))} N)" if known else ""


def _newton(force: float) -> str:
    """Three digits, or a dash where nothing is known."""
    if not np.isfinite(force):
        return "–"
    return f"{force:.{2 if force < 10 else 1 if force < 100 else 0}f}"


def _shown(a: Answer, rows: pd.DataFrame) -> str:
    by = rows.set_index("quantity")
    told = [f"{WORDS[q]} {change_words(by.loc[q])}" for q in COSTS if np.isfinite(by.loc[q].change_percent)]
    place = f"{by.thickness_mm.iloc[0]:.1f} mm, {_newton(by.loc[FORCE].value)} N"
    costs = ", ".join(told) or "what it costs is not known"
    return f"`{a.shown}` ({place}), {ROLES[a.verdict]}: {costs}; strain {change_words(by.loc[STRAIN])}."


def change_words(row: pd.Series) -> str:
    """A change in percent with its interval: '+147 % (140 to 154)'; that it is not known where it is not."""
    if not np.isfinite(row.change_percent):
        return "not known"
    low, high = row.change_low_percent, row.change_high_percent
    inside = f" ({percent(low)} to {percent(high)})" if np.isfinite(low) and low < high else ""
    return f"{percent(row.change_percent)} %{inside}"


def percent(change: float) -> str:
    """A change with its sign, to a whole number from 10 % on."""
    return f"{change:+.{0 if abs(change) >= 9.95 else 1}f}".replace("-", "−")


# The columns of changes, as they are read, with the quantity and its unit.
CHANGES: Mapping[str, tuple[str, str]] = {
    "strain": (STRAIN, ""),
    "pressure": (PRESSURE, " kPa"),
    "dose": (DOSE, " mGy"),
    "d' of mass": (MASS, ""),
    "d' of calcifications": (CALCIFICATIONS, ""),
}
SHORT = ["breast", "strategy", "thickness_mm", "force_n", *CHANGES, "costs"]
NO_BREAK = "\N{NO-BREAK SPACE}"


def short_table(table: pd.DataFrame) -> pd.DataFrame:
    """SHORT: a row per strategy: force with its interval, changes in words, and what it costs of all limits.

    The row of the standard has its values. table: rows of strategy_costs.
    """
    rows = []
    for (volunteer, side, strategy), part in table.groupby([*BREAST, "strategy"], sort=False):
        by = part.set_index("quantity")
        limited = [cost for cost in part.costs.fillna("") if cost]
        rows.append(
            {"breast": _whole(f"{volunteer} {side}"), "strategy": strategy}
            | {"thickness_mm": round(float(by.thickness_mm.iloc[0]), 1)}
            | {"force_n": _whole(_with_interval(by.loc[FORCE]))}
            | {name: _whole(_told(by.loc[quantity], unit)) for name, (quantity, unit) in CHANGES.items()}
            | {"costs": together(limited) if limited else ""}
        )
    return pd.DataFrame(rows, columns=SHORT)


def _whole(words: str) -> str:
    """Words that a line breaks before an interval only."""
    return words.replace(" ", NO_BREAK).replace(f"{NO_BREAK}(", " (")


def _with_interval(row: pd.Series) -> str:
    if not row.low < row.high:
        return _newton(row.value)
    return f"{_newton(row.value)} ({_newton(row.low)} to {_newton(row.high)})"


def _told(row: pd.Series, unit: str) -> str:
    """A change in words, or the value where it is that of the standard; a dash where there is none."""
    if not np.isfinite(row.value):
        return "–"
    known = np.isfinite(row.change_percent) and row.strategy != STANDARD
    return change_words(row) if known else f"{row.value:.3g}{unit}"
