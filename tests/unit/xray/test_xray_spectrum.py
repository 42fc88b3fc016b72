"""Cross-sections, spectra and beams: what is conserved, what is rejected."""

import numpy as np
import pytest

from mammosim.core.errors import XrayError
from mammosim.xray.attenuation import Material, linear_attenuation, material, materials, mixture
from mammosim.xray.quality import AirGap, Paddle, in_the_way, quality, quality_table
from mammosim.xray.spectrum import Spectrum, kerma_per_fluence, monoenergetic, value_layer
from mammosim.xray.tube import Tube, tube_spectrum

E = np.array([10.0, 16.8, 20.0, 30.0])


def test_the_processes_add_to_the_total():
    for matter in materials().values():
        parts = [
            linear_attenuation(matter, E, process=p) for p in ("photoelectric", "incoherent", "coherent")
        ]
        np.testing.assert_allclose(sum(parts), linear_attenuation(matter, E), rtol=1e-12)


def test_water_at_20_kev_is_near_the_nist_value():
    # NIST XCOM: 0.8096 cm2/g; cross-section libraries differ by less than 1 percent there
    assert linear_attenuation(material("water"), np.array([20.0]))[0] == pytest.approx(0.08096, rel=0.01)


def test_attenuation_of_a_mixture_is_the_mean_by_weight():
    adipose, glandular = material("adipose"), material("glandular")
    mixed = mixture("breast", ((adipose, 0.8), (glandular, 0.2)), density_g_cm3=0.952)
    by_weight = 0.8 * linear_attenuation(adipose, E) / 0.93 + 0.2 * linear_attenuation(glandular, E) / 1.04
    np.testing.assert_allclose(linear_attenuation(mixed, E), 0.952 * by_weight, rtol=1e-12)


def test_volumes_add_in_a_mixture_without_density():
    mixed = mixture("half", ((material("adipose"), 0.5), (material("glandular"), 0.5)))
    assert mixed.density_g_cm3 == pytest.approx(1 / (0.5 / 0.93 + 0.5 / 1.04))


def test_unknown_material_process_and_energy_are_rejected():
    with pytest.raises(XrayError, match="choose one of: adipose"):
        material("adipos")
    with pytest.raises(XrayError, match="unknown process"):
        linear_attenuation(material("water"), E, process="pair")
    with pytest.raises(XrayError, match=r"0\.5 keV is outside"):
        linear_attenuation(material("water"), np.array([0.5]))


def test_fractions_that_do_not_add_to_one_are_rejected():
    with pytest.raises(XrayError, match="must add to 1"):
        Material("percent", 1.0, ((1, 11.0), (8, 89.0)))
    with pytest.raises(XrayError, match="density"):
        Material("nothing", 0.0, ((1, 1.0),))


@pytest.fixture(scope="module")
def tungsten_rhodium() -> Spectrum:
    return tube_spectrum("W", "Rh", 0.05, 28.0)


def test_rebinning_conserves_photons_and_energy(tungsten_rhodium):
    coarse = tungsten_rhodium.rebinned(20)
    assert len(coarse.energies_kev) <= 20
    assert coarse.fluence.sum() == pytest.approx(tungsten_rhodium.fluence.sum(), rel=1e-12)
    assert coarse.mean_energy_kev == pytest.approx(tungsten_rhodium.mean_energy_kev, rel=1e-12)


def test_fluence_falls_with_the_square_of_distance(tungsten_rhodium):
    assert tungsten_rhodium.at(500.0).kerma_mgy_per_mas == pytest.approx(
        4 * tungsten_rhodium.kerma_mgy_per_mas
    )


def test_tube_spectrum_falls_with_the_square_of_distance(tungsten_rhodium):
    near = tube_spectrum("W", "Rh", 0.05, 28.0, distance_mm=500.0)
    np.testing.assert_allclose(near.fluence, tungsten_rhodium.at(500.0).fluence, rtol=1e-9)


def test_half_value_layer_of_one_energy_is_ln2_over_mu():
    beam = monoenergetic(20.0)
    one_mm = beam.through(material("aluminium"), 1.0)
    mu = -np.log(one_mm.fluence[0])
    assert beam.hvl_mm_al == pytest.approx(np.log(2) / mu, rel=1e-8)
    assert value_layer(beam, fraction=0.25) == pytest.approx(2 * np.log(2) / mu, rel=1e-8)


def test_hardening_lengthens_the_half_value_layer(tungsten_rhodium):
    assert tungsten_rhodium.through(material("pmma"), 20.0).hvl_mm_al > tungsten_rhodium.hvl_mm_al


def test_no_photon_has_more_energy_than_the_tube_voltage(tungsten_rhodium):
    assert tungsten_rhodium.energies_kev.max() < 28.0


def test_kerma_of_one_photon_is_energy_times_absorption_coefficient():
    # a row of the table; 1 photon/mm2 = 100 /cm2; 1 keV/g = 1.602176634e-13 Gy
    kerma_gy = kerma_per_fluence(np.array([20.25]))[0] / 1e3
    assert kerma_gy == pytest.approx(20.25 * 1.602176634e-13 * 100 * 0.5211, rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (("W", "Mo", 0.03, 28.0), "W/Rh"),
        (("Cu", "Rh", 0.05, 28.0), "Cu/Rh"),
        (("W", "Rh", 0.05, 120.0), "20 to 40"),
        (("W", "Rh", 0.05, 15.0), "20 to 40"),
        (("W", "Rh", 50.0, 28.0), "usual is 0.05"),
        (("W", "Rh", 0.005, 28.0), "usual is 0.05"),
        (("W", "Rh", float("nan"), 28.0), "usual is 0.05"),
    ],
)
def test_impossible_tubes_are_rejected_with_advice(arguments, word):
    with pytest.raises(XrayError, match=word):
        tube_spectrum(*arguments)


def test_impossible_tube_settings_are_rejected():
    with pytest.raises(XrayError, match="anode_angle_deg"):
        Tube(anode_angle_deg=0.0)


@pytest.mark.parametrize(
    ("energies", "fluence", "word"),
    [
        ([20.0, 10.0], [1.0, 1.0], "increase"),
        ([10.0, 20.0], [1.0, -1.0], "not negative"),
        ([10.0, 20.0], [0.0, 0.0], "at least one photon"),
        ([10.0, 20.0], [1.0, np.inf], "finite"),
        ([10.0, 200.0], [1.0, 1.0], "outside 1 to 100 keV"),
        ([10.0, np.nan], [1.0, 1.0], "outside 1 to 100 keV"),
        ([10.0], [1.0, 1.0], "must both be"),
    ],
)
def test_impossible_spectra_are_rejected(energies, fluence, word):
    with pytest.raises(XrayError, match=word):
        Spectrum(np.array(energies), np.array(fluence))


def test_kerma_outside_its_table_is_rejected():
    with pytest.raises(XrayError, match="air kerma is tabulated"):
        kerma_per_fluence(np.array([60.0]))


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
