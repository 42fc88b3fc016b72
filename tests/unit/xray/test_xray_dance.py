"""Dance's factors, his breast, and dose by several routes."""

import numpy as np
import pytest

from mammosim.core.errors import XrayError
from mammosim.core.labels import Label
from mammosim.core.volume import grid_around
from mammosim.io.tabulated import tabulated
from mammosim.xray.attenuation import material
from mammosim.xray.dance import AIR, FAT, GLAND, SHIELD, UNVERIFIED, dance_dose, standard_breast
from mammosim.xray.dose import GlandularDose
from mammosim.xray.dose_routes import Beam, standard_rows, three_routes
from mammosim.xray.phantom import Phantom
from mammosim.xray.report195 import beam_of_report

MO_MO = Beam(beam_of_report("Mo/Mo 30 kVp"), "Mo/Mo")


def test_factors_are_those_of_the_tables_at_their_places():
    for row in tabulated("dance_g").itertuples():
        dose = dance_dose(row.hvl_mm_al, row.thickness_mm, glandularity_percent=50.0, combination="Mo/Mo")
        assert dose.mgy_per_mgy == pytest.approx(row.g, rel=1e-12)
    for row in tabulated("dance_c").itertuples():
        found = dance_dose(
            row.hvl_mm_al, row.thickness_mm, glandularity_percent=row.glandularity_percent, combination="W/Rh"
        )
        assert found.c == pytest.approx(row.c, rel=1e-12)
        assert found.s == 1.042
        assert found.status == UNVERIFIED


def test_dose_per_kerma_falls_with_thickness_and_gland_and_grows_with_hardness():
    def D(hvl, t, gland):
        return dance_dose(hvl, t, glandularity_percent=gland, combination="Mo/Mo").mgy_per_mgy

    assert D(0.33, 45, 30) > D(0.33, 55, 30)
    assert D(0.37, 45, 30) > D(0.33, 45, 30)
    assert D(0.33, 45, 30) > D(0.33, 45, 31)


def test_what_the_tables_do_not_hold_is_rejected():
    with pytest.raises(XrayError, match="outside Dance's table, 20 to 110"):
        dance_dose(0.35, 15.0, glandularity_percent=50.0, combination="Mo/Mo")
    with pytest.raises(XrayError, match=r"half-value layer in mm Al = 0\.7"):
        dance_dose(0.7, 40.0, glandularity_percent=50.0, combination="Mo/Mo")
    with pytest.raises(XrayError, match="choose one of: Mo/Mo"):
        dance_dose(0.35, 40.0, glandularity_percent=50.0, combination="W/Ag")
    with pytest.raises(XrayError, match="no standard breast of 10 mm"):
        standard_breast(10.0, 50.0, rng=np.random.default_rng(1))
    with pytest.raises(XrayError, match="does not divide"):
        standard_breast(50.0, 50.0, rng=np.random.default_rng(1), spacing_mm=2.0)


def test_a_standard_breast_has_its_glandularity_under_its_shield():
    breast = standard_breast(40.0, 30.0, rng=np.random.default_rng(1))
    gland, fat = breast.mass_g(GLAND), breast.mass_g(FAT)
    n = np.count_nonzero((breast.index == GLAND) | (breast.index == FAT))
    assert gland / (gland + fat) == pytest.approx(0.3, abs=4 * np.sqrt(0.25 / n))
    assert np.pi / 2 * 75**2 * 30 == pytest.approx(n, rel=0.01)  # a voxel's rim of the half circle
    assert not np.isin(breast.index[:5], (GLAND, FAT)).any()
    assert set(np.unique(breast.index)) == {AIR, SHIELD, FAT, GLAND}


def test_standard_breasts_agree_with_the_factors():
    """Within 5 percent, as wide as what is said of Dance's tables read from a secondary source."""
    rows = standard_rows(MO_MO, (40.0, 60.0), relative_error=0.01, seed=1)
    simulated, tabled = (rows[rows.route == route] for route in ("Monte Carlo", "Dance g c s"))
    ratio = simulated.agd_mgy_per_mgy.to_numpy() / tabled.agd_mgy_per_mgy.to_numpy()
    assert np.all(np.abs(ratio - 1) < 0.05 + 3 * 0.01)
    assert np.all(simulated.standard_error <= 0.01 * simulated.agd_mgy_per_mgy)


def test_three_routes_stand_side_by_side_each_with_its_protocol():
    grid = grid_around(np.zeros(3), np.array([40.0, 40.0, 40.0]), 10.0)
    index = np.full(grid.shape, Label.ADIPOSE, np.uint8)
    index[1:3, 1:3] = Label.GLANDULAR
    parts = {Label.AIR: "air", Label.ADIPOSE: "adipose", Label.GLANDULAR: "glandular"}
    phantom = Phantom(grid, index, tuple(material(parts.get(label, "air")) for label in Label))
    dose = GlandularDose(2.0, 0.02, 10.0, 1.0)
    rows = three_routes(dose, phantom, MO_MO, thickness_mm=40.0, relative_error=0.05, seed=2)
    gland = 16 * 1.04 / (16 * 1.04 + 48 * 0.93)
    np.testing.assert_allclose(rows.glandularity_percent, 100 * gland, rtol=1e-9)
    assert rows.agd_mgy_per_mgy[0] == 0.2
    assert rows.standard_error[0] == pytest.approx(0.002)
    assert rows.protocol.nunique() == 2
    assert list(rows.route) == ["Monte Carlo", "Monte Carlo", "Dance g c s"]
    assert "unverified" in rows.status[2]


def test_a_beam_without_factors_is_a_row_that_says_so():
    """Other beams are allowed, and simulated: the tables' silence must not stop a study."""
    rows = standard_rows(Beam(MO_MO.spectrum, "W/Al"), (40.0,), relative_error=0.2, seed=3)
    assert rows.agd_mgy_per_mgy[0] > 0
    assert np.isnan(rows.agd_mgy_per_mgy[1])
    assert rows.status[1].startswith("none: no s for 'W/Al'")
