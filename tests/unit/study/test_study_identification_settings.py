"""What a fit is told: the study's own settings are read, what cannot be meant is rejected by key."""

import copy
from pathlib import Path

import numpy as np
import pytest
import yaml

from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import read
from mammosim.study.identification.moduli import KEYS, Materials
from mammosim.study.identification.settings import FitSettings, Grid, Identification, Prior

REPOSITORY = Path(__file__).parents[3]
CONFIG = yaml.safe_load((REPOSITORY / "config/default.yaml").read_text())["identification"]
SETTINGS = {key: value for key, value in CONFIG.items() if key != "grid"}


def changed(values, place, value):
    """A copy with another value at a.b.c, or without that key where the value is None."""
    values = copy.deepcopy(values)
    *path, last = place.split(".")
    inner = values
    for key in path:
        inner = inner[key]
    if value is None:
        del inner[last]
    else:
        inner[last] = value
    return values


def test_the_settings_of_the_study_are_read():
    settings = read(Identification, SETTINGS, "identification")
    assert settings.prior.mean[:8] == pytest.approx(
        [np.log(CONFIG["prior"]["median_kpa"][t]) for _, t in KEYS]
    )
    assert settings.errors.marker_mm == CONFIG["errors"]["marker_mm"]
    assert (settings.draws, settings.fascia_mm) == (CONFIG["draws"], CONFIG["fascia_mm"])
    assert read(Prior, CONFIG["prior"], "prior") == settings.prior
    assert list(read(Grid, CONFIG["grid"], "grid").skin_kpa) == CONFIG["grid"]["skin_kpa"]


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        ("prior.median_kpa.skin", None, r"identification\.prior: median_kpa lacks skin"),
        ("prior.median_kpa.fascia", 100.0, "median_kpa has no key 'fascia'; choose one of: adipose"),
        ("prior.median_kpa.muscle", -1.0, r"prior\.median_kpa\.muscle = -1 is outside \(0, 100000\]"),
        ("prior.median_kpa.muscle", 3e7, r"is outside \(0, 100000\]; was it given in Pa\?"),
        ("prior.factor.adipose", 1.0, r"factor\.adipose = 1 is outside \(1, "),
        ("prior.poisson_ratio", [0.5, 0.01], r"poisson_ratio\[0\] = 0\.5 is outside \[0, 0\.5\)"),
        ("prior.poisson_ratio", [0.48, 0.0], r"poisson_ratio\[1\] = 0 is outside \(0, "),
        ("prior.poisson_ratio", [0.48], "poisson_ratio has 1 values; write 2"),
        ("prior.shift_mm", 0.0, r"shift_mm = 0 is outside \(0, "),
        ("prior.shft_mm", 0.2, r"identification\.prior has no key 'shft_mm'; did you mean 'shift_mm'"),
        ("errors.skin_mm", 0.0, r"identification\.errors\.skin_mm = 0 is outside \(0, "),
        ("model_error.skn", 0.3, "model_error has no key 'skn'; choose one of: .*skin"),
        ("draws", 0, r"identification\.draws = 0 is outside \[1, "),
        ("fascia_mm", 0.0, r"fascia_mm = 0 is outside \(0, 10\]; it has about 0\.1 mm"),
        ("errors", None, "identification lacks errors; add it"),
    ],
)
def test_what_cannot_be_meant_is_rejected_by_key(place, value, words):
    with pytest.raises(ConfigurationError, match=words):
        read(Identification, changed(SETTINGS, place, value), "identification")


def test_a_grid_without_moduli_and_a_fit_without_iterations_are_rejected():
    with pytest.raises(ConfigurationError, match=r"grid: skin_kpa is empty; write one modulus"):
        read(Grid, {"breast_kpa": [1.0], "skin_kpa": []}, "grid")
    with pytest.raises(ConfigurationError, match=r"breast_kpa\[0\] = 0 is outside"):
        read(Grid, {"breast_kpa": [0.0], "skin_kpa": [1.0]}, "grid")
    with pytest.raises(ConfigurationError, match=r"max_iterations = 0 is outside \[1, "):
        FitSettings(max_iterations=0)


@pytest.mark.parametrize("file", sorted((REPOSITORY / "config/tissues").glob("*.yaml")), ids=lambda f: f.stem)
def test_every_file_of_tissues_becomes_materials_and_plain_values_again(file):
    given = yaml.safe_load(file.read_text())
    materials = read(Materials, given, "tissues")
    assert materials.setting() == given
    assert materials.tissues["adipose"].density_g_cm3 == 0.95


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        ("skin", None, "tissues lacks skin; add it"),
        ("tissues.muscle", None, "tissues has adipose, glandular; write adipose, glandular, muscle"),
        ("tissues.glandular.poisson_ratio", 0.5, r"\.glandular: poisson_ratio = 0\.5 is outside \[0, 0\.5\)"),
        ("tissues.adipose.youngs_modulus_kpa", 1e6, r"\.adipose: .* was it given in Pa"),
        ("skin.thickness_mm", 0.0, r"skin: thickness_mm .* is outside \(0, 10\]"),
        ("skin.thickness", 1.0, "skin has no key 'thickness'; did you mean 'thickness_mm'"),
    ],
)
def test_tissues_that_cannot_be_meant_are_rejected_by_name(place, value, words):
    standard = yaml.safe_load((REPOSITORY / "config/tissues/standard.yaml").read_text())
    with pytest.raises(ConfigurationError, match=words):
        read(Materials, changed(standard, place, value), "tissues")
