"""Dose by several routes, and the report beside ours: every row of the tables is drawn."""

import pandas as pd
import pytest

from mammosim.figures.dose_routes import dose_routes, verification


@pytest.fixture
def routes() -> pd.DataFrame:
    rows = [
        ("Monte Carlo", "this breast, heterogeneous, Monte Carlo", 52.0, 18.0, 0.150, 0.0008),
        ("Monte Carlo", "standard breast, homogeneous, under 5 mm of fat", 52.0, 18.0, 0.190, 0.0006),
        ("Dance g c s", "standard breast, homogeneous, under 5 mm of fat", 52.0, 18.0, 0.192, 0.0),
    ]
    columns = [
        "route",
        "protocol",
        "thickness_mm",
        "glandularity_percent",
        "agd_mgy_per_mgy",
        "standard_error",
    ]
    return pd.DataFrame(rows, columns=columns)


def test_every_route_has_its_bar(routes):
    (ax,) = dose_routes(routes).axes
    assert sorted(bar.get_width() for bar in ax.patches) == sorted(routes.agd_mgy_per_mgy)
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["Monte Carlo", "Dance g c s"]


def test_every_quantity_of_the_report_has_its_point():
    table = pd.DataFrame(
        {
            "quantity": ["tissue", "region 1"] * 2,
            "beam": ["16.8 keV"] * 2 + ["Mo/Mo 30 kVp"] * 2,
            "difference_percent": [0.1, -1.0, 0.2, 0.5],
            "standard_error_ev": [2.0, 0.1, 2.0, 0.1],
            "reference_ev": [4697.0, 17.7, 4293.0, 16.5],
            "gate_percent": [0.5, 3.0, 0.5, 2.0],
        }
    )
    axes = verification(table).axes
    assert [ax.get_title(loc="left") for ax in axes] == ["16.8 keV", "Mo/Mo 30 kVp"]
    points, *_ = axes[0].containers[1].lines
    assert list(points.get_xdata()) == [0.1, -1.0]
