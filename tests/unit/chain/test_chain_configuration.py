"""A configuration that cannot be meant is rejected, naming file, key, value, limit and next step."""

import pytest
import yaml

from mammosim.chain.configuration import (
    check_listed,
    check_settings,
    check_thicknesses,
    check_tissues,
    check_volunteers,
)
from mammosim.core.errors import ConfigurationError
from mammosim.core.positions import gravity_vector


@pytest.fixture
def schema(repository):
    return yaml.safe_load((repository / "workflow/schemas/config.schema.yaml").read_text())


@pytest.fixture
def settings(repository):
    return yaml.safe_load((repository / "config/default.yaml").read_text())


def rejection(settings, schema) -> str:
    with pytest.raises(ConfigurationError) as error:
        check_settings(settings, schema, files=["mine.yaml"])
    return str(error.value)


def test_the_published_study_is_accepted(settings, schema):
    check_settings(settings, schema, files=["config/default.yaml"])


def test_a_misspelt_key_is_named_with_what_was_meant(settings, schema):
    settings["mechanics"]["swep"] = {}
    message = rejection(settings, schema)
    assert message.startswith("mine.yaml")
    assert "mechanics has no key 'swep'; did you mean 'sweep'?" in message


def test_a_modulus_in_pascal_is_recognised(settings, schema):
    settings["mechanics"]["sweep"]["youngs_modulus_kpa"] = [500.0]
    message = rejection(settings, schema)
    assert "mechanics.sweep.youngs_modulus_kpa.0 = 500.0: must be at most 90" in message
    assert "given in Pa? Divide by 1000" in message


def test_a_thickness_in_centimetres_is_recognised(settings, schema):
    settings["compression"]["thickness_mm"]["small"] = 4.5
    message = rejection(settings, schema)
    assert "compression.thickness_mm.small = 4.5: must be at least 15" in message
    assert "was it given in cm? Multiply by 10" in message


def test_an_incompressible_poisson_ratio_is_rejected(settings, schema):
    settings["mechanics"]["sweep"]["poisson_ratio"] = 0.5
    assert "poisson_ratio = 0.5: must be less than 0.5" in rejection(settings, schema)


def test_every_problem_is_reported_at_once(settings, schema):
    settings["sede"] = 1
    settings["xray"]["peak_kv"] = 120
    message = rejection(settings, schema)
    assert "did you mean 'seed'?" in message
    assert "xray.peak_kv = 120: must be at most 40" in message


def table(**change) -> list[dict[str, str]]:
    rows = [
        {"volunteer": "a", "position": "prone", "gravity": "0 -1 0"},
        {"volunteer": "a", "position": "supine", "gravity": "0 1 0"},
    ]
    return [rows[0] | change, rows[1]]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"gravity": "0 1 0"}, "contradicts 'prone'"),
        ({"gravity": "down"}, "write three numbers"),
        ({"position": "sitting"}, "choose one of: prone, supine"),
        ({"position": "supine", "gravity": "0 1 0"}, "stand twice"),
        ({"volunteer": "b"}, "lacks"),
    ],
)
def test_a_volunteer_table_that_contradicts_itself_is_rejected(change, words):
    with pytest.raises(ConfigurationError, match=words):
        check_volunteers(table(**change), file="volunteers.tsv", reference_position="supine")


def test_gravity_is_normalised():
    assert gravity_vector("0 -2 0").tolist() == [0.0, -1.0, 0.0]


def test_a_tissue_without_parameters_is_named():
    with pytest.raises(
        ConfigurationError, match="no parameters for tissue 'glandular'; add youngs_modulus_kpa"
    ):
        check_tissues(["adipose", "muscle"], ["adipose", "glandular", "muscle"], file="standard.yaml")


def test_a_volunteer_without_thickness_or_without_rows_is_named():
    with pytest.raises(ConfigurationError, match=r"compression\.thickness_mm lacks ada"):
        check_thicknesses({"small": 45.0}, ["small", "ada"])
    table = [{"volunteer": "small"}, {"volunteer": "large"}]
    with pytest.raises(ConfigurationError, match=r"my\.tsv has no row of 'ada', .* rows of: small, large"):
        check_listed(table, ["small", "ada"], file="my.tsv")
