"""Materials and how they attenuate."""

import numpy as np
import pytest

from mammosim.core.errors import XrayError
from mammosim.xray.attenuation import Material, linear_attenuation, material, materials, mixture

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
