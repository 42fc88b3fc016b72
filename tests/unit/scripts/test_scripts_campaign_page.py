"""The page of a campaign has every point in a table that is paged, and its title is text."""

import pytest
import yaml

from mammosim.io.tables import write_table
from mammosim.study.campaigns.campaign import Campaign
from mammosim.study.campaigns.table import frame
from mammosim.study.report.scripts import SCRIPTS

EVIL = "<img src=x onerror='window.ran=1'>"
VARY = "vary: {load.thickness_mm: {from: 40, to: 60, number: 30}, load.paddle: [standard, flexible]}"


@pytest.fixture
def campaign():
    given = {"title": f"How much {EVIL}?", "subjects": {"small": ["left"]}, "asked": ["force_n"]}
    return Campaign.of("mine", given | yaml.safe_load(VARY), file="mine.yaml")


@pytest.fixture
def written(campaign, script, tmp_path):
    """The file of the page, with the scripts where it looks for them."""
    rows = [
        {
            **{"point": str(n), "volunteer": "small", "side": "left", "shown": dict(point.shown)},
            **{"answers": {"force_n": 100.0 - n}, "errors": {"force_n": 0.05}, "seconds": 1.0},
            **{"outcome": "converged", "reason": "", "moduli_factor": 1.0},
        }
        for n, point in enumerate(campaign.points())
    ]
    folder = tmp_path / "campaigns"
    folder.mkdir()
    (tmp_path / "study/scripts").mkdir(parents=True)
    for name in ("datatables.js", "datatables.css"):
        (tmp_path / "study/scripts" / name).write_bytes(SCRIPTS[name]())
    write_table(frame(campaign, rows), folder / "mine.csv")
    script("campaign_page").main(str(folder / "mine.csv"), campaign, str(folder / "mine.html"))
    return folder / "mine.html"


def test_every_point_is_in_a_paged_table_and_nothing_of_the_title_runs(written, page):
    read = page.open(written)
    table = read.locator("figure.table", has_text="Every point").last
    table.scroll_into_view_if_needed()
    table.locator(".dt-search input").wait_for()
    assert "of 60 entries" in table.locator(".dt-info").text_content()
    assert EVIL in read.title()
    assert read.evaluate("window.ran") is None
    assert page.violations() == []
