"""What stands in the beam, and how hard the beam is."""

import numpy as np
import pytest

from mammosim.core.errors import XrayError
from mammosim.xray.attenuation import linear_attenuation, material
from mammosim.xray.quality import AirGap, Paddle, in_the_way, quality, quality_table
from mammosim.xray.spectrum import monoenergetic
from mammosim.xray.tube import tube_spectrum


def test_one_energy_has_homogeneity_one_and_an_unchanged_half_value_layer_behind_a_paddle():
    beam = monoenergetic(20.0)
    row = quality(beam)
    assert row["homogeneity"] == pytest.approx(1.0, rel=1e-7)
    table = quality_table([beam], (Paddle("polycarbonate", 3.0),))
    assert table.hvl_behind_mm_al[0] == pytest.approx(row["hvl_mm_al"], rel=1e-7)


def test_paddle_and_air_leave_the_exponential_share():
    beam, E = monoenergetic(18.0), np.array([18.0])
    mu = linear_attenuation(material("pmma"), E)[0] * 2.8 + linear_attenuation(material("air"), E)[0] * 600
    behind = in_the_way(beam, (Paddle("pmma", 2.8), AirGap(600.0)))
    assert behind.fluence[0] == pytest.approx((1000 / 600) ** 2 * np.exp(-mu), rel=1e-12)
    assert behind.distance_mm == 600.0
    assert in_the_way(beam, ()) is beam


def test_a_paddle_hardens_the_beam_and_takes_kerma():
    table = quality_table(
        [tube_spectrum("W", "Rh", 0.05, 28.0), tube_spectrum("Mo", "Mo", 0.03, 28.0)], (Paddle(),)
    )
    assert list(table.beam) == ["W/Rh 0.05 mm 28 kVp", "Mo/Mo 0.03 mm 28 kVp"]
    assert np.all(table.hvl_behind_mm_al > table.hvl_mm_al)
    assert np.all(table.kerma_behind_ugy_per_mas < table.kerma_ugy_per_mas)
    assert np.all(table.homogeneity < 1)


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: Paddle("wood"), "choose one of: pmma"),
        (lambda: Paddle("pmma", 0.2), "give mm"),
        (lambda: Paddle("pmma", float("nan")), "give mm"),
        (lambda: AirGap(-1.0), "outside 0 to 5000"),
        (lambda: tube_spectrum("W", "Al", 0.7, 49.5), "computed tomography"),
    ],
)
def test_impossible_layers_and_voltages_are_rejected(make, word):
    with pytest.raises(XrayError, match=word):
        make()
