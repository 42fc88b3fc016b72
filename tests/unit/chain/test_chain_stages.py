"""What an effect does to the first product that has it: moduli, parts of the body, photons of the beam."""

import pytest

from mammosim.chain.graph import Chain
from mammosim.chain.stages import STAGES
from mammosim.core.labels import Label
from mammosim.mechanics.body import Fascia, Ligaments, Skin
from mammosim.xray.quality import Paddle
from mammosim.xray.tube import tube_spectrum

SETTINGS = {
    "tissues": {
        "tissues": {
            "adipose": {"youngs_modulus_kpa": 1.0, "poisson_ratio": 0.45, "density_g_cm3": 0.95},
            "glandular": {"youngs_modulus_kpa": 2.0, "poisson_ratio": 0.45, "density_g_cm3": 1.02},
            "muscle": {"youngs_modulus_kpa": 30.0, "poisson_ratio": 0.45, "density_g_cm3": 1.05},
        },
        "skin": {"youngs_modulus_kpa": 10.0, "poisson_ratio": 0.45, "thickness_mm": 1.45},
    },
    "effects": {
        "fascia": {"youngs_modulus_kpa": 120.0, "poisson_ratio": 0.45, "thickness_mm": 0.1},
        "ligaments": {"stiffness_kpa": 1.0},
    },
    "xray": {
        "anode": "W",
        "filter": "Rh",
        "filter_um": 50.0,
        "peak_kv": 28.0,
        "paddle": {"plastic": "polycarbonate", "thickness_mm": 2.5},
        "energies": 20,
    },
}


def chain(*effects):
    return Chain(None, SETTINGS, frozenset(effects), STAGES)


def moduli(*effects):
    return {label: t.youngs_modulus_kpa for label, t in chain(*effects)["body"].tissues.items()}


def test_without_its_effect_gland_or_muscle_is_as_stiff_as_fat():
    assert set(moduli().values()) == {1.0}
    assert moduli("gland") == {Label.ADIPOSE: 1.0, Label.GLANDULAR: 2.0, Label.MUSCLE: 1.0}
    assert moduli("gland", "muscle")[Label.MUSCLE] == 30.0


def test_skin_fascia_and_ligaments_are_parts_that_are_there_or_not():
    assert chain()["body"].parts == ()
    assert chain("skin")["body"].parts == (Skin(10.0, 0.45, 1.45),)
    every = chain("ligaments", "skin", "fascia")["body"].parts
    assert every == (Skin(10.0, 0.45, 1.45), Fascia(120.0, 0.45, 0.1, boundary="skin"), Ligaments(1.0))


@pytest.fixture(scope="module")
def tube():
    return tube_spectrum("W", "Rh", 0.05, 28.0)


def test_without_many_energies_all_photons_have_their_mean_energy(tube):
    one = chain("paddle")["spectrum"]
    behind = Paddle("polycarbonate", 2.5)(tube)
    assert one.energies_kev == pytest.approx([behind.mean_energy_kev])
    assert one.fluence.sum() == pytest.approx(behind.fluence.sum())


def test_twenty_energies_keep_photons_and_energy_and_no_paddle_leaves_the_tubes_own_beam(tube):
    beam = chain("polychromatic")["spectrum"]
    assert len(beam.energies_kev) <= 20
    assert beam.fluence.sum() == pytest.approx(tube.fluence.sum())
    assert beam.mean_energy_kev == pytest.approx(tube.mean_energy_kev)
