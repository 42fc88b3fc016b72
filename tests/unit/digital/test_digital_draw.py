"""Digital volunteers drawn at random: within what was asked, the same each time, and refused by name."""

import numpy as np
import pytest
import yaml

from mammosim.core.errors import ConfigurationError, EquilibriumError
from mammosim.digital import draw
from mammosim.digital.build import Build
from mammosim.digital.draw import Ranges, drawn_woman, first_accepted, refusal


@pytest.fixture(scope="module")
def ranges(repository):
    return Ranges(**yaml.safe_load((repository / "config/recovery.yaml").read_text())["ranges"])


@pytest.fixture(scope="module")
def drawn(women, ranges):
    """Four hundred women."""
    between = (women["small"], women["large"])
    return [drawn_woman(ranges, between, stream=(1, "made", i)) for i in range(400)]


def test_a_stream_gives_the_same_woman_each_time(women, ranges):
    between = (women["small"], women["large"])
    one, same, other = (drawn_woman(ranges, between, stream=(1, name)) for name in "aab")
    assert one == same
    assert one["moduli_kpa"] != other["moduli_kpa"]


def test_a_build_lies_between_the_two_women(women, drawn):
    for woman in drawn:
        Build.from_parameters(woman)
        for part in ("chest", "breast", "gland", "skin"):
            for name, value in woman[part].items():
                low, high = sorted(women[w][part][name] for w in ("small", "large"))
                assert low <= value <= high


def test_moduli_and_their_ratios_keep_within_the_ranges(ranges, drawn):
    for woman in drawn:
        left, right = woman["moduli_kpa"]["left"], woman["moduli_kpa"]["right"]
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


def test_half_of_the_moduli_lie_below_the_geometric_mean(ranges, drawn):
    # A binomial share of 400 has a standard error of 0.025; the stream is fixed, three of them are allowed.
    for name in ("adipose", "skin", "muscle"):
        middle = np.sqrt(np.prod(getattr(ranges, f"{name}_kpa")))
        below = np.mean([woman["moduli_kpa"]["left"][name] < middle for woman in drawn])
        assert below == pytest.approx(0.5, abs=0.075), name


def test_the_gland_and_the_lungs_are_her_own(drawn):
    assert len({woman["seed"] for woman in drawn}) == len(drawn)


def test_reversed_ranges_are_refused(ranges):
    with pytest.raises(ConfigurationError, match="skin_kpa from 20 to 6"):
        Ranges(**{**vars(ranges), "skin_kpa": (20.0, 6.0)})


def test_a_woman_without_a_stable_state_is_refused_by_position_and_reason(monkeypatch, anatomy):
    def load(anatomy, mesh, gravity, **_):
        if gravity[1] > 0:
            raise EquilibriumError("stability is lost at load factor 0.4")

    monkeypatch.setattr(draw, "load_truth", load)
    prone, supine = np.array([0, -1.0, 0]), np.array([0, 1.0, 0])
    assert refusal(anatomy, None, None, {"prone": prone}) == ""
    why = refusal(anatomy, None, None, {"prone": prone, "supine": supine})
    assert why == "supine: stability is lost at load factor 0.4"


def test_the_first_draw_that_is_not_refused_is_taken_and_the_others_named():
    woman, reasons = first_accepted([{"n": 1}, {"n": 2}, {"n": 3}], lambda w: "soft" if w["n"] < 2 else "")
    assert woman == {"n": 2}
    assert reasons == ["soft", ""]
    with pytest.raises(ConfigurationError, match="each of 2 draws was refused: soft; soft"):
        first_accepted([{"n": 1}, {"n": 1}], lambda _: "soft")
