"""How far compression can be reduced: what is decided by intervals, and what is said where nothing can be."""

import numpy as np
import pandas as pd
import pytest
from markupsafe import escape

from mammosim.chain.quantities import QUANTILE
from mammosim.figures.answer import PANELS
from mammosim.figures.answer import answer as drawn
from mammosim.study.report.answer import BETWEEN, STRATEGIES, answer_table, answers, monotone, reach, slow
from mammosim.study.report.answer_limits import ALWAYS, Known, limits_table, why_not_pressed
from mammosim.study.report.answer_words import change_words, percent, sentence, short_table
from mammosim.study.report.pressed_breast import DONE, FORCE, STRAIN, between, breasts, is_level
from mammosim.study.report.strategy_costs import (
    CALCIFICATIONS,
    DOSE,
    LESS,
    MASS,
    MAY,
    MORE,
    UNKNOWN,
    LossLimits,
    Numerical,
    kept_in_changes,
    seen,
    strategy_costs,
    together,
    verdict,
)
from mammosim.study.report.texts import paragraphs

LIMITS = LossLimits(5.0, 5.0)
KNOWN = Known(("left",))
EXACT = Numerical(dose=0.0, contrast=0.0, calcification=0.0)
ASKED = [("ada", "left"), ("ada", "right")]


def pressed(strategy: str, mm: float, newton: float, moduli: str = "gravity", **more) -> dict:
    return {
        "volunteer": "ada", "side": "left", "strategy": strategy, "moduli": moduli, "thickness_mm": mm,
        "force_n": newton, "mean_pressure_kpa": newton / 10, "logarithmic_p95": 0.4 * 50 / mm,
        "tilt_deg": 0.0, "deflection_mm": 0.0, "thickness_from": "given", "moduli_factor": 1.0,
        "outcome": "converged",
    } | more  # fmt: skip


def imaged(strategy: str, dose: float, **more) -> dict:
    return {
        "volunteer": "ada", "side": "left", "strategy": strategy, "moduli": "gravity", "dose_mgy": dose,
        "dose_se_mgy": 0.0, "cnr_quantum": 3.0, "lesion_pixels": 200, "calcification_d_expected": 8.0,
        "calcification_d_low": 7.0, "calcification_d_high": 9.0,
    } | more  # fmt: skip


def tables(**given: list[dict]) -> dict[str, pd.DataFrame]:
    return {name: pd.DataFrame(rows) for name, rows in given.items()}


def asked(given: dict[str, pd.DataFrame], numerical: Numerical = EXACT, limits: LossLimits = LIMITS):
    """The costs, and the answer of the left breast of ada."""
    known = breasts(given)
    costs = strategy_costs(known, numerical=numerical, limits=limits)
    why = why_not_pressed(ASKED, KNOWN, given)
    return costs, answers(costs, known, limits, asked=ASKED, why_not=why)[0]


def cost(costs: pd.DataFrame, strategy: str, quantity: str) -> pd.Series:
    (row,) = costs[(costs.strategy == strategy) & (costs["quantity"] == quantity)].to_dict("records")
    return pd.Series(row)


STANDARD_AND = {"compression": [pressed("standard", 50.0, 100.0), pressed("gentle", 55.0, 60.0)]}


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [
        (1.0, 5.0, LESS),
        (-9.0, -2.0, LESS),
        (4.0, 6.0, MAY),
        (5.1, 9.0, MORE),
        (np.nan, 3.0, UNKNOWN),
        (1.0, np.inf, UNKNOWN),
    ],
)
def test_a_loss_is_judged_by_its_interval(low, high, expected):
    assert verdict(low, high, 5.0) == expected


def test_one_loss_that_is_more_decides_and_one_that_is_not_known_leaves_it_open():
    assert together([LESS, UNKNOWN, MORE]) == MORE
    assert together([LESS, MAY, UNKNOWN]) == UNKNOWN
    assert together([LESS, MAY]) == MAY
    assert together([LESS, LESS]) == LESS
    assert together([]) == UNKNOWN


def test_a_curve_is_interpolated_where_it_only_falls_or_rises_and_nowhere_else():
    t = pd.Series([60.0, 50.0, 40.0])
    assert between(t, pd.Series([1.0, 2.0, 4.0]), 45.0) == pytest.approx(3.0)
    assert np.isnan(between(t, pd.Series([3.0, 2.0, 4.0]), 45.0))
    assert np.isnan(between(t, pd.Series([1.0, 2.0, 4.0]), 39.0))
    assert np.isnan(between(t[:0], t[:0], 45.0))


def test_errors_of_both_images_widen_a_change():
    given = tables(
        **STANDARD_AND,
        image=[imaged("standard", 2.0, dose_se_mgy=0.02), imaged("gentle", 2.2, dose_se_mgy=0.022)],
    )
    row = cost(asked(given, Numerical(0.0, 0.0, 3.0))[0], "gentle", DOSE)
    assert row.change_percent == pytest.approx(10.0)
    half = 110 * np.sqrt(2) * QUANTILE * 0.01
    assert row.change_high_percent - row.change_percent == pytest.approx(half)
    assert row.low == pytest.approx(2.2 * (1 - QUANTILE * 0.01))
    numerical = cost(asked(given, Numerical(1.0, 0.0, 3.0))[0], "gentle", DOSE)
    assert numerical.change_high_percent - 10 == pytest.approx(
        110 * np.sqrt(2) * np.hypot(QUANTILE * 0.01, 0.01)
    )


@pytest.mark.parametrize(
    ("quantity", "numerical"),
    [
        (DOSE, Numerical(contrast=0.0, calcification=0.0)),
        (MASS, Numerical(dose=0.0, calcification=0.0)),
        (CALCIFICATIONS, Numerical(dose=0.0, contrast=0.0)),
    ],
)
def test_without_a_measured_numerical_error_an_interval_says_what_it_holds_and_nothing_is_certain(
    quantity, numerical
):
    photons = {"dose_se_mgy": 0.001}
    given = tables(
        **STANDARD_AND, image=[imaged("standard", 2.0, **photons), imaged("gentle", 2.04, **photons)]
    )
    costs, found = asked(given, numerical)
    row = cost(costs, "gentle", quantity)
    assert not row.complete
    assert (
        row.interval_from
        == {
            **{DOSE: "photons", MASS: "pixels"},
            CALCIFICATIONS: "the observer's images",
        }[quantity]
    )
    assert (row.costs, found.verdict, found.less) == (MAY, MAY, "")
    assert np.isnan(found.certain_mm)
    assert found.possible_mm == 55.0
    words = sentence(found, costs, LIMITS)
    assert f"to about {found.possible_mm:.1f} mm (" in words
    assert "at most" not in words, "by an interval that lacks an error nothing is an upper bound"
    assert "not every numerical error was measured, so that no thickness is certain" in words
    dear = tables(**STANDARD_AND, image=[imaged("standard", 2.0), imaged("gentle", 4.0)])
    _, found = asked(dear, numerical)
    assert found.verdict == MORE
    assert 50 < found.possible_mm < 51, "a dose that doubles ends the range, whatever its error"


def test_d_of_a_mass_adds_the_pixels_of_its_shadow():
    given = tables(
        **STANDARD_AND,
        image=[imaged("standard", 2.0), imaged("gentle", 2.0, cnr_quantum=1.5, lesion_pixels=800)],
    )
    costs, _ = asked(given)
    assert cost(costs, "standard", MASS).value == pytest.approx(3 * np.sqrt(200))
    assert cost(costs, "gentle", MASS).change_percent == pytest.approx(0.0)


@pytest.mark.parametrize(("lower", "word"), [(0.9, MORE), (0.97, LESS), (1.2, LESS)])
@pytest.mark.parametrize("quantity", [MASS, CALCIFICATIONS])
def test_less_detectability_is_a_loss_and_more_is_none(quantity, lower, word):
    column = {MASS: "cnr_quantum", CALCIFICATIONS: "calcification_d_expected"}[quantity]
    many = {"lesion_pixels": 10**8}  # a shadow whose pixels are hardly uncertain
    standard = imaged("standard", 2.0, **many)
    gentle = standard | {"strategy": "gentle", column: lower * standard[column]}
    costs, found = asked(tables(**STANDARD_AND, image=[standard, gentle]))
    row = cost(costs, "gentle", quantity)
    assert row.change_percent == pytest.approx(100 * (lower - 1))
    assert row.costs == word
    assert found.certain_mm == pytest.approx(50 + 5 * (0.5 if word == MORE else 1), rel=1e-3)
    assert found.decides == (quantity if word == MORE else "")


def test_the_pixels_of_a_shadow_are_as_uncertain_as_where_the_mass_lies():
    """Discs of 8 pixels, put anywhere: the spread of how many pixels they hold, against what is assumed."""
    x = np.arange(-10, 11)
    centres = np.random.default_rng(4).random((4000, 2, 1, 1))
    inside = (x[:, None] - centres[:, 0]) ** 2 + (x - centres[:, 1]) ** 2 < 8**2
    N = inside.sum(axis=(1, 2))
    spread = QUANTILE * np.sqrt(N).std() / np.sqrt(N).mean()
    half = seen(pd.DataFrame([imaged("standard", 2.0, lesion_pixels=N.mean())]), EXACT)[f"{MASS}_half"][0]
    assert spread < half < 2 * spread


def test_the_interval_of_calcifications_is_that_of_the_images_where_nothing_else_was_measured():
    given = tables(**STANDARD_AND, image=[imaged("standard", 2.0), imaged("gentle", 2.0)])
    row = cost(asked(given, Numerical())[0], "gentle", CALCIFICATIONS)
    assert row.interval_from == "the observer's images"
    assert (row.low, row.high) == pytest.approx((7.0, 9.0))
    assert cost(asked(given, Numerical())[0], "gentle", MASS).costs == MAY


def test_errors_that_all_strategies_share_do_not_count_in_a_change():
    measured = pd.DataFrame(
        {"stage": ["mesh", "xray", "xray"], "parameter": ["element", "voxels", "dose_photons"]}
    )
    assert kept_in_changes(measured).parameter.tolist() == ["voxels"]


def test_forces_of_other_moduli_and_of_the_draws_make_the_interval():
    path = [
        {"volunteer": "ada", "side": "left", "strategy": "standard", "moduli": moduli, "thickness_mm": t,
         "force_n": factor * f, "mean_pressure_kpa": f}
        for moduli, factor in (("gravity", 1.0), ("compression", 5.0))
        for t, f in ((60.0, 20.0), (55.0, 60.0), (50.0, 100.0))
    ]  # fmt: skip
    given = tables(
        compression=[*STANDARD_AND["compression"], pressed("standard", 50.0, 500.0, "compression")],
        compression_path=path,
        propagation=[
            {"volunteer": "ada", "side": "left", "quantity": "force_n", "fit": 10.0, "low": 8.0, "high": 13.0}
        ],
    )
    row = cost(asked(given)[0], "gentle", FORCE)
    assert (row.value, row.low, row.high) == (60.0, pytest.approx(48.0), pytest.approx(300.0))
    assert row.interval_from == "draws of the fit, compression moduli"
    assert row.change_percent == pytest.approx(-40.0)
    # Of the stiffer moduli only the standard was pressed: no path says its strain, and nothing is made up.
    assert np.isnan(cost(asked(given)[0], "gentle", STRAIN).low)


def test_a_strategy_within_the_limits_is_the_answer():
    given = tables(**STANDARD_AND, image=[imaged("standard", 2.0), imaged("gentle", 2.06)])
    costs, found = asked(given)
    assert (found.verdict, found.less, found.shown) == (LESS, "gentle", "gentle")
    assert (found.certain_mm, found.possible_mm, found.ended, found.decides) == (55.0, 55.0, False, "")
    words = sentence(found, costs, LIMITS)
    assert words.startswith("**ada, left: thickness may rise from 50.0 to 55.0 mm at least")
    assert "`gentle` (55.0 mm, 60.0 N)" in words
    assert "dose +3.0 %" in words


def test_an_interval_over_the_limit_leaves_a_range_that_is_not_certain():
    image = [imaged("standard", 2.0, dose_se_mgy=0.03), imaged("gentle", 2.06, dose_se_mgy=0.03)]
    costs, found = asked(tables(**STANDARD_AND, image=image))
    assert (found.verdict, found.may_be_less) == (MAY, "gentle")
    upper = cost(costs, "gentle", DOSE).change_high_percent
    assert upper > 5
    assert found.certain_mm == pytest.approx(50 + 5 * 5 / upper)
    assert found.possible_mm == 55.0
    assert found.decides == DOSE
    assert "55.0 mm at most" in sentence(found, costs, LIMITS)


def test_between_strategies_the_dose_lies_between_a_line_and_a_slow_exponential():
    costs, found = asked(tables(**STANDARD_AND, image=[imaged("standard", 2.0), imaged("gentle", 4.0)]))
    assert found.certain_mm == pytest.approx(50 + 5 * 0.05)
    s = (found.possible_mm - 50) / 5
    assert np.log(2) * slow(s) == pytest.approx(np.log(1.05))
    assert (found.verdict, found.by) == (MORE, BETWEEN)
    assert "interpolated" in sentence(found, costs, LIMITS)


# Dose in mGy of two digital volunteers: at the standard thickness, a quarter thicker, with the next strategy.
MEASURED = [
    ((45.0, 2.1051), (56.25, 3.6004), (63.983, 5.1964)),
    ((60.0, 2.558), (75.0, 3.9252), (82.184, 5.1601)),
]


@pytest.mark.parametrize(("standard", "middle", "next_one"), MEASURED)
def test_doses_that_were_computed_in_between_lie_there(standard, middle, next_one):
    (t0, D0), (t, D), (t1, D1) = standard, middle, next_one
    s = (t - t0) / (t1 - t0)
    assert D0 * (D1 / D0) ** slow(s) < D < D0 + s * (D1 - D0)


def test_a_loss_that_cannot_be_monotone_is_not_interpolated():
    t = np.array([50.0, 55.0, 60.0])
    assert not monotone(np.array([0.0, 8.0, 1.0]), np.array([0.0, 9.0, 2.0]))
    found = reach(t, np.array([0.0, 8.0, 1.0]), np.array([0.0, 9.0, 2.0]), 5.0, growing=False)
    assert (found.by, found.certain, found.possible, found.ended) == (STRATEGIES, 50.0, 50.0, True)
    # Wide enough intervals allow it, and then the first crossing counts.
    assert monotone(np.array([0.0, 1.0, 1.0]), np.array([0.0, 9.0, 2.0]))
    wide = reach(t, np.array([0.0, 1.0, 1.0]), np.array([0.0, 9.0, 2.0]), 5.0, growing=False)
    assert wide.by == BETWEEN
    assert wide.certain == pytest.approx(50 + 5 * 5 / 9)


def test_where_nothing_is_interpolated_a_range_ends_only_if_a_limit_is_met():
    t, up_and_down = np.array([50.0, 55.0, 60.0]), np.array([0.0, 3.0, 1.0])
    found = reach(t, up_and_down, up_and_down, 5.0, growing=False)
    assert (found.by, found.certain, found.ended) == (STRATEGIES, 60.0, False)
    beyond = reach(t, up_and_down, up_and_down, 2.0, growing=False)
    assert (beyond.certain, beyond.ended) == (50.0, True)


def test_a_loss_that_is_just_what_is_allowed_ends_no_range():
    t = np.array([50.0, 55.0, 60.0])
    for loss in ([0.0, 5.0, 5.0], [0.0, 5.0, 3.0]):
        found = reach(t, np.array(loss), np.array(loss), 5.0, growing=False)
        assert (found.certain, found.possible, found.ended) == (60.0, 60.0, False)


def test_a_range_may_end_beyond_the_first_strategy():
    t, loss = np.array([50.0, 55.0, 60.0]), np.array([0.0, 4.0, 8.0])
    found = reach(t, loss, loss, 6.0, growing=False)
    assert (found.certain, found.possible, found.ended) == (57.5, 57.5, True)


def test_a_loss_of_which_one_end_is_not_known_is_left_out():
    t, loss = np.array([50.0, 55.0, 60.0]), np.array([0.0, 4.0, 8.0])
    for low, high in ((loss, [0.0, np.nan, 8.0]), ([0.0, np.nan, 8.0], loss)):
        found = reach(t, np.array(low), np.array(high), 4.0, growing=False)
        assert (found.certain, found.possible) == (55.0, 55.0)


def test_what_is_told_is_the_furthest_that_costs_less_or_the_least_that_costs_more():
    rows = [pressed("standard", 50.0, 100.0), *(pressed(f"way{mm}", float(mm), 80.0) for mm in (55, 60, 65))]

    def found(*doses):
        images = [imaged("standard", 2.0), *(imaged(f"way{mm}", D) for mm, D in zip((55, 60, 65), doses))]
        return asked(tables(compression=rows, image=images))[1]

    assert (found(2.01, 2.02, 4.0).verdict, found(2.01, 2.02, 4.0).shown) == (LESS, "way60")
    assert (found(3.0, 3.5, 4.0).verdict, found(3.0, 3.5, 4.0).shown) == (MORE, "way55")


def test_the_force_of_the_standard_is_told_with_what_is_known_of_it():
    rows = [*STANDARD_AND["compression"], pressed("standard", 50.0, 500.0, "compression")]
    costs, found = asked(tables(compression=rows))
    assert (found.standard_mm, found.standard_n) == (50.0, 100.0)
    assert (found.standard_low_n, found.standard_high_n) == (100.0, 500.0)
    told = "At 50.0 mm the force is between 100 and 500 N, as far as her moduli are known."
    assert sentence(found, costs, LIMITS).endswith(told)
    costs, alone = asked(tables(**STANDARD_AND))
    assert "the force is between" not in sentence(alone, costs, LIMITS)


def test_values_that_only_fall_are_monotone_within_their_intervals():
    assert monotone(np.array([4.0, 2.0, 0.0]), np.array([5.0, 3.0, 1.0]))
    assert not monotone(np.array([4.0, 0.0, 2.0]), np.array([5.0, 1.0, 3.0]))


def test_values_that_are_no_numbers_are_left_out_of_a_range():
    t, nothing = np.array([50.0, 55.0, 60.0]), np.array([0.0, np.nan, 10.0])
    found = reach(t, nothing, nothing, 5.0, growing=False)
    assert found.certain == found.possible == pytest.approx(55.0)
    assert np.isnan(reach(t[:1], nothing[:1], nothing[:1], 5.0, growing=True).certain)


def test_yielding_paddles_are_judged_and_not_interpolated():
    given = tables(
        compression=[*STANDARD_AND["compression"], pressed("tilted", 52.0, 55.0, tilt_deg=0.1)],
        image=[imaged("standard", 2.0), imaged("gentle", 2.4), imaged("tilted", 2.02)],
    )
    _, found = asked(given)
    assert (found.verdict, found.less, found.more, found.shown) == (LESS, "tilted", "gentle", "tilted")
    assert found.certain_mm == pytest.approx(50 + 5 * 5 / 20)


def test_without_calcifications_the_range_is_an_upper_bound():
    nothing = {f"calcification_d_{end}": np.nan for end in ("expected", "low", "high")}
    given = tables(
        **STANDARD_AND, image=[imaged("standard", 2.0, **nothing), imaged("gentle", 2.4, **nothing)]
    )
    costs, found = asked(given)
    assert np.isnan(found.certain_mm)
    assert np.log(1.2) * slow((found.possible_mm - 50) / 5) == pytest.approx(np.log(1.05))
    assert "not every loss is known, so that no thickness is certain" in sentence(found, costs, LIMITS)
    rows = limits_table([found], costs, given, KNOWN)
    assert (rows.cannot_be_said == "what less compression does to d' of the calcifications").any()


@pytest.mark.parametrize("nothing", [np.nan, 0.0, -2.0, np.inf])
def test_what_is_no_dose_is_neither_less_nor_compared_with(nothing):
    given = tables(**STANDARD_AND, image=[imaged("standard", 2.0), imaged("gentle", nothing)])
    costs, found = asked(given)
    assert (found.verdict, cost(costs, "gentle", DOSE).costs) == (UNKNOWN, UNKNOWN)
    assert np.isnan(cost(costs, "gentle", DOSE).value)
    given = tables(**STANDARD_AND, image=[imaged("standard", nothing), imaged("gentle", 2.0)])
    costs, found = asked(given)
    assert "not every loss is known" in sentence(found, costs, LIMITS)
    rows = limits_table([found], costs, given, KNOWN).set_index("cannot_be_said")
    why = "the standard strategy, with which it is compared, has no dose"
    assert rows.because["what less compression does to dose"] == why


def test_a_shadow_that_is_not_seen_costs_more_and_has_its_interval_in_order():
    image = [imaged("standard", 2.0), imaged("gentle", 2.0, cnr_quantum=-0.1)]
    costs, found = asked(tables(**STANDARD_AND, image=image))
    row = cost(costs, "gentle", MASS)
    assert row.low < row.value < row.high < 0
    assert row.change_low_percent < row.change_percent < row.change_high_percent
    assert (row.costs, found.verdict) == (MORE, MORE)
    nothing = [imaged("standard", 2.0), imaged("gentle", 2.0, lesion_pixels=0)]
    assert cost(asked(tables(**STANDARD_AND, image=nothing))[0], "gentle", MASS).costs == UNKNOWN


def test_an_interval_of_photons_that_reaches_below_no_dose_is_no_end_of_the_range():
    wide = imaged("gentle", 2.2, dose_se_mgy=3.0)
    given = tables(
        compression=[*STANDARD_AND["compression"], pressed("least", 60.0, 40.0)],
        image=[imaged("standard", 2.0), wide, imaged("least", 4.0)],
    )
    _, found = asked(given)
    assert 55 < found.possible_mm < 60
    assert found.certain_mm < 55


def test_what_is_not_known_is_no_number():
    given = tables(
        compression=[STANDARD_AND["compression"][0], pressed("gentle", 55.0, np.nan, logarithmic_p95=np.nan)],
        image=[imaged("standard", 2.0), imaged("gentle", 2.0)],
    )
    costs, found = asked(given)
    words = sentence(found, costs, LIMITS)
    assert "nan" not in words
    assert "(55.0 mm, – N)" in words
    assert words.endswith("strain not known.")
    assert short_table(costs).force_n.tolist() == ["100", "–"]


def test_small_doses_and_detectabilities_are_known():
    small = {"dose_mgy": 0.5, "cnr_quantum": 0.01, "calcification_d_expected": 0.2}
    image = [imaged("standard", 0.5) | small, imaged("gentle", 0.5) | small | {"dose_mgy": 0.51}]
    costs, found = asked(tables(**STANDARD_AND, image=image), Numerical(1.0, 1.0, 1.0))
    assert found.verdict == LESS
    standard = costs[(costs.strategy == "standard") & costs["quantity"].isin([DOSE, MASS, CALCIFICATIONS])]
    assert standard.change_percent.tolist() == standard.change_low_percent.tolist() == [0.0] * 3
    assert cost(costs, "gentle", DOSE).change_percent == pytest.approx(2.0)


def test_numerical_errors_are_percent_of_the_value():
    N = 200
    image = pd.DataFrame([imaged("standard", 2.0, lesion_pixels=N)])
    (found,) = seen(image, Numerical(dose=3.0, contrast=4.0, calcification=5.0)).to_dict("records")
    assert found[f"{DOSE}_half"] == pytest.approx(0.03)
    assert found[f"{CALCIFICATIONS}_half"] == pytest.approx(0.05)
    # Pixels on the rim count by even chance, and d' goes with the root of the number of all.
    counted = QUANTILE * np.sqrt(2 * np.sqrt(np.pi * N) * 0.5 * 0.5) / N / 2
    assert found[f"{MASS}_half"] == pytest.approx(np.hypot(counted, 0.04))


def test_a_reason_is_told_as_it_stands():
    why = "failed: no series in /scans/$a$/[2020](b)/**c**"
    given = tables(compression=[pressed("standard", 50.0, 100.0, outcome=why)])
    costs, found = asked(given)
    assert found.why == why
    assert escape(why) in paragraphs(sentence(found, costs, LIMITS), {})[0]


def test_words_have_an_interval_where_one_is_known_and_a_value_where_none_is():
    change = pd.Series({"change_percent": 147.2, "change_low_percent": 140.1, "change_high_percent": 154.4})
    assert change_words(change) == "+147 % (+140 to +154)"
    assert change_words(change * 0 + 3.04) == "+3.0 %", "an interval without a width"
    assert change_words(change.replace(140.1, np.nan)) == "+147 %"


def test_the_short_table_has_each_strategy_at_its_thickness_with_force_and_changes():
    given = tables(
        compression=[*STANDARD_AND["compression"], pressed("standard", 50.0, 300.0, "compression")],
        image=[imaged("standard", 2.0, dose_se_mgy=0.02), imaged("gentle", 2.2, dose_se_mgy=0.02)],
    )
    rows = short_table(asked(given)[0]).set_index("strategy")
    assert rows.loc[["standard", "gentle"], "thickness_mm"].tolist() == [50.0, 55.0]
    force = rows.force_n.str.replace("\N{NO-BREAK SPACE}", " ")
    assert (force["standard"], force["gentle"]) == ("100 (100 to 300)", "60.0")
    assert rows.loc["gentle", "dose"].replace("\N{NO-BREAK SPACE}", " ").startswith("+10 % (+")


def test_one_strategy_alone_gives_no_answer_and_says_what_would():
    given = tables(compression=[pressed("standard", 50.0, 100.0)], image=[imaged("standard", 2.0)])
    costs, found = asked(given)
    assert (found.verdict, found.shown) == (UNKNOWN, "")
    assert "it cannot be said how far compression can be reduced**: no strategy with less" in sentence(
        found, costs, LIMITS
    )
    row = limits_table([found], costs, given, KNOWN).iloc[0]
    assert row.what_would_say_it == "more names in compression.strategies and xray.strategies"


def test_a_strategy_that_was_not_x_rayed_says_what_it_does_and_not_what_it_costs():
    given = tables(**STANDARD_AND, image=[imaged("standard", 2.0)])
    costs, found = asked(given)
    assert (found.verdict, found.not_known, found.shown) == (UNKNOWN, "gentle", "gentle")
    words = sentence(found, costs, LIMITS)
    assert "no strategy with less compression than the standard has an image and a dose" in words
    assert "what it costs is not known; strain −9.1 %" in words
    row = limits_table([found], costs, given, KNOWN).iloc[0]
    assert (row.cannot_be_said, row.because) == (FAR, found.why)


def test_missing_rows_say_why_and_leave_the_others_alone():
    gone = {"outcome": "missing: compress ada left standard: no equilibrium"}
    rows = [pressed("standard", np.nan, np.nan) | gone, pressed("gentle", 55.0, 60.0)]
    _, found = asked(tables(compression=rows, image=[imaged("gentle", 2.0)]))
    assert found.why == "compress ada left standard: no equilibrium"
    image = [
        imaged("standard", np.nan) | {"outcome": "missing: no photons"},
        imaged("gentle", 2.0) | {"outcome": None},
    ]
    _, found = asked(tables(**STANDARD_AND, image=image))
    assert found.verdict == UNKNOWN
    assert found.why == "the standard strategy, which the others are compared with, has no image and no dose"


def test_where_nobody_is_pressed_the_reason_is_what_her_data_do_not_allow():
    known = Known(("left",), not_planned=(("ada", "compression", "ada was not scanned prone"),))
    why = why_not_pressed(ASKED, known, {})
    found = answers(strategy_costs({}, numerical=EXACT, limits=LIMITS), {}, LIMITS, asked=ASKED, why_not=why)
    assert [each.why for each in found] == ["ada was not scanned prone"] * 2
    table = answer_table(found)
    assert table.verdict.tolist() == [UNKNOWN] * 2
    assert table.possible_mm.isna().all()
    rows = limits_table(found, strategy_costs({}, numerical=EXACT, limits=LIMITS), {}, known)
    assert rows.breasts.tolist() == ["ada left, ada right", *["all"] * len(ALWAYS)]


def test_a_side_that_is_not_pressed_says_how_to_get_it():
    given = tables(**STANDARD_AND, image=[imaged("standard", 2.0), imaged("gentle", 2.0)])
    known = breasts(given)
    costs = strategy_costs(known, numerical=EXACT, limits=LIMITS)
    found = answers(costs, known, LIMITS, asked=ASKED, why_not=why_not_pressed(ASKED, KNOWN, given))
    rows = limits_table(found, costs, given, KNOWN).set_index("cannot_be_said")
    assert rows.breasts["anything of this breast"] == "ada right"
    assert rows.what_would_say_it["anything of this breast"] == "name the side in compression.sides"


def test_moduli_that_no_fit_found_and_a_digital_woman_are_named():
    given = tables(**STANDARD_AND, image=[imaged("standard", 2.0), imaged("gentle", 2.0)])
    one = "ada was scanned in one position, two are needed"
    costs, found = asked(given)
    rows = limits_table([found], costs, given, Known(("left",), not_planned=(("ada", "fit of moduli", one),)))
    assert rows.because.str.contains(f"those of the literature are assumed: {one}").sum() == 1
    fitted = given | tables(
        identification=[
            {"volunteer": "ada", "side": "left", "tissue": "glandular", "identifiable": False},
            {"volunteer": "ada", "side": "left", "tissue": "muscle", "identifiable": False},
        ]
    )
    rows = limits_table([found], costs, fitted, Known(("left",), digital=("ada",)))
    assert rows.because.str.endswith("do not determine the modulus of: glandular").sum() == 1
    assert rows.because.str.startswith("a digital volunteer").sum() == 1


FAR = "how far compression can be reduced"


@pytest.mark.parametrize(
    ("dose", "numerical", "unsaid"),
    [
        (2.4, EXACT, set()),
        (2.02, EXACT, {f"{FAR} further"}),
        (2.4, Numerical(contrast=0.0, calcification=0.0), {"how sure the change of dose is"}),
        (2.4, Numerical(0.0, calcification=0.0), {"how sure the change of d' of the mass is"}),
        (np.nan, EXACT, {"what less compression does to dose"}),
    ],
)
def test_what_cannot_be_said_of_a_loss_is_named_and_nothing_else(dose, numerical, unsaid):
    """A thinner strategy whose losses are known says nothing of less compression."""
    given = tables(
        compression=[*STANDARD_AND["compression"], pressed("firm", 45.0, 140.0)],
        image=[imaged("firm", 1.8), imaged("standard", 2.0), imaged("gentle", dose)],
    )
    costs, found = asked(given, numerical)
    about_losses = ("how far", "how sure", "what less")
    rows = limits_table([found], costs, given, KNOWN)
    assert {each for each in rows.cannot_be_said if each.startswith(about_losses)} == unsaid


def test_what_was_chosen_for_some_of_her_strategies_is_named():
    rows = [
        pressed("standard", 50.0, 100.0, moduli_factor=3.0),
        pressed("gentle", 55.0, 60.0, thickness_from="chosen: 0.5 of the 100 mm"),
    ]
    given = tables(compression=rows, image=[imaged("standard", 2.0), imaged("gentle", 2.0)])
    costs, found = asked(given)
    table = limits_table([found], costs, given, KNOWN)
    assert (table.cannot_be_said == "how thick her breast is in a mammogram").sum() == 1
    assert (table.because == "only moduli times 3 carry her weight").sum() == 1


def test_what_was_chosen_for_her_is_named():
    rows = [
        row | {"thickness_from": "half of 100 mm", "moduli_factor": 2.0}
        for row in STANDARD_AND["compression"]
    ]
    given = tables(compression=rows, image=[imaged("standard", 2.0), imaged("gentle", 2.0)])
    costs, found = asked(given)
    table = limits_table([found], costs, given, KNOWN)
    assert table.because.str.contains("no thickness is given for her").sum() == 1
    assert table.because.str.contains("only moduli times 2 carry her weight").sum() == 1


def test_each_breast_is_told_by_its_own_rows():
    places = {("ada", "left"): 5.0, ("ada", "right"): 50.0, ("bea", "left"): 500.0}
    rows, images = [], []
    for (volunteer, side), newton in places.items():
        where = {"volunteer": volunteer, "side": side}
        rows += [pressed("standard", 50.0, 1.5 * newton, **where), pressed("gentle", 55.0, newton, **where)]
        images += [imaged("standard", 2.0, **where), imaged("gentle", 2.0 + newton / 100, **where)]
    given = tables(compression=rows, image=images)
    known = breasts(given)
    costs = strategy_costs(known, numerical=EXACT, limits=LIMITS)
    found = answers(costs, known, LIMITS, asked=[*places, ("bea", "right")], why_not={})
    told = [sentence(each, costs, LIMITS) for each in found]
    for words, who, force, change in zip(
        told, ("ada, left", "ada, right", "bea, left"), ("5.00", "50.0", "500"), ("+2.5", "+25", "+250")
    ):
        assert words.startswith(f"**{who}: thickness may rise")
        assert f"`gentle` (55.0 mm, {force} N)" in words
        assert f"dose {change} %" in words
    assert (
        told[-1]
        == "**bea, right: it cannot be said how far compression can be reduced**: it was not pressed."
    )
    assert [each.standard_n for each in found[:3]] == [7.5, 75.0, 750.0]


def test_changes_have_a_sign_and_two_digits():
    assert [percent(each) for each in (147.4, -30.04, 5.74, -0.8, 9.96)] == [
        "+147",
        "−30",
        "+5.7",
        "−0.8",
        "+10",
    ]


def test_the_short_table_has_the_values_of_the_standard_and_the_changes_of_the_others():
    given = tables(**STANDARD_AND, image=[imaged("standard", 2.0), imaged("gentle", 2.4)])
    table = short_table(asked(given)[0]).set_index("strategy")
    assert table.dose["standard"] == "2\N{NO-BREAK SPACE}mGy"
    assert table.dose["gentle"] == "+20\N{NO-BREAK SPACE}%"
    assert table["d' of mass"]["gentle"].split(" ")[0] == "+0.0\N{NO-BREAK SPACE}%"
    assert table.costs.to_dict() == {"standard": "", "gentle": MORE}


def test_the_figure_has_a_panel_per_quantity_and_shades_the_range():
    given = tables(
        **STANDARD_AND,
        image=[imaged("standard", 2.0), imaged("gentle", 2.4)],
        compression_path=[
            {"volunteer": "ada", "side": "left", "strategy": "standard", "moduli": "gravity",
             "thickness_mm": t, "force_n": f, "mean_pressure_kpa": f / 10}
            for t, f in ((60.0, 20.0), (50.0, 100.0))
        ],
    )  # fmt: skip
    costs, found = asked(given)
    shown = answer_table([found])
    figure = drawn(
        shown, costs, given["compression"], given["compression_path"], volunteer="ada", side="left",
        loss_percent={"dose": 5.0, "detectability": 5.0},
    )  # fmt: skip
    assert [ax.get_title(loc="left")[3:] for ax in figure.axes] == list(PANELS.values())
    low, high = figure.axes[0].get_xlim()
    assert low < 50 < found.possible_mm < 55 < high
    shaded = [patch.get_x() for patch in figure.axes[1].patches]
    assert shaded == [pytest.approx(50.0), pytest.approx(found.certain_mm)]


def test_strategies_of_one_thickness_are_drawn_over_their_forces():
    rows = [pressed("standard", 50.0, 100.0), pressed("flexible", 50.2, 60.0, deflection_mm=1.0)]
    given = tables(compression=rows, image=[imaged("standard", 2.0), imaged("flexible", 2.0)])
    costs, found = asked(given)
    path = pd.DataFrame(columns=["volunteer", "side", "strategy", "moduli", "thickness_mm", *DONE.values()])
    figure = drawn(
        answer_table([found]), costs, given["compression"], path, volunteer="ada", side="left",
        loss_percent={"dose": 5.0, "detectability": 5.0},
    )  # fmt: skip
    assert {ax.get_xlabel() for ax in figure.axes[-2:]} == {"force (N)"}


def test_many_strategies_have_room_in_the_figure():
    names = [f"way{k:02d}" for k in range(40)]
    rows = [pressed(name, 51.0 + k, 90.0 - k) for k, name in enumerate(names)]
    given = tables(
        compression=[pressed("standard", 50.0, 100.0), *rows],
        image=[imaged("standard", 2.0), *(imaged(name, 2.0 + 0.08 * k) for k, name in enumerate(names))],
    )
    costs, found = asked(given)
    assert found.less.split() == ["way00", "way01"]
    path = pd.DataFrame(columns=["volunteer", "side", "strategy", "moduli", "thickness_mm", *DONE.values()])
    figure = drawn(
        answer_table([found]), costs, given["compression"], path, volunteer="ada", side="left",
        loss_percent={"dose": 5.0, "detectability": 5.0},
    )  # fmt: skip
    (legend,) = figure.legends
    named = [text.get_text() for text in legend.get_texts()]
    assert "41 strategies, 9 named:" in named
    assert len(named) < 20


def test_plates_that_slope_are_curved_or_soft_are_not_level():
    rows = pd.DataFrame(
        {
            "tilt_deg": [0.0, 3.0, 0.0, 0.0],
            "deflection_mm": [0.0, 4.0, 5.0, 0.0],
            "thickness_min_mm": [50.0, 48.0, 50.0, 50.0],
            "thickness_max_mm": [50.0, 52.0, 50.0, 51.0],
        }
    )
    assert is_level(rows).tolist() == [True, False, False, False]
