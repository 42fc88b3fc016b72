"""What an effect does to the first product that has it, and where the products of the table are kept."""

from collections import Counter
from string import Formatter

import pytest
from small_breast import small_chain

from mammosim.chain.files import chain_of, job_inputs, job_outputs, nearest_kept
from mammosim.chain.graph import Chain
from mammosim.chain.image_chain import BEFORE, STEPS
from mammosim.chain.stages import IMAGE, MECHANICS, STAGES, XRAY
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


def test_the_effects_of_an_image_are_its_steps_in_the_order_in_which_they_act():
    assert (*BEFORE, *STEPS) == IMAGE


# What tells the files of a product apart: of the breast between the plates all of the last.
OF_PRESSED = {"v", "side", "strategy", "moduli", "also"}
APART = dict.fromkeys(XRAY, OF_PRESSED) | {
    "spectrum": {"also"},
    "mesh": {"v", "p", "also"},
    "mean_shape": {"v", "also"},
    "unloaded": {"v", "p", "method", "also"},
    "stress_free": {"v", "p", "also"},
    "loaded": {"v", "position", "also"},
    "standard_path": {"v", "side", "moduli", "also"},
    "pressed": OF_PRESSED,
}


@pytest.mark.parametrize("name", [name for name in (*MECHANICS, *XRAY) if STAGES[name].files])
def test_jobs_that_make_other_products_write_other_files(name):
    found = {field for _, field, _, _ in Formatter().parse(STAGES[name].files.stem) if field}
    assert found == APART[name]


PLACES = {
    **{"v": "ada", "p": "prone", "reference": "supine", "position": "upright", "side": "left"},
    **{"method": "anderson", "strategy": "standard", "moduli": "gravity", "also": ""},
    **{"strokes": "strokes.csv", "listed": "listed.csv", "given_labels": "labels.nii.gz"},
}


def test_no_two_products_are_kept_in_the_same_file():
    kept = [name for name, stage in STAGES.items() if stage.files]
    times = Counter(job_outputs(kept, PLACES).values())
    assert [path for path, n in times.items() if n > 1] == []


def test_a_job_writes_what_is_read_back_and_what_is_for_people_and_reads_only_the_former(repository):
    outputs = job_outputs(["pressed"], PLACES)
    assert {"pressed__shape", "pressed__row", "pressed__thickness", "seconds__pressed"} < set(outputs)
    inputs = job_inputs(["phantom"], PLACES, small_chain(repository))
    assert {name for name in inputs if name.startswith("pressed__")} == {
        *("pressed__shape", "pressed__row", "pressed__plates")
    }


def test_a_job_of_several_products_does_not_read_what_it_makes(repository):
    chain = small_chain(repository)
    assert "pressed" in nearest_kept(["phantom"], chain)
    assert set(nearest_kept(["pressed", "phantom"], chain)) == {
        *("transform", "labels", "fiducials", "mesh", "stress_free", "standard_path")
    }


def test_inputs_of_a_variant_are_those_of_the_variants_of_what_it_is_made_of(repository):
    called = {"pressed": "-01234567"}
    paths = job_inputs(["phantom"], PLACES, small_chain(repository), also=lambda name: called.get(name, ""))
    assert paths["pressed__row"] == "results/compression/ada/left/standard_gravity-01234567.csv"
    assert paths["mesh__mesh"] == "results/meshes/ada/prone.vtu"


def test_the_chain_of_a_job_has_its_effects_and_reads_its_inputs(repository):
    small = small_chain(repository)
    given = {
        "subject": {"side": "left", "gravity": "0 -1 0", "streams": [1, "ada", "left"]},
        "settings": small.settings,
        "effects": sorted(small.effects),
    }
    chain = chain_of(given, {"pressed__row": "a.csv", "pressed__shape": "a.vtu", "took": "b.json"})
    assert chain.effects == small.effects
    assert chain.files == {chain.key("pressed"): {"row": "a.csv", "shape": "a.vtu"}}
