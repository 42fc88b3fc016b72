"""What a job asks of a cluster follows what its rule was measured to take, and grows with each attempt."""

import pytest

from mammosim.io.plain import read_plain
from mammosim.study.jobs.requests import LEAST_MIN, STARTS_MB, Request, requests

COSTS = {
    "compress": {"seconds": "22.7", "memory_mb": "557.0", "longest": "90.0"},
    "soften": {"seconds": "600", "memory_mb": "611", "longest": ""},
    "table": {"seconds": "0.1", "memory_mb": "1.0", "longest": "0.1"},
    "stress_free": {"seconds": "2.0", "memory_mb": "600", "longest": "240.0"},
    "hard_case": {"seconds": "8.0", "memory_mb": "", "longest": "25.0"},
}


@pytest.fixture(scope="module")
def asked():
    stated = {
        "compress": 4000,
        "soften": 4000,
        "stress_free": 4000,
        "table": 500,
        "hard_case": 1500,
        "new": 500,
    }
    return requests(stated, COSTS)


def test_memory_is_the_measured_one_with_room_and_the_starts(asked):
    assert asked["compress"].mem_mb(1) == 1300  # 1.5 * 557 + 450 = 1285.5, in steps of 100
    assert asked["hard_case"].mem_mb(1) == 2000, "not measured: what the rule states, and the starts"
    assert all(each.mem_mb(1) >= STARTS_MB + 200 for each in asked.values()), "two starts, and Python"


def test_time_is_that_of_the_longest_job_for_another_woman_on_a_slow_node(asked):
    assert asked["stress_free"].runtime(1) == 25  # (3 * 2 * 240 + 15) / 60 = 24.25 min; the mean is 2 s
    assert asked["compress"].runtime(1) == LEAST_MIN  # (3 * 2 * 90 + 15) / 60 = 9.25 min
    assert asked["soften"].runtime(1) == 61, "of the mean, where no longest one was measured"
    assert asked["new"].runtime(1) == 60


def test_each_attempt_asks_for_twice_as_much(asked):
    for each in asked.values():
        assert [each.mem_mb(attempt) / each.mem_mb(1) for attempt in (1, 2, 3)] == [1, 2, 4]
        assert [each.runtime(attempt) / each.runtime(1) for attempt in (1, 2, 3)] == [1, 2, 4]


def test_only_what_was_measured_as_short_and_small_is_short(asked):
    assert [name for name, each in asked.items() if each.short] == ["table"]
    assert Request(500, seconds=4.0, memory_mb=700.0).short
    assert not Request(500, seconds=4.1, memory_mb=700.0).short
    assert not Request(500, seconds=1.0, memory_mb=701.0).short
    assert not Request(500, seconds=1.0).short, "its memory is not known"


def test_the_published_table_knows_the_longest_job_of_every_rule(repository):
    rows = read_plain(repository / "config/costs.tsv")
    rules = [row for row in rows if not row["rule"].startswith("point_")]
    assert [row["rule"] for row in rules if not float(row["longest"]) >= float(row["seconds"])] == []
