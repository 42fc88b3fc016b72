"""The chosen settings are the cheapest of all that meet the tolerances, as trying every one shows."""

import itertools
import json

import numpy as np
import pandas as pd
import pytest
import yaml

from mammosim.core.errors import ConfigurationError
from mammosim.study.accuracy.preset_tables import choices, preset_text, presets
from mammosim.study.accuracy.presets import TIE, as_imaged, chosen, errors_at

T = 100.0


def _measured(knobs):
    """knobs: name -> (setting, [(value, {quantity: error}, seconds)]); the second value is today's."""
    rows = [
        {"stage": "chain", "knob": "chain", "value": "today", "quantity": q, "seconds": T, "today": True}
        for q in ("force_n", "agd_percent")
    ]
    for knob, (setting, values) in knobs.items():
        for number, (value, errors, seconds) in enumerate(values):
            about = {
                "stage": "x",
                "knob": knob,
                "value": str(value),
                "seconds": seconds,
                "today": number == 1,
            }
            about["settings"] = json.dumps({setting: value})
            rows += [about | {"quantity": q, "error": e} for q, e in errors.items()]
    return pd.DataFrame(rows).assign(outcome="ok", size=[3.0 - n for n in range(len(rows))])


@pytest.fixture
def knobs():
    rng = np.random.default_rng(3)
    found = {}
    for number in range(4):
        errors, seconds = np.sort(rng.uniform(0.1, 4, (3, 2)), axis=0)[::-1], np.sort(rng.uniform(1, 60, 3))
        values = [
            (float(n), {"force_n": e[0], "agd_percent": e[1]}, s)
            for n, (e, s) in enumerate(zip(errors, seconds))
        ]
        found[f"knob_{number}"] = (f"mesh.setting_{number}", values)
    return found


@pytest.mark.parametrize(
    "wanted", [{"force_n": 4.0}, {"force_n": 5.0, "agd_percent": 3.5}, {"agd_percent": 9.0}]
)
def test_nothing_cheaper_meets_the_tolerances(knobs, wanted):
    choice = chosen(_measured(knobs), wanted)
    cheapest = np.inf
    for pick in itertools.product(*(values for _, values in knobs.values())):
        total = {q: np.sqrt(sum(errors[q] ** 2 for _, errors, _ in pick)) for q in wanted}
        times = [(T - values[1][2] + s) / T for (_, values), (_, _, s) in zip(knobs.values(), pick)]
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
    assert (
        chosen(_measured({"photons": ("xray.photons", values)}), {"force_n": 2.0}).settings["xray.photons"]
        == 1.0
    )


def test_a_looser_tolerance_is_never_dearer(knobs):
    table = _measured(knobs)
    seconds = [chosen(table, {"force_n": tolerance}).seconds for tolerance in (3.0, 4.0, 5.0, 8.0)]
    assert seconds == sorted(seconds, reverse=True)


def test_what_cannot_be_met_is_refused_with_what_can(knobs):
    least = np.sqrt(sum(min(e["force_n"] for _, e, _ in values) ** 2 for _, values in knobs.values()))
    with pytest.raises(ConfigurationError, match=f"less than the least error that can be had, {least:.3g}"):
        chosen(_measured(knobs), {"force_n": 0.9 * least})


def test_tolerances_that_exclude_each_other_are_refused():
    values = [
        (0.0, {"force_n": 1.0, "agd_percent": 9.0}, 1.0),
        (1.0, {"force_n": 9.0, "agd_percent": 1.0}, 2.0),
    ]
    methods = _measured({"method": ("mechanics.method", values)}).assign(size=np.nan)  # neither is the finer
    with pytest.raises(ConfigurationError, match=r"no settings meet .* together"):
        chosen(methods, {"force_n": 2.0, "agd_percent": 2.0})


def test_unknown_quantities_and_impossible_tolerances_are_refused_by_name(knobs):
    table = _measured(knobs)
    with pytest.raises(
        ConfigurationError, match="no measured error of 'nipple_cm'; choose among: force_n, agd_percent"
    ):
        chosen(table, {"nipple_cm": 1.0})
    with pytest.raises(ConfigurationError, match="0 is no tolerance"):
        chosen(table, {"force_n": 0.0})
    with pytest.raises(ConfigurationError, match="no accuracy is asked"):
        chosen(table, {})


def test_a_refused_value_is_never_chosen(knobs):
    table = _measured(knobs)
    free = chosen(table, {"force_n": 20.0})
    name = next(iter(free.table.value[free.table.knob == "knob_0"]))
    table.loc[(table.knob == "knob_0") & (table.value == name), "outcome"] = "refused: it slides away"
    again = chosen(table, {"force_n": 20.0})
    assert name not in set(again.table.value[again.table.knob == "knob_0"])


def test_knobs_that_no_asked_quantity_depends_on_stay_as_they_are(knobs):
    knobs["observer"] = ("xray.images", [(10, {"agd_percent": 1.0}, 1.0), (20, {"agd_percent": 0.5}, 2.0)])
    assert "xray.images" not in chosen(_measured(knobs), {"force_n": 9.0}).settings
    assert "xray.images" in chosen(_measured(knobs), {"agd_percent": 9.0}).settings


def test_the_file_of_a_preset_holds_its_settings_and_their_errors():
    values = [
        ({"breast": 24.0, "chest": 30.0}, {"force_n": 3.0}, 2.0),
        ({"breast": 12.0, "chest": 16.0}, {"force_n": 1.0}, 9.0),
    ]
    newton = [(0.1, {"force_n": 0.5}, 1.0), (1e-8, {"force_n": 0.0}, 2.0)]
    table = _measured(
        {"element": ("mesh.element_mm", values), "newton": ("mechanics.newton_tolerance", newton)}
    )
    text = preset_text("draft", chosen(table, {"force_n": 1.05}))
    read = yaml.safe_load(text)
    assert read == {
        "mesh": {"element_mm": {"breast": 12.0, "chest": 16.0}},
        "mechanics": {"newton_tolerance": 1e-8},
    }
    assert "element_mm: {breast: 12.0, chest: 16.0} # force_n 1" in text
    assert text.startswith("# Preset draft: force_n 1;")


def test_a_preset_that_cannot_be_met_is_a_row_that_says_why(knobs):
    limits = {"draft": {"force_n": 9.0}, "perfect": {"force_n": 1e-6}}
    made = choices(_measured(knobs), limits)
    table = presets(made, limits)
    assert preset_text("perfect", made["perfect"]).startswith("# Preset perfect was refused: force_n: 1e-06")
    assert (table[table.preset == "draft"].outcome == "ok").all()
    (row,) = table[table.preset == "perfect"].itertuples()
    assert row.outcome.startswith("refused: force_n: 1e-06 is less than")


def test_the_error_of_settings_is_that_of_all_their_knobs_and_unknown_for_what_was_not_tried(knobs):
    measured = _measured(knobs)
    today = {"mesh": {f"setting_{number}": 1.0 for number in range(4)}}
    expected = np.sqrt(sum(values[1][1]["force_n"] ** 2 for _, values in knobs.values()))
    assert errors_at(measured, today, ["force_n"])["force_n"] == pytest.approx(expected)
    today["mesh"]["setting_2"] = 17.0
    assert np.isnan(errors_at(measured, today, ["force_n"])["force_n"])
    assert np.isnan(errors_at(measured, today, ["d_percent"])["d_percent"])


def test_where_images_are_labelled_already_their_knobs_stay_and_count(knobs):
    measured = _measured(knobs)
    measured.loc[measured.knob == "knob_0", "stage"] = "images"
    choice = chosen(as_imaged(measured), {"force_n": 100.0})
    today = knobs["knob_0"][1][1]
    assert choice.settings["mesh.setting_0"] == today[0]
    assert choice.errors["force_n"] >= today[1]["force_n"]
