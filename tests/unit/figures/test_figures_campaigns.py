"""Figures of a campaign can be read for any number of values, and show what the table has."""

import numpy as np
import pytest
import yaml
from conftest import title

from mammosim.figures import campaigns as figures
from mammosim.figures.ticks import SHORT
from mammosim.study.campaigns.campaign import Campaign
from mammosim.study.campaigns.table import frame, shares

GLAND = "load.tissues.glandular.youngs_modulus_kpa"
GRID = f"""
vary:
  {GLAND}: {{from: 0.5, to: 50, number: 40, scale: log}}
  load.thickness_mm: [45, 50, 55]
  load.paddle: [standard, flexible]
"""
SAMPLE = f"""
vary:
  {GLAND}: {{from: 0.5, to: 50, scale: log}}
  load.thickness_mm: {{from: 40, to: 60}}
design: {{saltelli: 32}}
"""


def made(text):
    given = {"title": "t", "subjects": {"small": ["left"]}, "asked": ["agd_mgy"]} | yaml.safe_load(text)
    campaign = Campaign.of("mine", given, file="mine.yaml")
    rows = [
        {
            **{"point": str(n), "volunteer": "small", "side": "left", "shown": dict(point.shown)},
            **{"answers": {"agd_mgy": dose(point.shown)}, "errors": {"agd_mgy": 0.05}, "seconds": 1.0},
            **{"outcome": "converged", "reason": "", "moduli_factor": 1.0},
        }
        for n, point in enumerate(campaign.points())
    ]
    return campaign, frame(campaign, rows)


def dose(shown):
    return (
        3
        + np.log(shown[GLAND]) * (60 - shown["load.thickness_mm"]) / 20
        + (shown.get("load.paddle") == "flexible")
    )


def test_an_answer_is_drawn_against_each_setting_on_its_own_scale():
    campaign, table = made(GRID)
    gland, thickness, paddle = figures.against(campaign, table, "agd_mgy").axes
    assert gland.get_xscale() == "log"
    assert gland.get_xlabel() == "glandular Young's modulus (kPa)"
    assert gland.get_ylabel() == "agd (mGy)"
    middle = gland.lines[1]
    expected = table.groupby(GLAND).agd_mgy.median()
    assert np.allclose(middle.get_xydata(), np.column_stack([expected.index, expected]))
    band = gland.collections[0].get_paths()[0].vertices
    assert band[:, 1].min() == pytest.approx(table.groupby(GLAND).agd_mgy.quantile(0.1).min())
    assert band[:, 1].max() == pytest.approx(table.groupby(GLAND).agd_mgy.quantile(0.9).max())
    assert [label.get_text() for label in paddle.get_xticklabels()] == ["standard", "flexible"]
    assert len(thickness.lines[1].get_xdata()) == 3


def test_lines_have_a_panel_for_each_name_and_a_colour_for_each_number():
    campaign, table = made(GRID)
    figure = figures.lines(campaign, table, "agd_mgy")
    standard, flexible, bar = figure.axes
    assert [title(ax) for ax in (standard, flexible)] == ["standard", "flexible"]
    assert bar.get_ylabel() == "thickness (mm)"
    assert len(standard.lines) == 3
    assert len({line.get_color() for line in standard.lines}) == 3
    assert [len(line.get_xdata()) for line in flexible.lines] == [40] * 3
    # Of one point at each place, 95 % lie within 1.96 standard errors of 0.05 mGy.
    band, line = standard.collections[0].get_paths()[0].vertices, standard.lines[0].get_ydata()
    assert band[:, 1].max() == pytest.approx(line.max() + 1.96 * 0.05)


def test_names_are_written_as_they_are_given_but_for_very_long_ones():
    """A dollar begins no formula, which could be a wrong one."""
    long = "x" * 100
    campaign, table = made(
        GRID.replace("[standard, flexible]", f"{{named: {{'$a_{{$': {{}}, {long}: {{}}}}}}")
    )
    *_, paddle = figures.against(campaign, table, "agd_mgy").axes
    figure = figures.lines(campaign, table, "agd_mgy")
    for drawn in (figures.against, figures.lines, figures.pairs):
        drawn(campaign, table, "agd_mgy").canvas.draw()
    assert paddle.get_xticklabels()[0].get_text() == r"\$a_{\$"
    assert [len(title(ax)) for ax in figure.axes[:2]] == [7, SHORT + 1]


def test_forty_names_are_no_forty_panels():
    names = ", ".join(f"n{n}: {{youngs_modulus_mpa: {n}}}" for n in range(1, 41))
    campaign, table = made(GRID.replace("[standard, flexible]", f"{{named: {{{names}}}}}"))
    assert len(figures.lines(campaign, table, "agd_mgy").axes) == 2  # one panel and the colours
    *_, paddle = figures.against(campaign, table, "agd_mgy").axes
    assert len(paddle.get_xticks()) <= figures.TICKS


def test_pairs_are_maps_of_means_or_every_point_of_a_sample():
    campaign, table = made(GRID)
    *maps, _ = figures.pairs(campaign, table, "agd_mgy").axes
    assert len(maps) == 3
    means = table.pivot_table("agd_mgy", "load.thickness_mm", GLAND)
    (cells,) = maps[0].collections
    assert np.asarray(cells.get_array()) == pytest.approx(means.to_numpy())
    # Forty values along their own scale, each in the middle of its cell; three side by side.
    edges = np.asarray(cells.get_coordinates()[0, :, 0])
    assert np.sqrt(edges[1:] * edges[:-1]) == pytest.approx(means.columns.to_numpy(), rel=1e-5)
    assert maps[0].get_xscale() == "log"
    assert [label.get_text() for label in maps[0].get_yticklabels()] == ["45", "50", "55"]
    campaign, table = made(SAMPLE)
    points, _ = figures.pairs(campaign, table, "agd_mgy").axes
    assert len(points.collections[0].get_offsets()) == len(table) == 128
    assert points.get_yscale() == "linear"
    assert points.get_xscale() == "log"


def test_a_sample_has_no_lines_and_its_shares_have_intervals():
    campaign, table = made(SAMPLE)
    assert figures.lines(campaign, table, "agd_mgy") is None
    figure = figures.explained(shares(campaign, table))
    (ax,) = figure.axes
    assert [label.get_text() for label in ax.get_yticklabels()] == [
        "glandular Young's modulus (kPa)",
        "thickness (mm)",
    ]
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["in total", "share"]


def test_an_interval_that_leaves_out_its_share_is_drawn():
    campaign, table = made(SAMPLE)
    found = shares(campaign, table)
    figures.explained(found.assign(low=found.share + 0.01, high=found.share + 0.1))


def test_points_without_an_answer_leave_a_gap():
    campaign, table = made(GRID)
    table.loc[table[GLAND] > 20, "agd_mgy"] = np.nan
    for draw in (figures.against, figures.lines, figures.pairs):
        assert draw(campaign, table, "agd_mgy") is not None


def test_a_median_of_some_of_the_points_is_hollow():
    campaign, table = made(GRID)
    table.loc[(table[GLAND] > 20) & (table["load.thickness_mm"] == 45), "agd_mgy"] = np.nan
    gland, thickness, _ = figures.against(campaign, table, "agd_mgy").axes
    hollow = [next(line for line in ax.lines if line.get_label() == "gaps") for ax in (gland, thickness)]
    assert sorted(hollow[0].get_xdata()) == sorted(table[GLAND][table[GLAND] > 20].unique())
    assert list(hollow[1].get_xdata()) == [45]


def test_ticks_of_a_logarithmic_axis_are_plain_numbers_that_fit():
    campaign, table = made(GRID)
    gland, *_ = figures.against(campaign, table, "agd_mgy").axes
    low, high = gland.get_xlim()
    gland.figure.canvas.draw()
    told = [text.get_text() for text in gland.get_xticklabels() if low <= text.get_position()[0] <= high]
    assert told == ["0.5", "1", "2", "5", "10", "20", "50"]
    assert not any(text.get_text() for text in gland.get_xticklabels(minor=True))
