"""Knobs read from their entries: values from draft to reference, and today's among them."""

import numpy as np
import pytest
import yaml

from mammosim.chain.quantities import QUANTITIES
from mammosim.core.errors import ConfigurationError
from mammosim.study.accuracy.knobs import Knob, knobs

SETTINGS = {"mesh": {"element_mm": {"breast": 12.0, "chest": 16.0}}, "xray": {"energies": 20, "filter": "Rh"}}


def _knob(**entry):
    about = {"stage": "xray", "quantities": ["agd_percent"], "kind": "deterministic"}
    return Knob.of("knob", about | entry, SETTINGS)


def test_todays_value_is_marked_and_the_last_is_the_reference():
    knob = _knob(setting="xray.energies", values=[5, 20, 40], size="inverse")
    assert [value.name for value in knob.values] == ["5", "20", "40"]
    assert [value.today for value in knob.values] == [False, True, False]
    assert [value.reference for value in knob.values] == [False, False, True]
    np.testing.assert_allclose([value.size for value in knob.values], [1 / 5, 1 / 20, 1 / 40])


def test_todays_value_is_put_in_its_place_where_the_entry_lacks_it():
    knob = _knob(setting="xray.energies", values=[5, 40], size="inverse")
    assert [value.name for value in knob.values] == ["5", "20", "40"]
    assert knob.values[1].today
    finest = _knob(setting="xray.energies", values=[5, 10], size="inverse")
    assert finest.values[-1].today
    assert finest.values[-1].reference
    word = _knob(setting="xray.filter", values=["Al", "Ag"])
    assert [value.name for value in word.values] == ["Al", "Rh", "Ag"]


def test_a_value_may_set_several_keys_at_once():
    sizes = [{"breast": 24.0, "chest": 30.0}, {"breast": 12.0, "chest": 16.0}]
    knob = _knob(setting="mesh.element_mm", values=sizes, size="breast")
    assert [value.name for value in knob.values] == ["24_30", "12_16"]
    assert [value.size for value in knob.values] == [24, 12]
    both = _knob(
        values=[{"xray.energies": 5, "xray.filter": "Al"}, {"xray.energies": 20, "xray.filter": "Rh"}]
    )
    assert [value.name for value in both.values] == ["5_Al", "20_Rh"]
    assert both.values[1].today


def test_what_a_trial_depends_on_is_its_value_and_the_draft_alone():
    knob = _knob(setting="xray.energies", values=[5, 20, 40], size="inverse")
    longer = _knob(setting="xray.energies", values=[5, 20, 30, 40], size="inverse")
    assert knob.alone("20") == longer.alone("20")
    again = Knob.plain(knob.alone("40"))
    assert again.values == (knob.values[0], knob.values[2])


def test_what_is_misspelt_is_refused_by_name():
    with pytest.raises(
        ConfigurationError, match=r"no setting 'xray.energy'; known beside it: energies, filter"
    ):
        _knob(setting="xray.energy", values=[5, 20])
    with pytest.raises(ConfigurationError, match="no quantity 'dose'"):
        _knob(setting="xray.energies", values=[5, 20], quantities=["dose"])
    with pytest.raises(ConfigurationError, match="2 sizes for 3 values"):
        _knob(setting="xray.energies", values=[5, 20, 40], sizes=[1, 2])
    with pytest.raises(ConfigurationError, match="has no value '7'; choose one of: 5, 20, 40"):
        _knob(setting="xray.energies", values=[5, 20, 40]).value("7")


def test_every_knob_of_the_study_is_read_with_todays_value(repository):
    configuration = yaml.safe_load((repository / "config/default.yaml").read_text())
    given = yaml.safe_load((repository / "config/accuracy/knobs.yaml").read_text())["knobs"]
    found = knobs(given, configuration)
    assert len(found) >= 14
    assert {knob.stage for knob in found.values()} >= {"images", "mesh", "mechanics", "compression", "xray"}
    for knob in found.values():
        assert sum(value.today for value in knob.values) == 1, knob.name
        assert len({value.name for value in knob.values}) == len(knob.values) >= 2
        sizes = np.array([value.size for value in knob.values])
        assert np.all(np.isnan(sizes)) or np.all(np.diff(sizes) < 0), f"{knob.name}: from draft to reference"


def test_the_schema_knows_every_quantity(repository):
    schema = yaml.safe_load((repository / "workflow/schemas/accuracy.schema.yaml").read_text())
    assert any(each.get("enum") == list(QUANTITIES) for each in schema["$defs"].values())


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        (
            {"values": [40, 5], "size": "inverse"},
            "knob: sizes 0.05, 0.025, 0.2 do not fall from draft to reference; order its values",
        ),
        ({"values": [5, 40], "size": "invers"}, "no size 'invers' in 5; choose one of: value, inverse"),
        ({"values": [5, 40], "sizes": [2, 1]}, "today's 20 is not among its values; add it, with its size"),
    ],
)
def test_sizes_that_mean_nothing_are_refused(entry, words):
    with pytest.raises(ConfigurationError, match=words):
        _knob(setting="xray.energies", **entry)
