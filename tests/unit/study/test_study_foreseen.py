"""What is bound to fail is said before the run."""

import copy
from pathlib import Path

import numpy as np
import pytest
import yaml

from mammosim.core.errors import ConfigurationError
from mammosim.io.tabulated import tabulated
from mammosim.study.jobs.foreseen import StrategyEnd, Study, foreseen

CONFIG = Path(__file__).parents[3] / "config"


@pytest.fixture
def study():
    """The published study: settings, strategies, systems."""
    settings = yaml.safe_load((CONFIG / "default.yaml").read_text())
    strategies = yaml.safe_load((CONFIG / "strategies.yaml").read_text())
    systems = tabulated("imaging_systems").set_index("system").to_dict("index")
    return copy.deepcopy((settings, strategies, systems))


def said(settings, strategies, systems):
    ends = {name: StrategyEnd.of(strategy) for name, strategy in strategies.items()}
    return foreseen(Study.of(settings), ends, systems)


def test_nothing_of_the_published_study_is_bound_to_fail(study):
    assert said(*study) == []


def test_a_beam_that_no_machine_has_is_named(study):
    settings, strategies, systems = study
    settings["xray"]["effects"].remove("paddle")
    (words,) = said(settings, strategies, systems)
    assert words.endswith("as they are with the paddle, since xray.effects lacks paddle")


def test_a_strategy_that_no_woman_can_bear_is_named(study):
    settings, strategies, systems = study
    strategies["squash"] = {"until": {"thickness_share": 0.3}}
    (small, large) = said(settings, strategies, systems)
    assert "squash would press small to 13.5 mm, and compression.smallest_mm is 20" in small
    assert "large to 18 mm" in large
    settings["compression"]["smallest_mm"] = 13.5
    assert said(settings, strategies, systems) == [], "the least that is allowed is allowed"


def test_a_pressure_that_is_not_stated_for_a_set_of_moduli_is_named(study):
    settings, strategies, systems = study
    strategies["pressure"] = {"until": {"pressure_kpa": {"gravity": 0.6}}}
    assert said(settings, strategies, systems) == [
        "the strategy pressure states no pressure_kpa for the moduli compression"
    ]


def test_a_system_that_lacks_a_key_is_named(study):
    settings, strategies, systems = study
    systems["hologic"]["pixel_mm"] = np.nan
    (words,) = said(settings, strategies, systems)
    assert words == "the system hologic lacks pixel_mm, so that it makes no slices"


def test_a_detector_smaller_than_the_plates_is_named(study):
    settings, strategies, systems = study
    settings["xray"]["field_mm"]["width"] = 100.0
    (words,) = said(settings, strategies, systems)
    assert "xray.field_mm.width = 100 holds no breast as wide as the plates" in words
    width, source = settings["compression"]["plate_mm"]["width"], settings["xray"]["source_to_detector_mm"]
    top = settings["xray"]["support_to_detector_mm"] + settings["compression"]["smallest_mm"]
    shadow = f"{width / (1 - top / source):.0f} mm"  # by similar triangles, wider than the plates
    assert f"whose shadow is {shadow}: images" in words


@pytest.mark.parametrize(
    ("group", "key", "value", "words"),
    [
        ("compression", "smallest_mm", float("nan"), "compression.smallest_mm = nan is not a finite number"),
        ("compression", "smallest_mm", -1.0, "compression.smallest_mm = -1 is outside"),
        ("compression", "moduli", "gravity", "compression.moduli = 'gravity'"),
        ("xray", "source_to_detector_mm", "650", "xray.source_to_detector_mm = '650'"),
        ("xray", "source_to_detector_mm", 30.0, "xray.source_to_detector_mm = 30 leaves no room"),
        ("xray", "source_to_detector_mm", 40.0, "xray.source_to_detector_mm = 40 leaves no room"),
    ],
)
def test_settings_of_which_nothing_can_be_foreseen_are_rejected_by_their_path(
    study, group, key, value, words
):
    settings = study[0]
    settings[group][key] = value
    with pytest.raises(ConfigurationError, match=words):
        Study.of(settings)
    del settings[group][key]
    with pytest.raises(ConfigurationError, match=f"no setting '{group}.{key}'; known beside it"):
        Study.of(settings)
