"""Numerical parameters read from their entries: values from draft to reference, and today's among them."""

import numpy as np
import pytest
import yaml

from mammosim.chain.quantities import QUANTITIES
from mammosim.core.errors import ConfigurationError
from mammosim.core.settings import read
from mammosim.study.accuracy.parameters import (
    AccuracySettings,
    Entry,
    NumericalParameter,
    Overrides,
    parameters,
)

SETTINGS = {"mesh": {"element_mm": {"breast": 12.0, "chest": 16.0}}, "xray": {"energies": 20, "filter": "Rh"}}

ABOUT = {"stage": "xray", "quantities": ["agd_percent"], "kind": "deterministic"}


def _parameter(**entry):
    return NumericalParameter.of("parameter", Entry.of(ABOUT | entry, "parameters.it"), SETTINGS)


def test_todays_value_is_marked_and_the_last_is_the_reference():
    parameter = _parameter(setting="xray.energies", values=[5, 20, 40], size="inverse")
    assert [value.name for value in parameter.values] == ["5", "20", "40"]
    assert [value.today for value in parameter.values] == [False, True, False]
    assert [value.reference for value in parameter.values] == [False, False, True]
    np.testing.assert_allclose([value.size for value in parameter.values], [1 / 5, 1 / 20, 1 / 40])


def test_todays_value_is_put_in_its_place_where_the_entry_lacks_it():
    parameter = _parameter(setting="xray.energies", values=[5, 40], size="inverse")
    assert [value.name for value in parameter.values] == ["5", "20", "40"]
    assert parameter.values[1].today
    finest = _parameter(setting="xray.energies", values=[5, 10], size="inverse")
    assert finest.values[-1].today
    assert finest.values[-1].reference
    word = _parameter(setting="xray.filter", values=["Al", "Ag"])
    assert [value.name for value in word.values] == ["Al", "Rh", "Ag"]


def test_a_value_may_set_several_keys_at_once():
    sizes = [{"breast": 24.0, "chest": 30.0}, {"breast": 12.0, "chest": 16.0}]
    parameter = _parameter(setting="mesh.element_mm", values=sizes, size="breast")
    assert [value.name for value in parameter.values] == ["24_30", "12_16"]
    assert [value.size for value in parameter.values] == [24, 12]
    both = _parameter(
        values=[{"xray.energies": 5, "xray.filter": "Al"}, {"xray.energies": 20, "xray.filter": "Rh"}]
    )
    assert [value.name for value in both.values] == ["5_Al", "20_Rh"]
    assert both.values[1].today


def test_what_a_trial_depends_on_is_its_value_and_the_draft_alone():
    parameter = _parameter(setting="xray.energies", values=[5, 20, 40], size="inverse")
    longer = _parameter(setting="xray.energies", values=[5, 20, 30, 40], size="inverse")
    assert parameter.alone("20") == longer.alone("20")
    again = read(NumericalParameter, parameter.alone("40"), "it")
    assert again.values == (parameter.values[0], parameter.values[2])


def test_a_value_that_is_not_there_is_rejected_with_those_that_are():
    with pytest.raises(ConfigurationError, match="has no value '7'; choose one of: 5, 20, 40"):
        _parameter(setting="xray.energies", values=[5, 20, 40]).value("7")


def test_every_parameter_of_the_study_is_read_with_todays_value(repository):
    configuration = yaml.safe_load((repository / "config/default.yaml").read_text())
    given = yaml.safe_load((repository / "config/accuracy/parameters.yaml").read_text())
    found = parameters(AccuracySettings.of(given).parameters, configuration)
    assert len(found) >= 14
    assert {parameter.stage for parameter in found.values()} >= {
        "images",
        "mesh",
        "mechanics",
        "compression",
        "xray",
    }
    for parameter in found.values():
        assert sum(value.today for value in parameter.values) == 1, parameter.name
        assert len({value.name for value in parameter.values}) == len(parameter.values) >= 2
        sizes = np.array([value.size for value in parameter.values], float)
        assert np.all(np.isnan(sizes)) or np.all(np.diff(sizes) < 0), (
            f"{parameter.name}: from draft to reference"
        )


def test_the_schema_knows_every_quantity(repository):
    schema = yaml.safe_load((repository / "workflow/schemas/accuracy.schema.yaml").read_text())
    assert any(each.get("enum") == list(QUANTITIES) for each in schema["$defs"].values())


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        (
            {"setting": "xray.energy", "values": [5, 20]},
            "no setting 'xray.energy'; known beside it: energies, f",
        ),
        ({"values": [5, 20], "quantities": ["dose"]}, "parameters.it: no quantity 'dose'"),
        ({"valus": [5, 20]}, "parameters.it has no key 'valus'"),
        ({}, "parameters.it lacks values"),
        ({"values": [5]}, "parameters.it: 1 values; give two at least, from draft to reference"),
        ({"values": 5}, "parameters.it.values = 5"),
        ({"values": [5, float("nan")]}, r"parameters.it.values\[1\]: .* is not plain and finite"),
        ({"values": [5, 20], "kind": "random"}, "kind = 'random': choose one of: deterministic, stochastic"),
        (
            {"setting": "xray", "values": [{"energies": 5}, {"filter": "Al"}], "size": "energies"},
            "no size 'energ",
        ),
        (
            {"values": [5, 20, 40], "sizes": [1, 2]},
            "parameters.it: 2 sizes for 3 values; give each one its size",
        ),
        ({"values": [5, 20], "sizes": [1, 0]}, r"parameters.it.sizes\[1\] = 0 is outside"),
        (
            {"values": [40, 5], "size": "inverse"},
            "parameter: sizes 0.05, 0.025, 0.2 do not fall from draft to r",
        ),
        ({"values": [5, 40], "size": "invers"}, "no size 'invers' in 5; choose one of: value, inverse"),
        ({"values": [5, 40], "sizes": [2, 1]}, "today's 20 is not among its values; add it, with its size"),
    ],
)
def test_an_entry_that_cannot_be_meant_is_rejected_by_its_path(entry, words):
    with pytest.raises(ConfigurationError, match=words):
        _parameter(**{"setting": "xray.energies"} | entry)


def test_values_that_set_different_settings_or_none_are_rejected():
    with pytest.raises(ConfigurationError, match="do not all set the same settings"):
        _parameter(values=[{"xray.energies": 5}, {"xray.filter": "Al"}])
    with pytest.raises(ConfigurationError, match=r"it.values\[0\]: '5' sets nothing; write dotted names"):
        _parameter(values=[5, 20])


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"repeats": {"presses": 0, "others": 3}}, "accuracy.repeats.presses = 0 is outside"),
        ({"load": {"position": "upright"}}, "accuracy.load lacks strategy; add it"),
        ({"presets": {"draft": {"force_n": -1.0}}}, "accuracy.presets.draft.force_n = -1 is outside"),
        ({"presets": {"draft": {"dose": 1.0}}}, "no quantity 'dose'"),
        ({"side": "middle"}, "accuracy.side = 'middle': choose one of: left, right"),
    ],
)
def test_settings_that_try_nothing_are_rejected_by_their_path(repository, changes, words):
    given = yaml.safe_load((repository / "config/accuracy/parameters_smoke.yaml").read_text())
    assert AccuracySettings.of(given).presets == {"draft": {"agd_percent": 20.0}}
    with pytest.raises(ConfigurationError, match=words):
        AccuracySettings.of(given | changes)


def test_overrides_hold_where_every_setting_has_their_value():
    element = {"mesh.element_mm": {"breast": 12.0, "chest": 16.0}}
    assert Overrides.of({"xray.energies": 20.0} | element, "it").hold_in(SETTINGS)
    assert not Overrides.of({"xray.energies": 20, "xray.filter": "Al"}, "it").hold_in(SETTINGS)
    assert not Overrides.of({"xray.pixel_mm": 1.0}, "it").hold_in(SETTINGS)
    with pytest.raises(ConfigurationError, match=r"'\{' sets nothing"):
        Overrides("{")
