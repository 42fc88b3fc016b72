"""What is kept of a model whose answers are known: additive, with effects that matter together, with none."""

import numpy as np
import pytest

from mammosim.core.errors import ConfigurationError, MechanicsError
from mammosim.study.scenes.screening import COLUMNS, Answer, Rule, Screening

SIZES = {"large": 3.0, "middle": 0.2, "small": 0.05, "tiny": 0.01}


def additive(effects, reference):
    """Each effect that only one of both has moves the answer by its size, and takes a second."""
    return Answer({"q": sum(SIZES[e] for e in effects ^ reference)}, seconds=len(effects))


def screening(answers, *, tolerance=1.0, needed=(), full=SIZES, **rule):
    return Screening("scene", frozenset(full), frozenset(needed), {"q": tolerance}, answers, Rule(**rule))


def kept(answers, **settings):
    table, _ = screening(answers, **settings).tables()
    return set(table.effect[table.included])


def test_an_effect_is_kept_where_it_moves_the_answer_by_more_than_the_part_of_its_tolerance():
    assert kept(additive, part=0.25, joint_part=0.5) == {"large"}
    assert kept(additive, part=0.25, joint_part=0.5, tolerance=0.5) == {"large", "middle"}
    assert kept(additive, part=0.25, joint_part=0.5, tolerance=100.0) == set()


def test_all_that_goes_at_once_stays_within_the_joint_part_and_the_most_important_comes_back_first():
    # middle, small and tiny move 0.26 together, each alone less than 0.25
    assert kept(additive, part=0.25, joint_part=0.25, pairs=0) == {"large", "middle"}


def test_two_that_matter_only_together_are_found_and_the_more_important_one_is_kept():
    def together(effects, reference):
        more = 1.0 if not {"middle", "small"} & effects else 0.0
        return Answer({"q": additive(effects, reference).changes["q"] + more}, seconds=1)

    table, joint = screening(together, part=0.25, joint_part=5.0).tables()
    table = table.set_index("effect")
    assert set(table.index[table.included]) == {"large", "middle"}
    assert "alone it may go, but without it and small" in table.reason["middle"]
    assert joint.change[joint.effects == "middle, small"].iloc[0] == pytest.approx(1.25)
    assert "middle" not in kept(together, part=0.25, joint_part=5.0, pairs=0)


def test_what_matters_to_the_model_that_is_left_comes_back():
    def only_without_the_others(effects, reference):
        """Small acts where neither middle nor tiny do: it is harmless in the full model."""
        acts = ["small" in each and not {"middle", "tiny"} & each for each in (effects, reference)]
        return Answer({"q": additive(effects, reference).changes["q"] + (acts[0] != acts[1])}, seconds=1)

    table, joint = screening(only_without_the_others, pairs=0).tables()
    row = table.set_index("effect").loc["small"]
    assert row.included
    assert row.reason.startswith("it may go, but with it what is left q moves by 1.1")
    assert row.change_added == pytest.approx(1.05)
    assert set(joint.tried) == {"together", "added"}


def test_an_effect_that_is_added_back_is_judged_by_its_own_part_and_not_by_the_joint_one():
    def acts_when_added(effects, reference):
        """Small moves the answer by 0.4 where neither middle nor tiny act: between the two parts."""
        acts = ["small" in each and not {"middle", "tiny"} & each for each in (effects, reference)]
        return Answer({"q": 0.4 if acts[0] != acts[1] else 0.01}, seconds=1)

    assert "small" in kept(acts_when_added, part=0.25, joint_part=0.5, pairs=0)
    assert "small" not in kept(acts_when_added, part=0.45, joint_part=0.5, pairs=0)


def test_added_to_what_is_left_an_effect_of_an_additive_model_does_what_leaving_it_out_does():
    table = screening(additive).tables()[0].set_index("effect")
    assert table.change_added["small"] == table.change["small"]
    assert np.isnan(table.change_added["large"])


def test_without_an_answer_an_effect_is_kept_for_that_reason():
    def slides(effects, reference):
        if "tiny" not in effects:
            return Answer({}, 1.0, failure="it slides away")
        return additive(effects, reference)

    table = screening(slides).tables()[0].set_index("effect")
    assert table.included["tiny"]
    assert table.reason["tiny"] == "without it there is no answer: it slides away"
    assert np.isnan(table.change["tiny"])


def test_what_is_needed_is_kept_untried():
    tried = []

    def recorded(effects, reference):
        tried.append(effects)
        return additive(effects, reference)

    assert kept(recorded, needed={"tiny"}) == {"large", "tiny"}
    assert all("tiny" in effects for effects in tried)


def test_a_full_model_without_an_answer_is_said():
    with pytest.raises(
        MechanicsError, match=r"scene scene: the full model has no answer .*: it slides away; screen on"
    ):
        screening(lambda *_: Answer({}, 1.0, failure="it slides away")).tables()


def test_rows_hold_change_tolerance_and_the_seconds_that_leaving_it_out_saves():
    table, _ = screening(additive).tables()
    assert list(table.columns) == COLUMNS
    row = table.set_index("effect").loc["middle"]
    assert (row.change, row.tolerance, row.seconds) == (0.2, 1.0, 1.0)


def test_a_change_within_its_noise_is_said_to_be_insignificant():
    def noisy(effects, reference):
        return Answer(additive(effects, reference).changes, 1.0, {"q": 0.12})

    reasons = screening(noisy).tables()[0].set_index("effect").reason
    assert "not significant" in reasons["middle"]
    assert "not significant" not in reasons["large"]


def test_an_effect_that_the_noise_could_hide_is_kept():
    def noisy(effects, reference):
        return Answer(additive(effects, reference).changes, 1.0, {"q": 0.2})

    table = screening(noisy).tables()[0].set_index("effect")
    assert table.included.all(), "2 x 0.2 is more than 0.25"
    assert table.reason["tiny"].startswith("too noisy to tell: without it q moves by 0.01")


def test_the_worst_of_several_answers_decides():
    def two(effects, reference):
        changed = 9.0 if "tiny" in effects ^ reference else 0.0
        return Answer({"q": additive(effects, reference).changes["q"], "r": changed}, 1.0)

    both = Screening("s", frozenset(SIZES), frozenset(), {"q": 1.0, "r": 1.0}, two, Rule())
    table, _ = both.tables()
    assert set(table.effect[table.included]) == {"large", "tiny"}
    assert len(table) == 2 * len(SIZES)


@pytest.mark.parametrize(
    ("rule", "words"),
    [
        ({"part": 0.0}, "part = 0 is outside"),
        ({"joint_part": float("nan")}, "joint_part = nan is not a finite number"),
        ({"pairs": -1}, "pairs = -1 is outside"),
        ({"pairs": 1.5}, "pairs = 1.5"),
    ],
)
def test_a_rule_that_decides_nothing_is_rejected(rule, words):
    with pytest.raises(ConfigurationError, match=words):
        Rule(**rule)
