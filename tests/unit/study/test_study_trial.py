"""A trial makes again only what its parameter touches, times that alone, and says why it failed."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from mammosim.chain.graph import Chain, Stage
from mammosim.core.errors import ConfigurationError, EquilibriumError
from mammosim.core.settings import read
from mammosim.study.accuracy import trial
from mammosim.study.accuracy.parameters import Entry, NumericalParameter, Repeats
from mammosim.study.accuracy.trial import Trial, needed, outcome_of, touched

COUNT: list[str] = []
SETTINGS = {"mesh": {"element_mm": 12.0}, "xray": {"dose_error_percent": 1.0, "energies": 20}}
REPEATS = Repeats(presses=1, others=3)


@dataclass(frozen=True)
class Subject:
    """Whose breast it is, with the repeat as its stream."""

    repeat: int = 0

    def repeated(self, repeat):
        return Subject(repeat)


def _counted(name, make):
    def counted(inputs):
        COUNT.append(name)
        return make(inputs)

    return counted


def _pressed(inputs):
    if inputs["mesh"] > 20:
        raise EquilibriumError("it slides away")
    return SimpleNamespace(row={"force_n": 1.0 + inputs["mesh"] ** 2})


def _dose(inputs):
    noise = inputs.subject.repeat / 10
    return SimpleNamespace(
        mgy_per_mas=inputs["pressed"].row["force_n"] + noise * inputs.setting("xray.dose_error_percent")
    )


STAGES = {
    "mesh": Stage(_counted("mesh", lambda i: i.setting("mesh.element_mm")), reads=("mesh",)),
    "pressed": Stage(_counted("pressed", _pressed), ("mesh",)),
    "exposure": Stage(
        _counted("exposure", lambda i: i.setting("xray.energies")), ("pressed",), ("xray.energies",)
    ),
    "dose": Stage(_counted("dose", _dose), ("pressed",), ("xray.dose_error_percent",)),
    "exposed_dose": Stage(
        lambda i: SimpleNamespace(dose_mgy=i["dose"].mgy_per_mas * i["exposure"]), ("dose", "exposure")
    ),
}


@pytest.fixture
def start(monkeypatch):
    COUNT.clear()
    monkeypatch.setattr(trial, "STAGES", STAGES)
    pressed = SimpleNamespace(row={"force_n": 145.0})
    chain = Chain(Subject(), SETTINGS, frozenset(), STAGES)
    return chain.given({"mesh": 12.0, "pressed": pressed})


def _trial(start, setting, values, quantities, *, of, kind="deterministic"):
    given = {"stage": "x", "quantities": quantities, "kind": kind, "setting": setting, "values": values}
    parameter = NumericalParameter.of("parameter", Entry.of(given | {"size": "value"}, "it"), SETTINGS)
    return Trial(start, read(NumericalParameter, parameter.alone(of), "it"), REPEATS)


def test_what_a_setting_changes_is_made_of_it_or_of_what_is(start):
    assert touched(STAGES, ["mesh.element_mm"]) == {"mesh", "pressed", "exposure", "dose", "exposed_dose"}
    assert touched(STAGES, ["mesh"]) == {"mesh", "pressed", "exposure", "dose", "exposed_dose"}
    assert touched(STAGES, ["xray.energies"]) == {"exposure", "exposed_dose"}
    assert needed(["force_n"]) == {"mesh", "pressed"}
    assert needed(["agd_percent"]) == set(STAGES)


def test_what_the_parameter_leaves_alone_is_not_made(start):
    rows = _trial(
        start, "xray.dose_error_percent", [1.0, 0.5], ["agd_percent"], of="0.5", kind="stochastic"
    ).rows()
    assert len(rows) == REPEATS.others
    assert "pressed" not in COUNT
    assert COUNT.count("dose") == REPEATS.others + 1, "and once to warm up"
    assert rows.answer_1.nunique() == REPEATS.others, "a repeat has streams of its own"


def test_a_press_is_made_once_and_its_time_counts_in_every_repeat(start):
    rows = _trial(start, "mesh.element_mm", [12.0, 6.0], ["force_n", "agd_percent"], of="6").rows()
    assert COUNT.count("pressed") == COUNT.count("mesh") == 1
    assert COUNT.count("dose") == REPEATS.others
    np.testing.assert_allclose(rows.answer_1[rows["quantity"] == "force_n"], 37)
    assert rows.seconds.min() >= 0
    assert list(rows.reference) == [True] * 6


def test_todays_press_is_timed_like_any_other(start):
    rows = _trial(start, "mesh.element_mm", [12.0, 6.0], ["force_n"], of="12").rows()
    assert COUNT.count("pressed") == REPEATS.presses
    np.testing.assert_allclose(rows.answer_1, 145.0)


def test_a_failure_is_a_row_with_its_reason_and_ends_the_repeats(start):
    rows = _trial(start, "mesh.element_mm", [24.0, 12.0], ["force_n"], of="24").rows()
    assert list(rows.outcome) == ["failed: it slides away"]
    assert np.isnan(rows.answer_1[0])
    assert COUNT.count("pressed") == 1


def test_an_outcome_tells_what_was_not_found_from_what_was_turned_away():
    assert outcome_of(EquilibriumError("it slides away")) == "failed: it slides away"
    assert outcome_of(EquilibriumError("it buckles", mode=np.ones((4, 3)))) == "unstable: it buckles"
    assert outcome_of(ConfigurationError("no such setting")) == "rejected: no such setting"
