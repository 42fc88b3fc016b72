"""What a run will take, before it begins: the jobs of a dry run, at what their rules cost when measured."""

import re
from collections.abc import Collection, Iterable, Mapping

import numpy as np
import pandas as pd

JOBS = re.compile(r"^(?P<rule>[a-z][a-z0-9_]*)\s+(?P<jobs>\d+)$", re.MULTILINE)
HERE, TABLE, UNKNOWN = "measured here", "table", "not measured"
POINTS = "by points"
BATCH = "campaigns_batch"  # the rule whose jobs are batches of points
CAMPAIGN = "campaign"  # the last rule of a campaign, which has its name: see workflow/rules/campaigns.smk
COLUMNS = ["target", "rule", "jobs", "seconds_each", "seconds", "memory_mb", "cost"]


def jobs_of(words: str, *, idle: Collection[str] = ()) -> dict[str, int]:
    """Jobs by rule, of what a dry run of Snakemake prints; empty when there is nothing to do.

    idle: rules that only name what others make.
    """
    found = {match["rule"]: int(match["jobs"]) for match in JOBS.finditer(words)}
    return {rule: jobs for rule, jobs in found.items() if rule not in ("total", *idle)}


def costed_as(rule: str) -> str:
    """The name of a rule in a table of costs."""
    return CAMPAIGN if rule.startswith(f"{CAMPAIGN}_") else rule


def costs(benchmarks: pd.DataFrame, table: pd.DataFrame) -> pd.DataFrame:
    """seconds, memory_mb and cost (where they come from) by rule.

    benchmarks: rule, cpu_time (s) and max_rss (MB) of every job that ran here, NaN of one that was not
    measured; of a rule with any, their means count; table: rule, seconds, memory_mb of the study as
    published, for the others.
    """
    numbers = benchmarks.astype({"cpu_time": float, "max_rss": float}).dropna(subset=["cpu_time"])
    numbers["rule"] = numbers.rule.map(costed_as)
    here = numbers.groupby("rule").agg(seconds=("cpu_time", "mean"), memory_mb=("max_rss", "max"))
    known = table.set_index("rule")[["seconds", "memory_mb"]]
    rest = known.loc[known.index.difference(here.index)]
    return pd.concat([here.assign(cost=HERE), rest.assign(cost=TABLE)])


def plan(
    targets: Mapping[str, Mapping[str, int]],
    known: pd.DataFrame,
    batches: Mapping[str, float] | None = None,
) -> pd.DataFrame:
    """A row per target and rule, COLUMNS; seconds of a processor. A rule without a cost counts as nothing.

    targets: name -> jobs by rule; known: see costs; batches: target -> seconds of all its jobs of BATCH, of
    which no two cost the same.
    """
    rows = [(target, rule, jobs) for target, rules in targets.items() for rule, jobs in rules.items()]
    table = pd.DataFrame(rows, columns=["target", "rule", "jobs"])
    found = known.reindex(table.rule.map(costed_as)).reset_index(drop=True)
    table = table.assign(
        seconds_each=found.seconds, memory_mb=found.memory_mb, cost=found.cost.fillna(UNKNOWN)
    )
    for target, seconds in (batches or {}).items():
        here = (table.target == target) & (table.rule == BATCH)
        table.loc[here, "seconds_each"] = seconds / table.jobs[here]
        table.loc[here, "cost"] = POINTS
    return table.assign(seconds=table.jobs * table.seconds_each)[COLUMNS]


def summary(table: pd.DataFrame, targets: Iterable[str], *, cores: int) -> pd.DataFrame:
    """A row per target: jobs, minutes on so many cores, memory_mb, and how many jobs have no cost.

    memory_mb: the most that so many jobs can hold at once.
    """
    # ASSUME: no core is ever idle while a study runs.
    rows = []
    for target in targets:
        part = table[table.target == target]
        each = np.sort(np.repeat(part.memory_mb.fillna(0).to_numpy(), part.jobs.to_numpy()))[::-1]
        rows.append(
            {
                "target": target,
                "jobs": int(part.jobs.sum()),
                "minutes": float(part.seconds.sum()) / 60 / cores,
                "memory_mb": float(each[:cores].sum()),
                "not_measured": int(part.jobs[part.cost == UNKNOWN].sum()),
            }
        )
    return pd.DataFrame(rows)


def scene_lines(effects: Mapping[str, pd.DataFrame | list[str] | None]) -> list[str]:
    """One line per scene: its effects as screened (rows of effects.csv), as listed, or not known yet."""
    lines = []
    for scene, found in effects.items():
        if found is None:
            words = "effects: auto, screened first; what follows is then planned"
        elif isinstance(found, list):
            words = f"effects as listed: {', '.join(found) or 'none'}"
        else:
            chosen = found.drop_duplicates("effect").set_index("effect").included.astype(bool)
            left = ", ".join(chosen.index[~chosen]) or "none"
            words = f"effects: {', '.join(chosen.index[chosen]) or 'none'}; left out: {left}"
        lines.append(f"{scene}: {words}")
    return lines


def words(
    found: pd.DataFrame,
    table: pd.DataFrame,
    scenes: list[str],
    *,
    cores: int,
    at_least: Collection[str] = (),
) -> str:
    """The plan as text for a terminal: a line per target, its dearest rules, a line per scene.

    at_least: targets whose further jobs are not known before some of their own have run.
    """
    lines = [f"{'target':<12}{'jobs':>6}{f'min on {cores} cores':>17}{'peak MB':>9}   dearest rules"]
    for row in found.itertuples():
        dearest = table[table.target == row.target].nlargest(3, "seconds")
        names = ", ".join(f"{r.rule} {r.seconds:.0f} s" for r in dearest.itertuples() if r.seconds > 0)
        unknown = f" ({row.not_measured} jobs were never measured)" if row.not_measured else ""
        unknown += " (at least: what it screens decides what follows)" if row.target in at_least else ""
        lines.append(
            f"{row.target:<12}{row.jobs:>6}{row.minutes:>17.1f}{row.memory_mb:>9.0f}   {names}{unknown}"
        )
    return "\n".join([*lines, "", *scenes])
