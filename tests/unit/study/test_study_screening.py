"""What is kept of a model whose answers are known: additive, with two that matter only together, refused."""

import numpy as np
import pytest

from mammosim.core.errors import MechanicsError
from mammosim.study.screening import COLUMNS, Answer, Rule, Screening

SIZES = {"large": 3.0, "middle": 0.2, "small": 0.05, "tiny": 0.01}


def additive(effects):
    """Each effect that is absent moves the answer by its size; each that is there takes a second."""
    return Answer({"q": sum(size for e, size in SIZES.items() if e not in effects)}, seconds=len(effects))


def screening(answers, *, tolerance=1.0, needed=(), full=SIZES, **rule):
    return Screening("scene", frozenset(full), frozenset(needed), {"q": tolerance}, answers, Rule(**rule))


def kept(answers, **settings):
    table = screening(answers, **settings).table()
    return set(table.effect[table.included])


def test_an_effect_is_kept_where_it_moves_the_answer_by_more_than_the_part_of_its_tolerance():
    assert kept(additive, part=0.25, joint_part=0.5) == {"large"}
    assert kept(additive, part=0.25, joint_part=0.5, tolerance=0.5) == {"large", "middle"}
    assert kept(additive, part=0.25, joint_part=0.5, tolerance=100.0) == set()


def test_all_that_goes_at_once_stays_within_the_joint_part_and_the_most_important_comes_back_first():
    # middle, small and tiny move 0.26 together, each alone less than 0.25
    assert kept(additive, part=0.25, joint_part=0.25, pairs=0) == {"large", "middle"}


def test_two_that_matter_only_together_are_found_and_the_more_important_one_is_kept():
    def together(effects):
        more = 1.0 if not {"middle", "small"} & effects else 0.0
        return Answer({"q": additive(effects).changes["q"] + more}, seconds=1)

    table = screening(together, part=0.25, joint_part=5.0).table().set_index("effect")
    assert set(table.index[table.included]) == {"large", "middle"}
    assert "alone it may go, but without it and small" in table.reason["middle"]
    assert "middle" not in kept(together, part=0.25, joint_part=5.0, pairs=0)


def test_without_an_answer_an_effect_is_kept_for_that_reason():
    def slides(effects):
        return additive(effects) if "tiny" in effects else Answer({}, 1.0, refusal="it slides away")

    table = screening(slides).table().set_index("effect")
    assert table.included["tiny"]
    assert table.reason["tiny"] == "without it there is no answer: it slides away"
    assert np.isnan(table.change["tiny"])


def test_what_is_needed_is_kept_untried():
    tried = []

    def recorded(effects):
        tried.append(effects)
        return additive(effects)

    assert kept(recorded, needed={"tiny"}) == {"large", "tiny"}
    assert all("tiny" in effects for effects in tried)


def test_a_full_model_without_an_answer_is_said():
    with pytest.raises(
        MechanicsError, match=r"scene scene: the full model is refused .*: it slides away; screen on"
    ):
        screening(lambda effects: Answer({}, 1.0, refusal="it slides away")).table()


def test_rows_hold_change_tolerance_and_the_seconds_that_leaving_it_out_saves():
    table = screening(additive).table()
    assert list(table.columns) == COLUMNS
    row = table.set_index("effect").loc["middle"]
    assert (row.change, row.tolerance, row.seconds) == (0.2, 1.0, 1.0)


def test_a_change_within_its_noise_is_told():
    def noisy(effects):
        return Answer(additive(effects).changes, 1.0, {"q": 0.15})

    reasons = screening(noisy).table().set_index("effect").reason
    assert "not told from noise" in reasons["middle"]
    assert "not told from noise" not in reasons["large"]


def test_the_worst_of_several_answers_decides():
    def two(effects):
        return Answer({"q": additive(effects).changes["q"], "r": 0.0 if "tiny" in effects else 9.0}, 1.0)

    both = Screening("s", frozenset(SIZES), frozenset(), {"q": 1.0, "r": 1.0}, two, Rule())
    table = both.table()
    assert set(table.effect[table.included]) == {"large", "tiny"}
    assert len(table) == 2 * len(SIZES)
