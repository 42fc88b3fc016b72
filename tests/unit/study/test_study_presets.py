"""The chosen settings are the cheapest that meet the tolerances; the study's presets are chosen so."""

import copy
import itertools
import json

import numpy as np
import pandas as pd
import pytest
import yaml

from mammosim.chain.configuration import check_settings
from mammosim.chain.graph import nested
from mammosim.core.errors import ConfigurationError
from mammosim.io.tables import read_commented
from mammosim.study.accuracy.presets import (
    TIE,
    as_imaged,
    choices,
    chosen,
    errors_at,
    pace_at,
    preset_text,
    presets,
)

PRESETS = ("draft", "standard", "reference")
T = 100.0


def _measured(parameters):
    """parameters: name -> (setting, [(value, {quantity: error}, seconds)]); the second value is today's."""
    rows = [
        {"stage": "chain", "parameter": "chain", "value": "today", "quantity": q, "seconds": T, "today": True}
        for q in ("force_n", "agd_percent")
    ]
    for parameter, (setting, values) in parameters.items():
        for number, (value, errors, seconds) in enumerate(values):
            about = {"stage": "x", "parameter": parameter, "value": str(value), "seconds": seconds}
            about |= {"today": number == 1, "settings": json.dumps({setting: value})}
            rows += [about | {"quantity": q, "error": e} for q, e in errors.items()]
    return pd.DataFrame(rows).assign(outcome="converged", size=[3.0 - n for n in range(len(rows))])


@pytest.fixture
def parameters():
    rng = np.random.default_rng(3)
    found = {}
    for number in range(4):
        errors, seconds = np.sort(rng.uniform(0.1, 4, (3, 2)), axis=0)[::-1], np.sort(rng.uniform(1, 60, 3))
        pairs = enumerate(zip(errors, seconds))
        values = [(float(n), {"force_n": e[0], "agd_percent": e[1]}, s) for n, (e, s) in pairs]
        found[f"parameter_{number}"] = (f"mesh.setting_{number}", values)
    return found


@pytest.mark.parametrize(
    "wanted", [{"force_n": 4.0}, {"force_n": 5.0, "agd_percent": 3.5}, {"agd_percent": 9.0}]
)
def test_nothing_cheaper_meets_the_tolerances(parameters, wanted):
    choice = chosen(_measured(parameters), wanted)
    cheapest = np.inf
    for pick in itertools.product(*(values for _, values in parameters.values())):
        total = {q: np.sqrt(sum(errors[q] ** 2 for _, errors, _ in pick)) for q in wanted}
        times = [(T - values[1][2] + s) / T for (_, values), (_, _, s) in zip(parameters.values(), pick)]
        if all(total[q] <= wanted[q] for q in wanted):
            cheapest = min(cheapest, T * np.prod(times))
    assert cheapest <= choice.seconds * (1 + 1e-12)
    assert choice.seconds <= cheapest * np.exp(TIE * len(wanted)), "accuracy decides within TIE"
    assert all(choice.errors[q] <= wanted[q] for q in wanted)
    assert set(choice.settings) == {f"mesh.setting_{n}" for n in range(4)}


def test_a_coarser_value_that_is_nearer_by_luck_has_the_error_of_the_finer_one():
    values = [(0.0, {"force_n": 0.2}, 1.0), (1.0, {"force_n": 3.0}, 5.0), (2.0, {"force_n": 1.0}, 9.0)]
    choice = chosen(_measured({"voxels": ("xray.voxel_mm", values)}), {"force_n": 2.0})
    assert choice.settings == {"xray.voxel_mm": 2.0}
    assert choice.errors == {"force_n": 1.0}


def test_of_two_values_as_fast_the_more_accurate_is_taken():
    values = [(0.0, {"force_n": 1.0}, 10.0), (1.0, {"force_n": 0.1}, 10.0 + 1e-5)]
    choice = chosen(_measured({"photons": ("xray.photons", values)}), {"force_n": 2.0})
    assert choice.settings == {"xray.photons": 1.0}


def test_a_looser_tolerance_is_never_dearer(parameters):
    table = _measured(parameters)
    seconds = [chosen(table, {"force_n": tolerance}).seconds for tolerance in (3.0, 4.0, 5.0, 8.0)]
    assert seconds == sorted(seconds, reverse=True)


def test_what_cannot_be_met_is_rejected_with_what_can(parameters):
    least = np.sqrt(sum(min(e["force_n"] for _, e, _ in values) ** 2 for _, values in parameters.values()))
    with pytest.raises(ConfigurationError, match=f"less than the least error that can be had, {least:.3g}"):
        chosen(_measured(parameters), {"force_n": 0.9 * least})


def test_tolerances_that_exclude_each_other_are_rejected():
    forces, doses = {"force_n": 1.0, "agd_percent": 9.0}, {"force_n": 9.0, "agd_percent": 1.0}
    values = [(0.0, forces, 1.0), (1.0, doses, 2.0)]
    methods = _measured({"method": ("mechanics.method", values)}).assign(size=np.nan)  # neither is the finer
    with pytest.raises(ConfigurationError, match=r"no settings meet .* together"):
        chosen(methods, {"force_n": 2.0, "agd_percent": 2.0})


def test_unknown_quantities_and_impossible_tolerances_are_rejected_by_name(parameters):
    table = _measured(parameters)
    with pytest.raises(
        ConfigurationError, match="no measured error of 'nipple_cm'; choose among: force_n, agd_percent"
    ):
        chosen(table, {"nipple_cm": 1.0})
    with pytest.raises(ConfigurationError, match="0 is no tolerance"):
        chosen(table, {"force_n": 0.0})
    with pytest.raises(ConfigurationError, match="no accuracy is asked"):
        chosen(table, {})


def test_a_value_that_failed_is_never_chosen(parameters):
    table = _measured(parameters)
    free = chosen(table, {"force_n": 20.0})
    name = next(iter(free.table.value[free.table.parameter == "parameter_0"]))
    tried = (table.parameter == "parameter_0") & (table.value == name)
    table.loc[tried, "outcome"] = "failed: it slides away"
    again = chosen(table, {"force_n": 20.0})
    assert name not in set(again.table.value[again.table.parameter == "parameter_0"])


def test_parameters_that_no_asked_quantity_depends_on_stay_as_they_are(parameters):
    images = [(10, {"agd_percent": 1.0}, 1.0), (20, {"agd_percent": 0.5}, 2.0)]
    parameters["observer"] = ("xray.images", images)
    assert "xray.images" not in chosen(_measured(parameters), {"force_n": 9.0}).settings
    assert "xray.images" in chosen(_measured(parameters), {"agd_percent": 9.0}).settings


def test_the_file_of_a_preset_holds_its_settings_and_their_errors():
    values = [
        ({"breast": 24.0, "chest": 30.0}, {"force_n": 3.0}, 2.0),
        ({"breast": 12.0, "chest": 16.0}, {"force_n": 1.0}, 9.0),
    ]
    newton = [(0.1, {"force_n": 0.5}, 1.0), (1e-8, {"force_n": 0.0}, 2.0)]
    settings = {"element": ("mesh.element_mm", values), "newton": ("mechanics.newton_tolerance", newton)}
    table = _measured(settings)
    text = preset_text("draft", chosen(table, {"force_n": 1.05}))
    element = {"element_mm": {"breast": 12.0, "chest": 16.0}}
    assert yaml.safe_load(text) == {"mesh": element, "mechanics": {"newton_tolerance": 1e-8}}
    assert "element_mm: {breast: 12.0, chest: 16.0} # force_n 1" in text
    assert text.startswith("# Preset draft: force_n 1;")


def test_a_preset_that_cannot_be_met_is_a_row_that_says_why(parameters):
    limits = {"draft": {"force_n": 9.0}, "perfect": {"force_n": 1e-6}}
    made = choices(_measured(parameters), limits)
    table = presets(made, limits)
    assert preset_text("perfect", made["perfect"]).startswith("# Preset perfect was rejected: force_n: 1e-06")
    assert (table[table.preset == "draft"].outcome == "converged").all()
    (row,) = table[table.preset == "perfect"].itertuples()
    assert row.outcome.startswith("rejected: force_n: 1e-06 is less than")


def test_the_error_of_settings_is_that_of_all_their_parameters_and_unknown_for_what_was_not_tried(parameters):
    measured = _measured(parameters)
    today = {"mesh": {f"setting_{number}": 1.0 for number in range(4)}}
    expected = np.sqrt(sum(values[1][1]["force_n"] ** 2 for _, values in parameters.values()))
    assert errors_at(measured, today, ["force_n"])["force_n"] == pytest.approx(expected)
    today["mesh"]["setting_2"] = 17.0
    assert np.isnan(errors_at(measured, today, ["force_n"])["force_n"])
    assert np.isnan(errors_at(measured, today, ["d_percent"])["d_percent"])


def test_where_images_are_labelled_already_their_parameters_stay_and_count(parameters):
    measured = _measured(parameters)
    measured.loc[measured.parameter == "parameter_0", "stage"] = "images"
    choice = chosen(as_imaged(measured), {"force_n": 100.0})
    today = parameters["parameter_0"][1][1]
    assert choice.settings["mesh.setting_0"] == today[0]
    assert choice.errors["force_n"] >= today[1]["force_n"]


@pytest.fixture(scope="module")
def folder(repository):
    return repository / "config/accuracy"


@pytest.fixture(scope="module")
def curves(folder):
    return read_commented(folder / "measured.csv")


def _merged(base, over):
    for key, value in over.items():
        base[key] = _merged(base[key], value) if isinstance(value, dict) else value
    return base


@pytest.mark.parametrize("preset", PRESETS)
def test_the_file_of_a_preset_is_what_was_measured_gives(folder, curves, preset):
    limits = yaml.safe_load((folder / "parameters.yaml").read_text())["presets"]
    assert list(limits) == list(PRESETS)
    assert (folder / f"{preset}.yaml").read_text() == preset_text(preset, chosen(curves, limits[preset]))


@pytest.mark.parametrize("preset", PRESETS)
def test_a_preset_overrides_the_configuration_with_values_it_allows(repository, folder, preset):
    default = yaml.safe_load((repository / "config/default.yaml").read_text())
    over = yaml.safe_load((folder / f"{preset}.yaml").read_text())
    settings = _merged(copy.deepcopy(default), over)
    schema = yaml.safe_load((repository / "workflow/schemas/config.schema.yaml").read_text())
    check_settings(settings, schema, files=[preset])
    assert settings.keys() == default.keys()


def test_a_finer_preset_is_dearer_and_more_accurate(folder, curves):
    limits = yaml.safe_load((folder / "parameters.yaml").read_text())["presets"]
    choices = [chosen(curves, limits[preset]) for preset in PRESETS]
    assert choices[0].seconds < choices[1].seconds < choices[2].seconds
    for quantity in choices[0].errors:
        errors = [choice.errors[quantity] for choice in choices]
        assert errors[0] <= limits["draft"][quantity]
        assert errors[2] <= limits["reference"][quantity]


def test_the_pace_of_settings_is_that_of_what_was_measured(folder, curves):
    """A preset is as fast as when it was chosen, against today's; what was not measured counts as today's."""
    draft = yaml.safe_load((folder / "draft.yaml").read_text())
    today = curves[(curves.parameter == "chain") & (curves["quantity"] == "force_n")].seconds.iloc[0]
    assert pace_at(curves, {}, ["force_n"]) == 1
    pace = pace_at(curves, draft, ["force_n", "pressure_kpa"])  # of which the second was not measured
    assert 0 < pace < 1
    rows = curves[(curves["quantity"] == "force_n") & (curves.parameter == "element_size")]
    size = next(row for row in rows.itertuples() if not row.today)
    alone = pace_at(curves, nested(json.loads(size.settings)), ["force_n"])
    of_today = rows[rows.today].seconds.iloc[0]
    assert alone == pytest.approx((today - of_today + size.seconds) / today)
