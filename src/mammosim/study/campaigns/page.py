"""What the page of a campaign says: its question, what was varied, and how many points have an answer."""

import pandas as pd

from mammosim.chain.outcome import CONVERGED
from mammosim.core.marks import literal
from mammosim.study.campaigns.axes import SALTELLI, Axis
from mammosim.study.campaigns.campaign import Campaign


def axis_words(each: Axis) -> str:
    """A varied setting in words: its values, or between which they lie."""
    if each.span is not None:
        return f"`{each.key}`: {each.span.low:g} to {each.span.high:g}, sampled, {each.scale}"
    shown = [literal(level.shown) for level in each.levels]
    if len(shown) > 8:
        return f"`{each.key}`: {len(shown)} values, {shown[0]} to {shown[-1]}, {each.scale}"
    return f"`{each.key}`: {', '.join(shown)}"


def opening(campaign: Campaign, table: pd.DataFrame) -> str:
    """The first paragraphs of the page."""
    answered = int((table.outcome == CONVERGED).sum())
    left_out = campaign.size - len(table)
    parts = [
        f"**{literal(campaign.title)}**",
        f"{len(table)} points, of which {answered} have an answer"
        + (
            f"; {left_out} more were left out: {'; '.join(literal(c.text) for c in campaign.exclude)}"
            if left_out
            else ""
        )
        + f". They took {table.seconds.sum() / 60:.1f} minutes of a processor.",
        whose_words(campaign),
        *factor_words(table),
        "Varied: " + ". ".join(map(axis_words, campaign.axes)) + ".",
        f"All points: [{campaign.name}.csv]({campaign.name}.csv), "
        f"[{campaign.name}.parquet]({campaign.name}.parquet).",
    ]
    return "\n\n".join(parts)


def whose_words(campaign: Campaign) -> str:
    """Whose breasts, and what does not vary."""
    breasts = ", ".join(f"{volunteer} {side}" for volunteer, side in campaign.subjects)
    load = [f"{key} `{value}`" for key, value in campaign.load.items() if f"load.{key}" not in campaign.keys]
    tissues = [f"tissues `{campaign.tissues}`"] if campaign.tissues else []
    return f"Of {breasts}; {', '.join([f'accuracy `{campaign.accuracy}`', *tissues, *load])}."


def factor_words(table: pd.DataFrame) -> list[str]:
    """That all moduli were multiplied, and that answers jump with the factor; nothing of none."""
    factors = table.moduli_factor.dropna()
    stiffer = factors[factors > 1]
    if stiffer.empty:
        return []
    values = ", ".join(f"{value:g}" for value in sorted(stiffer.unique()))
    jumps = " An answer may jump where this factor does." if factors.nunique() > 1 else ""
    return [
        f"In {len(stiffer)} of {len(table)} points all moduli were multiplied by {values}, the least that "
        f"carries the weight of the breast (column `moduli_factor`).{jumps}"
    ]


def shares_words(campaign: Campaign, *, there: bool) -> str:
    """How shares of the variance were had, or what would give them."""
    if not there:
        return (
            "How much of the variance of an answer each setting explains can be computed of a full grid "
            "without gaps, and of a `saltelli` design."
        )
    if campaign.design is not None and campaign.design.kind == SALTELLI:
        return (
            "Sobol indices (Saltelli 2010): the share of the variance that a setting explains alone, with "
            "its 95 % interval, and in total, with all that it does together with others."
        )
    return (
        "Analysis of variance of the full grid: the share that a setting explains by itself, and that two "
        "explain together beyond both. The rest belongs to three and more."
    )
