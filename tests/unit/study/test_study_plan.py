"""A plan counts jobs, at what was measured here, or else in the table, and names what it does not know."""

import pandas as pd
import pytest

from mammosim.study.jobs.plan import HERE, TABLE, UNKNOWN, costs, jobs_of, plan, scene_lines, summary, words

SAID = """Building DAG of jobs...
Job stats:
job         count
--------  -------
mesh            2
dose            1
figure_x        4
total           7

Reasons:
"""
BENCHMARKS = pd.DataFrame(
    {"rule": ["mesh", "mesh"], "cpu_time": [10.0, 20.0], "max_rss": [300.0, 500.0]}, dtype=object
)
TABLE_OF_COSTS = pd.DataFrame({"rule": ["mesh", "dose"], "seconds": [99.0, 90.0], "memory_mb": [1.0, 800.0]})


def test_jobs_are_read_from_a_dry_run():
    assert jobs_of(SAID) == {"mesh": 2, "dose": 1, "figure_x": 4}
    assert jobs_of("Nothing to be done (all requested files are present and up to date).") == {}


def test_rules_that_only_name_what_others_make_are_no_jobs():
    assert jobs_of(SAID, idle=["figure_x", "study"]) == {"mesh": 2, "dose": 1}


def test_the_last_job_of_every_campaign_costs_the_same():
    last = pd.DataFrame({"rule": ["campaign_other"], "cpu_time": [0.5], "max_rss": [100.0]}, dtype=object)
    table = plan({"campaign_mine": {"campaign_mine": 1}}, costs(last, TABLE_OF_COSTS))
    assert table[["seconds", "cost"]].to_numpy().tolist() == [[0.5, HERE]]


def test_a_job_that_was_not_measured_costs_what_the_table_says():
    short = pd.DataFrame({"rule": ["mesh"], "cpu_time": [float("nan")], "max_rss": [float("nan")]})
    assert costs(short, TABLE_OF_COSTS).loc["mesh", ["seconds", "cost"]].tolist() == [99.0, TABLE]


def test_costs_measured_here_come_before_the_table():
    known = costs(BENCHMARKS, TABLE_OF_COSTS)
    assert known.loc["mesh"].tolist() == [15.0, 500.0, HERE]
    assert known.loc["dose"].tolist() == [90.0, 800.0, TABLE]


def test_batches_of_points_cost_what_their_points_do():
    said = {"campaign_mine": {"mesh": 2, "campaigns_batch": 4}, "study": {"campaigns_batch": 1}}
    table = plan(said, costs(BENCHMARKS, TABLE_OF_COSTS), {"campaign_mine": 200.0})
    batches = table[table.rule == "campaigns_batch"].set_index("target")
    assert batches.seconds["campaign_mine"] == 200.0
    assert batches.seconds_each["campaign_mine"] == 50.0
    assert batches.cost.tolist() == ["by points", UNKNOWN]
    assert summary(table, said, cores=2).set_index("target").minutes["campaign_mine"] == (200 + 30) / 120


@pytest.fixture
def table():
    return plan({"study": jobs_of(SAID), "nothing": {}}, costs(BENCHMARKS, TABLE_OF_COSTS))


def test_seconds_are_those_of_all_jobs_of_a_rule(table):
    assert table.set_index("rule").seconds["mesh"] == 30.0
    assert table.set_index("rule").cost.to_dict() == {"mesh": HERE, "dose": TABLE, "figure_x": UNKNOWN}


def test_the_cores_share_the_seconds_and_hold_the_largest_jobs_at_once(table):
    found = summary(table, ["study", "nothing"], cores=2).set_index("target")
    assert found.loc["study"].tolist() == [7, 1.0, 1300.0, 4]
    assert found.loc["nothing"].tolist() == [0, 0.0, 0.0, 0]


def test_scenes_say_which_effects_they_have_or_that_they_are_to_be_screened():
    screened = pd.DataFrame({"effect": ["skin", "skin", "heel"], "included": [True, True, False]})
    lines = scene_lines({"a": screened, "b": ["scatter"], "c": None})
    assert lines[0] == "a: effects: skin; left out: heel"
    assert lines[1] == "b: effects as listed: scatter"
    assert "screened first" in lines[2]


def test_the_words_name_every_target_its_dearest_rules_and_what_was_never_measured(table):
    found = summary(table, ["study"], cores=2)
    text = words(found, table, ["a: effects: skin"], cores=2)
    assert "at least" not in text
    assert "at least" in words(found, table, [], cores=2, at_least=["study"])
    assert "dose 90 s, mesh 30 s" in text
    assert "4 jobs were never measured" in text
    assert text.endswith("a: effects: skin")
