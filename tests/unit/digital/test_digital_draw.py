"""Virtual patients sampled at random: within the ranges, the same each time, and given up by name."""

import numpy as np
import pytest
import yaml

from mammosim.core.errors import ConfigurationError, EquilibriumError
from mammosim.core.settings import read
from mammosim.digital import sampling
from mammosim.digital.patient import VirtualPatient
from mammosim.digital.sampling import Ranges, failure, first_stable, sampled_patient


@pytest.fixture(scope="module")
def ranges(repository):
    values = yaml.safe_load((repository / "config/recovery.yaml").read_text())["ranges"]
    return read(Ranges, values, "ranges")


@pytest.fixture(scope="module")
def between(patients):
    return patients["small"], patients["large"]


@pytest.fixture(scope="module")
def sampled(between, ranges):
    """Four hundred virtual patients."""
    return [sampled_patient(ranges, between, stream=(1, "made", i)) for i in range(400)]


def test_a_stream_gives_the_same_patient_each_time(between, ranges):
    one, same, other = (sampled_patient(ranges, between, stream=(1, name)) for name in "aab")
    assert one == same
    assert one.moduli_kpa != other.moduli_kpa


def test_a_build_lies_between_the_two_it_is_sampled_from(between, sampled):
    for patient in sampled:
        assert VirtualPatient.read(patient.values()) == patient
        for part in ("chest", "breast", "gland", "skin"):
            for name, value in vars(getattr(patient, part)).items():
                low, high = sorted(getattr(getattr(end, part), name) for end in between)
                assert low <= value <= high


def test_moduli_and_their_ratios_keep_within_the_ranges(ranges, sampled):
    for patient in sampled:
        left, right = vars(patient.moduli_kpa.left), vars(patient.moduli_kpa.right)
        middle = {name: np.sqrt(left[name] * right[name]) for name in left}
        quantities = {
            "adipose_kpa": [middle["adipose"]],
            "glandular_per_adipose": [middle["glandular"] / middle["adipose"]],
            "skin_kpa": [middle["skin"]],
            "muscle_kpa": [middle["muscle"]],
            "right_per_left": [right[name] / left[name] for name in left],
        }
        for name, values in quantities.items():
            low, high = getattr(ranges, name)
            assert all(low * (1 - 1e-9) <= value <= high * (1 + 1e-9) for value in values), name


def test_half_of_the_moduli_lie_below_the_geometric_mean(ranges, sampled):
    # A binomial share of 400 has a standard error of 0.025; the stream is fixed, three of them are allowed.
    for name in ("adipose", "skin", "muscle"):
        middle = np.sqrt(np.prod(getattr(ranges, f"{name}_kpa")))
        below = np.mean([getattr(patient.moduli_kpa.left, name) < middle for patient in sampled])
        assert below == pytest.approx(0.5, abs=0.075), name


def test_the_gland_and_the_lungs_are_her_own(sampled):
    assert len({patient.seed for patient in sampled}) == len(sampled)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"skin_kpa": [20.0, 6.0]}, r"ranges: skin_kpa from 20 to 6: give the lowest, above 0"),
        ({"skin_kpa": 6.0}, r"ranges\.skin_kpa = 6\.0 is no list"),
        ({"skin_kpa": [6.0]}, r"has \d values"),
        ({"skin": [6.0, 20.0]}, r"has no key 'skin'"),
    ],
)
def test_ranges_that_cannot_be_meant_are_rejected(ranges, change, words):
    with pytest.raises(ConfigurationError, match=words):
        read(Ranges, vars(ranges) | change, "ranges")


def test_a_patient_without_a_stable_state_fails_by_position_and_reason(monkeypatch, anatomy):
    def load(anatomy, mesh, gravity, **_):
        if gravity[1] > 0:
            raise EquilibriumError("stability is lost at load factor 0.4")

    monkeypatch.setattr(sampling, "load_truth", load)
    prone, supine = np.array([0, -1.0, 0]), np.array([0, 1.0, 0])
    assert failure(anatomy, None, None, {"prone": prone}) == ""
    why = failure(anatomy, None, None, {"prone": prone, "supine": supine})
    assert why == "supine: stability is lost at load factor 0.4"


def test_the_first_patient_that_does_not_fail_is_taken_and_the_others_named():
    patient, failures = first_stable([{"n": 1}, {"n": 2}, {"n": 3}], lambda w: "soft" if w["n"] < 2 else "")
    assert patient == {"n": 2}
    assert failures == ["soft", ""]
    with pytest.raises(ConfigurationError, match="each of 2 sampled patients failed: soft; soft"):
        first_stable([{"n": 1}, {"n": 1}], lambda _: "soft")
