"""Errors, orders, exponents and budgets of made tables whose answers are known."""

import numpy as np
import pandas as pd
import pytest

from mammosim.core.errors import ConfigurationError
from mammosim.study.accuracy.error_budget import budget
from mammosim.study.accuracy.errors import accuracy, on_front, orders, slope
from mammosim.study.accuracy.trial import ANSWERS

SIZES = (8.0, 4.0, 2.0, 1.0)
NAMELESS = (np.nan, np.nan)  # of a parameter whose reference is exact by definition


def _rows(parameter, quantity, answers, *, seconds, stochastic=False, sizes=None, today=1):
    """Rows of trials: answers (n_value, n_repeat) or (n_value, n_repeat, 3)."""
    found = []
    for number, repeats in enumerate(answers):
        about = {"value": f"v{number}", "size": (sizes or SIZES)[number], "seconds": seconds[number]}
        about |= {
            "today": number == today,
            "reference": number == len(answers) - 1,
            "memory_mb": 300.0 + number,
        }
        about |= {"stage": "xray", "parameter": parameter, "quantity": quantity, "stochastic": stochastic}
        about |= {"outcome": "converged", "settings": f'{{"a": {number}}}'}
        for repeat, answer in enumerate(repeats):
            numbers = np.pad(
                np.atleast_1d(answer).astype(float), (0, 3 - np.size(answer)), constant_values=np.nan
            )
            found.append(about | {"repeat": repeat} | dict(zip(ANSWERS, numbers)))
    return pd.DataFrame(found)


def _second_order(today=1):
    """error = size^2 N of 5 N, the reference at size 0.01, seconds = 16 size^-3."""
    sizes = (8.0, 4.0, 2.0, 0.01)
    answers = [[5 + h**2] * 2 for h in sizes]
    seconds = [16 * h**-3 for h in sizes]
    return _rows("element", "force_n", answers, seconds=seconds, sizes=sizes, today=today)


def test_an_error_is_the_distance_from_the_reference_in_the_unit_of_the_name():
    table = accuracy(_second_order())
    np.testing.assert_allclose(table.distance, [64, 16, 4, 0], atol=2e-4)
    relative = _rows("voxels", "agd_percent", [[1.1], [1.0]], seconds=[1, 2])
    np.testing.assert_allclose(accuracy(relative).distance, [10, 0])
    place = _rows("pyramid", "nipple_mm", [[np.array([3.0, 4.0, 0.0])], [np.zeros(3)]], seconds=[1, 2])
    np.testing.assert_allclose(accuracy(place).distance, [5, 0])


def test_what_the_reference_leaves_is_extrapolated_to_size_zero_and_added():
    sizes = (8.0, 4.0, 2.0, 1.0)
    for p, c in ((1, 0.3), (2, -0.3)):
        answers = [[5 + c * h**p] for h in sizes]
        table = accuracy(_rows("element", "force_n", answers, seconds=[1, 2, 4, 8], sizes=sizes))
        np.testing.assert_allclose(table.error, [abs(c) * h**p for h in sizes])
        np.testing.assert_allclose(table.left, abs(c))


def test_without_an_order_the_finest_is_as_far_off_as_others_and_none_beyond_the_second_is_taken():
    steps_grow = _rows("element", "force_n", [[8.0], [7.8], [7.0], [5.0]], seconds=[1, 2, 4, 8])
    table = accuracy(steps_grow)
    assert orders(table).order[0] < 0
    assert np.isnan(orders(table).order_taken[0])
    np.testing.assert_allclose(table.left, np.sqrt((3**2 + 2.8**2 + 2**2) / 3))
    fifth = orders(accuracy(_rows("element", "force_n", [[5 + h**5] for h in SIZES], seconds=[1, 2, 4, 8])))
    assert fifth.order[0] == pytest.approx(5)
    assert fifth.order_taken[0] == 2
    half = accuracy(_rows("element", "force_n", [[5 + 3 * h**0.6] for h in SIZES], seconds=[1, 2, 4, 8]))
    np.testing.assert_allclose(half.left, 3.0)
    two = accuracy(_rows("rays", "force_n", [[5.5], [5.0]], seconds=[1, 2], sizes=(2, 1)))
    np.testing.assert_allclose(two.left, 0.5)


def test_a_stochastic_parameter_and_one_without_sizes_leave_nothing_to_extrapolate():
    nameless = _rows("method", "force_n", [[5.5], [5.0]], seconds=[1, 2], sizes=NAMELESS)
    assert (accuracy(nameless).left == 0).all()
    photons = _rows("photons", "force_n", [[5.5, 5.4], [5.0, 5.1]], seconds=[1, 2], stochastic=True)
    assert (accuracy(photons).left == 0).all()


def test_the_error_of_a_stochastic_parameter_is_its_scatter_and_the_bias_that_stands_above_the_noise():
    rng = np.random.default_rng(1)
    v, r = 10 + 0.3 + 0.2 * rng.standard_normal(400), 10 + 0.1 * rng.standard_normal(400)
    table = accuracy(_rows("photons", "force_n", [v, r], seconds=[1, 4], stochastic=True))
    # sqrt(0.2^2 + 0.3^2) and 0.1, with the standard errors of 400 draws
    assert table.error[0] == pytest.approx(0.36, abs=0.03)
    assert table.error[1] == pytest.approx(0.1, abs=0.015)


def test_order_and_exponent_are_those_the_table_was_made_with():
    (row,) = orders(accuracy(_second_order())).itertuples()
    assert row.order == pytest.approx(2)
    assert row.order_se == pytest.approx(0, abs=1e-9)
    assert row.exponent == pytest.approx(3)
    assert row.points == 3, "the distance of the reference is zero by definition"


def test_errors_in_the_noise_are_not_fitted():
    answers = [[13.0, 13.0], [7.0, 7.0], [5.01, 4.9], [5.0, 5.1]]
    table = accuracy(_rows("voxels", "force_n", answers, seconds=[1, 2, 4, 8]))
    assert orders(table).points[0] == 2


def test_an_order_that_one_point_leaves_open_is_no_number():
    assert np.isnan(slope([1.0], [1.0])[0])
    p, error = slope([1, 2], [1, 8])
    assert p == pytest.approx(3)
    assert np.isnan(error)


def test_what_failed_has_no_error_and_says_why():
    rows = _second_order()
    rows.loc[rows.value == "v0", "outcome"] = "failed: it slides away"
    table = accuracy(rows)
    assert np.isnan(table.error[0])
    assert table.outcome[0] == "failed: it slides away"
    assert table.distance[1] == pytest.approx(16, rel=1e-4)


@pytest.mark.parametrize("quantity", ["force_n", "nipple_mm"])
def test_where_the_finest_fails_the_next_is_the_reference(quantity):
    answers = [[5.0], [3.0], [2.0]] if quantity == "force_n" else [[h * np.ones(3)] for h in (5.0, 3.0, 2.0)]
    rows = _rows("element", quantity, answers, seconds=[1, 2, 3], sizes=(4, 2, 1), today=0)
    finest = rows.value == "v2"
    rows.loc[finest, "outcome"] = "failed: it slides away"
    rows.loc[finest, list(ANSWERS)] = np.nan
    table = accuracy(rows)
    assert list(table.reference) == [False, True, False]
    assert table.distance[0] == pytest.approx(2 if quantity == "force_n" else 2 * np.sqrt(3))
    assert np.isnan(table.error[2])
    assert list(budget(table).parameter) == ["element"]


def test_a_value_that_is_alone_has_no_error():
    rows = _second_order(today=3)
    rows.loc[~rows.reference, "outcome"] = "failed: it slides away"
    assert accuracy(rows).error.isna().all(), "zero would call it exact"


def test_where_all_fails_there_is_no_budget():
    rows = _second_order()
    rows["outcome"] = "failed: it slides away"
    rows[list(ANSWERS)] = np.nan
    table = accuracy(rows)
    assert table.error.isna().all()
    assert budget(table).empty


def test_a_parameter_without_its_reference_is_rejected():
    rows = _second_order()
    with pytest.raises(ConfigurationError, match="element lacks the row of its reference for force_n"):
        accuracy(rows[~rows.reference])


def test_the_front_is_what_nothing_beats():
    np.testing.assert_array_equal(on_front([1, 2, 3, 4], [5, 6, 1, 1]), [True, False, True, False])
    np.testing.assert_array_equal(on_front([1, 1], [1, 1]), [True, True])
    assert not on_front([1, 2], [np.nan, 1])[0]


def test_shares_are_those_of_the_squares_and_the_largest_limits():
    other = _rows("photons", "force_n", [[5 + 12.0], [5.0]], seconds=[1, 2], sizes=NAMELESS, today=0)
    found = budget(accuracy(pd.concat([_second_order(), other])))
    assert list(found.parameter) == ["element", "photons"]
    np.testing.assert_allclose(found.share_percent, [64, 36])
    np.testing.assert_allclose(found.total_error, 20)
    assert list(found.limits) == [True, False]


def test_the_next_second_goes_where_the_error_falls_most_per_second():
    # element: 4 -> 2 mm takes 16/8 - 16/64 = 1.75 s more and leaves sqrt(12^2 + 4^2);
    # photons: 12 -> 0 takes 1 s more and leaves 16, 4 N per s.
    other = _rows("photons", "force_n", [[5 + 12.0], [5.0]], seconds=[1, 2], sizes=NAMELESS, today=0)
    found = budget(accuracy(pd.concat([_second_order(), other]))).set_index("parameter")
    assert found.step_to["element"] == "v2"
    assert found.error_after["element"] == pytest.approx(np.hypot(12, 4))
    assert found.seconds_more["element"] == pytest.approx(1.75)
    assert list(found.index[found["next"]]) == ["element"]
    assert found.fall_per_second["photons"] == pytest.approx(4)


def test_a_coarser_value_that_is_nearer_by_luck_is_no_step():
    rows = _second_order(today=2)
    rows.loc[rows.value == "v1", "answer_1"] = 5.1
    assert budget(accuracy(rows)).step_to[0] == "v3"


def test_a_reference_has_no_step_left():
    found = budget(accuracy(_second_order(today=3)))
    assert found.step_to.isna().all()
    assert not found["next"].any()
    assert found.limits.all(), "what it leaves"


def test_a_budget_without_todays_value_is_rejected():
    rows = _second_order()
    rows["today"] = False
    with pytest.raises(ConfigurationError, match="of the parameter element has no error of force_n"):
        budget(accuracy(rows))
