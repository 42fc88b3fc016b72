"""The presets of the study are what its measured curves give, and mean something as configuration."""

import copy

import pytest
import yaml

from mammosim.chain.configuration import check_settings
from mammosim.io.tables import read_commented
from mammosim.study.accuracy.preset_tables import preset_text
from mammosim.study.accuracy.presets import chosen

PRESETS = ("draft", "standard", "reference")


@pytest.fixture(scope="module")
def folder(repository):
    return repository / "config/accuracy"


@pytest.fixture(scope="module")
def measured(folder):
    return read_commented(folder / "measured.csv")


def _merged(base, over):
    for key, value in over.items():
        base[key] = _merged(base[key], value) if isinstance(value, dict) else value
    return base


@pytest.mark.parametrize("preset", PRESETS)
def test_the_file_of_a_preset_is_what_was_measured_gives(folder, measured, preset):
    limits = yaml.safe_load((folder / "knobs.yaml").read_text())["presets"]
    assert list(limits) == list(PRESETS)
    assert (folder / f"{preset}.yaml").read_text() == preset_text(preset, chosen(measured, limits[preset]))


@pytest.mark.parametrize("preset", PRESETS)
def test_a_preset_overrides_the_configuration_with_values_it_allows(repository, folder, preset):
    default = yaml.safe_load((repository / "config/default.yaml").read_text())
    over = yaml.safe_load((folder / f"{preset}.yaml").read_text())
    settings = _merged(copy.deepcopy(default), over)
    schema = yaml.safe_load((repository / "workflow/schemas/config.schema.yaml").read_text())
    check_settings(settings, schema, files=[preset])
    assert settings.keys() == default.keys()


def test_a_finer_preset_is_dearer_and_more_accurate(folder, measured):
    limits = yaml.safe_load((folder / "knobs.yaml").read_text())["presets"]
    choices = [chosen(measured, limits[preset]) for preset in PRESETS]
    assert choices[0].seconds < choices[1].seconds < choices[2].seconds
    for quantity in choices[0].errors:
        errors = [choice.errors[quantity] for choice in choices]
        assert errors[0] <= limits["draft"][quantity]
        assert errors[2] <= limits["reference"][quantity]
