"""Gravity-fitted and compression-used moduli side by side."""

import numpy as np
import pandas as pd
import pytest

from mammosim.io.tabulated import tabulated
from mammosim.study.identification.published import beside, ratios


@pytest.fixture
def fitted():
    """Made-up fits of one volunteer: fat known within a factor, gland not at all."""
    return pd.DataFrame(
        {
            "volunteer": "small",
            "side": ["left", "left"],
            "tissue": ["adipose", "glandular"],
            "fitted_kpa": [0.5, 0.8],
            "low_kpa": [0.4, np.nan],
            "high_kpa": [0.6, np.nan],
            "identifiable": [True, False],
        }
    )


def test_every_published_modulus_says_under_what_it_was_found():
    table = tabulated("published_biomechanics")
    assert set(table.under) <= {"gravity", "compression", "ex vivo", "assumed"}
    assert (table.low_kpa <= table.high_kpa).all()


def test_fits_stand_beside_the_published_ones_with_their_intervals(fitted):
    table = beside(tabulated("published_biomechanics"), fitted)
    ours = table[table.source == "this study, small left"].set_index("tissue")
    assert ours.loc["adipose", ["low_kpa", "middle_kpa", "high_kpa"]].tolist() == [0.4, 0.5, 0.6]
    assert ours.loc["glandular", ["low_kpa", "high_kpa", "status"]].tolist() == [0.8, 0.8, "not identifiable"]


def test_the_ratio_is_of_geometric_means_and_its_ends_of_the_nearest_and_farthest_values(fitted):
    published = pd.DataFrame(
        {
            "source": ["a", "b"],
            "tissue": ["breast", "adipose"],
            "low_kpa": [0.2, 4.0],
            "high_kpa": [0.2, 9.0],
            "under": ["gravity", "compression"],
            "status": "transcribed",
        }
    )
    row = ratios(beside(published, fitted)).set_index("tissue").loc["adipose"]
    assert row.gravity_kpa == pytest.approx(np.sqrt(0.2 * 0.5))
    assert row.compression_kpa == pytest.approx(6.0)
    assert row.ratio == pytest.approx(6.0 / np.sqrt(0.1))
    assert (row.ratio_low, row.ratio_high) == pytest.approx((4.0 / 0.6, 9.0 / 0.2))


def test_a_modulus_that_is_not_identifiable_does_not_count(fitted):
    counted = ratios(beside(tabulated("published_biomechanics"), fitted)).set_index("tissue")
    # Mira's breast (0.2 to 0.3) and Carter's gland (1.2), not the fit of 0.8.
    assert counted.loc["glandular", "gravity_values"] == 2


def test_a_tissue_without_both_kinds_has_no_ratio(fitted):
    assert "lesion" not in set(ratios(beside(tabulated("published_biomechanics"), fitted)).tissue)
