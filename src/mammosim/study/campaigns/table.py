"""The table of a campaign, and what of a quantity each setting explains."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd

from mammosim.chain.outcome import CONVERGED
from mammosim.chain.quantities import QUANTITIES
from mammosim.core.errors import ConfigurationError
from mammosim.study.campaigns.answers import columns
from mammosim.study.campaigns.axes import SALTELLI, rounded, sampled
from mammosim.study.campaigns.campaign import ASKED, Campaign

SUBJECT = ("volunteer", "side")
ENDING = ("moduli_factor", "outcome", "reason", "seconds", "point")
ERROR = "_error"  # after the name of an answer: its standard error
SHARES = ("quantity", "setting", "share", "total", "low", "high", "how")
EXACT = 1e-9  # of the variance: what is left to rounding


def answer_columns(campaign: Campaign) -> list[str]:
    """The columns of what is asked, three of a place."""
    return [each for name in campaign.asked for each in columns(name, QUANTITIES[ASKED[name]].size)]


def frame(campaign: Campaign, rows: Iterable[Mapping[str, Any]]) -> pd.DataFrame:
    """A row per point: SUBJECT, each varied setting by its key, each answer with its error, and ENDING.

    In the order in which the campaign lists its settings and their values. rows: those of all batches.
    """
    noisy = [name for name in campaign.asked if QUANTITIES[ASKED[name]].noise is not None]
    found = []
    for row in rows:
        answers = {name: row["answers"].get(name) for name in answer_columns(campaign)}
        errors = {f"{name}{ERROR}": row["errors"].get(name) for name in noisy}
        whose = {name: row[name] for name in SUBJECT}
        found.append(whose | row["shown"] | answers | errors | {name: row[name] for name in ENDING})
    wanted = [
        name
        for answer in answer_columns(campaign)
        for name in (answer, *([f"{answer}{ERROR}"] if answer in noisy else []))
    ]
    table = pd.DataFrame(found, columns=[*SUBJECT, *campaign.keys, *wanted, *ENDING])
    numbers = [*wanted, "moduli_factor", "seconds"]
    table[numbers] = table[numbers].astype(float)
    return _ordered(campaign, table)


def _ordered(campaign: Campaign, table: pd.DataFrame) -> pd.DataFrame:
    """Names in the order of the campaign, numbers rising."""
    ranks: dict[str, list[Any]] = {"volunteer": [v for v, _ in campaign.subjects]}
    ranks |= {
        each.key: [level.shown for level in each.levels] for each in campaign.axes if not each.is_numeric
    }

    def rank(column: pd.Series) -> pd.Series:
        levels = ranks.get(str(column.name))
        return column if levels is None else column.map({level: n for n, level in enumerate(levels)})

    return table.sort_values([*SUBJECT, *campaign.keys], key=rank, kind="stable", ignore_index=True)


def summary(campaign: Campaign, table: pd.DataFrame) -> pd.DataFrame:
    """A row per answer: how many points have it, and its least, median and greatest value."""
    return pd.DataFrame(
        {
            "quantity": name,
            "points": int(table[name].count()),
            "least": table[name].min(),
            "median": table[name].median(),
            "greatest": table[name].max(),
        }
        for name in answer_columns(campaign)
    )


def failures(table: pd.DataFrame) -> pd.DataFrame:
    """A row per outcome and reason of the points that have no answer, the most frequent first."""
    failed = table[table.outcome != CONVERGED]
    counted = failed.groupby(["outcome", "reason"], sort=False).size().rename("points").reset_index()
    return counted.sort_values("points", ascending=False, kind="stable", ignore_index=True)


def shares(campaign: Campaign, table: pd.DataFrame) -> pd.DataFrame:
    """What part of the variance of each answer each setting explains, SHARES; empty where it is not told.

    Of a full grid, shares of the sum of squares, and those of pairs beyond both; of Saltelli's design, Sobol
    indices of first order, and in total, with their 95 % interval. A grid or sample with gaps has none.
    """
    if campaign.design is not None and campaign.design.kind == SALTELLI:
        return _sobol(campaign, table)
    factors = [name for name in (*SUBJECT, *campaign.keys) if table[name].nunique() > 1]
    if campaign.design is not None or not factors:
        return pd.DataFrame(columns=list(SHARES))
    found = [row for name in answer_columns(campaign) for row in _grid(table, factors, name)]
    return pd.DataFrame(found, columns=list(SHARES))


def _grid(table: pd.DataFrame, factors: Sequence[str], name: str) -> list[tuple[Any, ...]]:
    """Analysis of variance of a full grid without repeats: sums of squares over the total."""
    full = np.prod([table[factor].nunique() for factor in factors])
    values = table[name]
    variance = float(((values - values.mean()) ** 2).sum())
    if values.isna().any() or len(table) != full or variance <= EXACT * float((values**2).sum()):
        return []
    mean = values.mean()
    alone = {factor: table.groupby(factor)[name].transform("mean") - mean for factor in factors}
    rows = [(name, key, float((effect**2).sum()) / variance) for key, effect in alone.items()]
    for one, other in combinations(factors, 2):
        both = table.groupby([one, other])[name].transform("mean") - mean - alone[one] - alone[other]
        rows.append((name, f"{one} x {other}", float((both**2).sum()) / variance))
    return [(*row, np.nan, np.nan, np.nan, "analysis of variance") for row in rows]


def _sobol(campaign: Campaign, table: pd.DataFrame) -> pd.DataFrame:
    """Of each subject and combination of listed values by itself; a sample with gaps is left out."""
    listed = [each.key for each in campaign.axes if each.span is None]
    differ = [column for column in (*SUBJECT, *listed) if table[column].nunique() > 1]
    rows = []
    for _, group in table.groupby([*SUBJECT, *listed], sort=False):
        words = ", ".join(["Sobol", *map(str, group[differ].iloc[0])])
        for name in answer_columns(campaign):
            rows += [(name, *row, words) for row in _indices(campaign, group, name)]
    return pd.DataFrame(rows, columns=list(SHARES))


def _indices(campaign: Campaign, group: pd.DataFrame, name: str) -> list[tuple[Any, ...]]:
    """Setting, first order, total, and the 95 % interval of the first (Saltelli 2010, by scipy)."""
    from scipy.stats import sobol_indices

    if campaign.design is None:
        raise ConfigurationError("no design: there are no Sobol indices; give one")
    keys, n = list(campaign.spans), campaign.design.number
    places = zip(*(map(rounded, group[key]) for key in keys))
    values = dict(zip(places, group[name]))
    drawn = [tuple(point[key] for key in keys) for point in sampled(campaign.design, campaign.spans)]
    f = np.array([values.get(each, np.nan) for each in drawn]).reshape(len(keys) + 2, n)
    if not np.isfinite(f).all() or np.ptp(f) <= EXACT * np.abs(f).max():
        return []
    found = sobol_indices(
        func={"f_A": f[:1], "f_B": f[1:2], "f_AB": f[2:, None, :]}, n=n, rng=campaign.design.seed
    )
    spread = found.bootstrap(confidence_level=0.95).first_order.confidence_interval
    first, total, low, high = (
        np.ravel(x) for x in (found.first_order, found.total_order, spread.low, spread.high)
    )
    return list(zip(keys, first, total, low, high))
