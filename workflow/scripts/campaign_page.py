"""The page of a campaign: every answer against every setting, what they do together, and what failed."""

from collections.abc import Iterator

import _log
import _pages
import pandas as pd

from mammosim.figures import campaigns as figures
from mammosim.io.atomic import replacing
from mammosim.io.figures import png_of
from mammosim.io.tables import read_rows
from mammosim.study.campaigns.campaign import Campaign
from mammosim.study.campaigns.page import opening, shares_words
from mammosim.study.campaigns.table import SUBJECT, answer_columns, failures, shares, summary
from mammosim.study.report.pages import Listing, Picture, Section, report

REASONS = 50  # rows on the page; the table has them all
SCRIPTS = "../study/scripts"
AGAINST = (
    "against each setting: every point, and at each value the median and the range of 80 % of them. Where a "
    "mark is hollow, some points have no answer: the median is that of the others, and may jump."
)
LINES = "along the setting with most values; what is not shown is averaged over."
PAIRS = "over pairs of settings, averaged over all others that have an answer."


def main(path: str, campaign: Campaign, out: str) -> None:
    named = [each.key for each in campaign.axes if not each.is_numeric]
    table = read_rows(path, names=[*SUBJECT, *named, "point"])
    sections = [
        Section("Campaign", opening(campaign, table), (Listing(summary(campaign, table), "All answers."),)),
        *(quantity(campaign, table, name) for name in answer_columns(campaign)),
        explained(campaign, table),
        failed(table),
        Section(
            "Every point", "", (Listing(table, "Every point with its answers.", f"{campaign.name}.csv"),)
        ),
    ]
    page = report(
        f"mammosim: {campaign.title}",
        tuple(sections),
        numbers={},
        footer=_pages.made_by(f"snakemake campaign_{campaign.name}"),
        scripts=SCRIPTS,
    )
    with replacing(out) as temporary:
        temporary.write_text(page, encoding="utf-8")


def quantity(campaign: Campaign, table: pd.DataFrame, name: str) -> Section:
    """The figures of one answer."""
    title = figures.heading(name)
    if table[name].notna().sum() < 2 or not figures.varied(campaign, table):
        return Section(title, "Fewer than two points have an answer.")
    return Section(title, "", tuple(pictures(campaign, table, name)))


def pictures(campaign: Campaign, table: pd.DataFrame, name: str) -> Iterator[Picture]:
    """Against each setting, along the longest, over pairs: as far as the campaign has them."""
    words = figures.heading(name)
    for draw, caption in ((figures.against, AGAINST), (figures.lines, LINES), (figures.pairs, PAIRS)):
        figure = draw(campaign, table, name)
        if figure is not None:
            yield Picture(png_of(figure), f"{words[0].upper()}{words[1:]} {caption}")


def explained(campaign: Campaign, table: pd.DataFrame) -> Section:
    """What each setting explains."""
    found = shares(campaign, table)
    words = shares_words(campaign, there=len(found) > 0)
    blocks = [Picture(png_of(figures.explained(found)), "Shares of the variance.")] if len(found) else []
    blocks += [Listing(found.dropna(axis=1, how="all"), "Shares of the variance.")] if len(found) else []
    return Section("What explains it", words, tuple(blocks))


def failed(table: pd.DataFrame) -> Section:
    """Points without an answer, by their reason."""
    found = failures(table)
    if found.empty:
        return Section("Points without an answer", "There is none.")
    more = f" The table has {len(found) - REASONS} reasons more." if len(found) > REASONS else ""
    return Section(
        "Points without an answer",
        f"{found.points.sum()} of {len(table)} points.{more}",
        (Listing(found.head(REASONS), "Outcomes and reasons, the most frequent first."),),
    )


if __name__ == "__main__":
    _log.to(snakemake.log[0], threads=snakemake.threads)
    name = snakemake.wildcards.campaign
    campaign = Campaign.of(name, snakemake.params.given, file=f"config/campaigns/{name}.yaml")
    main(snakemake.input.table, campaign, snakemake.output[0])
