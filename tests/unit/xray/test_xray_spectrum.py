"""Spectra: what is conserved, what is rejected."""

import numpy as np
import pytest

from mammosim.core.errors import XrayError
from mammosim.xray.attenuation import material
from mammosim.xray.spectrum import Spectrum, kerma_per_fluence, monoenergetic, value_layer
from mammosim.xray.tube import Tube, tube_spectrum


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
