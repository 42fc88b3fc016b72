"""Campaigns: what a file may say, which points it means, what they are called, what explains an answer."""

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
import yaml
from markupsafe import Markup, escape
from small_breast import STREAMS, study_settings

from mammosim.chain.graph import Chain
from mammosim.chain.stages import STAGES
from mammosim.chain.subject import Subject
from mammosim.core.errors import ConfigurationError
from mammosim.study.campaigns import prediction
from mammosim.study.campaigns.campaign import Campaign
from mammosim.study.campaigns.grouping import batches, inputs, parameters, stored
from mammosim.study.campaigns.page import opening
from mammosim.study.campaigns.points import Case, plan
from mammosim.study.campaigns.settings import Known, changes
from mammosim.study.campaigns.table import failures, frame, shares, summary
from mammosim.study.report.texts import paragraphs, quoted

FILE = "config/campaigns/mine.yaml"
GLAND = "tissues.glandular.youngs_modulus_kpa"


def read(text: str) -> Campaign:
    given = {"title": "a question", "subjects": {"small": ["left"]}, "asked": ["force_n"]}
    return Campaign.of("mine", given | yaml.safe_load(text), file=FILE)


@pytest.fixture(scope="module")
def known(repository) -> Known:
    def values(path: str):
        return yaml.safe_load((repository / path).read_text())

    schemas = {
        kind: values(f"workflow/schemas/{kind}.schema.yaml") for kind in ("config", "tissues", "compression")
    }
    tissues = {name: values(f"config/tissues/{name}.yaml") for name in ("standard", "layered")}
    return Known(schemas, values("config/strategies.yaml"), tissues, study_settings(repository))


@pytest.fixture(scope="module")
def case(repository) -> Case:
    settings = study_settings(repository)
    chain = Chain(
        Subject("left", "0 -1 0", STREAMS), settings, frozenset(settings["mechanics"]["effects"]), STAGES
    )
    return Case(
        "small",
        "left",
        chain,
        lambda load: chain,
        lambda product, load: {
            file: f"{product}{end}" for file, end in STAGES[product].files.endings.items()
        },
    )


def planned(text, case, known, library="code"):
    return plan(read(text), [case], known, library)


def test_a_range_is_even_or_even_in_its_logarithm():
    campaign = read(
        f"vary: {{{GLAND}: {{from: 0.5, to: 50, number: 3, scale: log}}, "
        "load.thickness_mm: {from: 40, to: 50, number: 3}}"
    )
    shown = [tuple(point.shown.values()) for point in campaign.points()]
    assert shown == [(e, t) for e in (0.5, 5, 50) for t in (40, 45, 50)]
    assert campaign.size == 9


def test_a_whole_number_is_one_however_it_is_written():
    """YAML reads 1e1 as a number with a point; no whole number of the table has more than 64 bits."""
    (gland,) = read(f"vary: {{{GLAND}: {{from: 1.0, to: 10.0, number: 1.0e+1}}}}").axes
    assert [level.shown for level in gland.levels] == list(range(1, 11))
    assert read(f"vary: {{{GLAND}: {{from: 1, to: 2}}}}\ndesign: {{sobol: 16.0}}").design.number == 16
    (gland,) = read(f"vary: {{{GLAND}: [1.0, {10**23}]}}").axes
    assert [type(level.shown) for level in gland.levels] == [int, float]


def test_a_sobol_sequence_of_more_points_begins_with_those_of_fewer():
    text = "vary: {%s: {from: 0.5, to: 50, scale: log}, load.thickness_mm: {from: 40, to: 50}}\n"
    text += "design: {sobol: %d}"
    few, many = ([p.shown for p in read(text % (GLAND, n)).points()] for n in (8, 16))
    assert many[:8] == few
    moduli = np.log([p[GLAND] for p in many])
    # A balanced sequence has one point in each sixteenth of the logarithm's span.
    assert sorted(np.floor(16 * (moduli - np.log(0.5)) / np.log(100)).astype(int)) == list(range(16))


@pytest.mark.parametrize("design", ["sobol: 8", "latin_hypercube: 5", "saltelli: 4"])
def test_a_seed_chooses_the_sample(design):
    text = f"vary: {{{GLAND}: {{from: 1, to: 2}}, load.thickness_mm: {{from: 40, to: 50}}}}\n"
    seeds = ["", ", seed: 1", ", seed: 2"]
    same, first, other = (
        [point.shown for point in read(f"{text}design: {{{design}{seed}}}").points()] for seed in seeds
    )
    assert same == first
    assert not any(point in first for point in other)


def test_every_breast_has_all_points():
    campaign = read(f"subjects: {{small: [left, right], large: [left]}}\nvary: {{{GLAND}: [1, 2]}}")
    assert campaign.size == 3 * 2
    assert campaign.subjects == (("small", "left"), ("small", "right"), ("large", "left"))


def test_a_load_that_is_given_takes_the_place_of_the_studys():
    text = f"vary: {{{GLAND}: [1]}}\n"
    assert read(text).load == {"strategy": "standard", "moduli": "gravity"}
    assert read(text + "load: {moduli: layered}").load == {"strategy": "standard", "moduli": "layered"}


def test_a_list_beside_a_design_has_all_its_points_for_each_value():
    campaign = read(
        f"vary: {{{GLAND}: {{from: 1, to: 2}}, load.paddle: [standard, flexible]}}\n"
        "design: {latin_hypercube: 5, seed: 3}"
    )
    points = list(campaign.points())
    assert len(points) == campaign.size == 10
    assert {p.shown["load.paddle"] for p in points[:5]} == {"standard"}


def test_points_that_a_condition_excludes_are_left_out():
    campaign = read(
        f"vary: {{{GLAND}: [1, 10], load.thickness_mm: [40, 50], load.paddle: [standard, flexible]}}\n"
        f"exclude: ['load.thickness_mm < 45 and {GLAND} > 5', "
        "'load.paddle == \"flexible\" and not load.thickness_mm / 10 >= 5']"
    )
    shown = [tuple(point.shown.values()) for point in campaign.points()]
    assert shown == [
        (1, 40, "standard"),
        (1, 50, "standard"),
        (1, 50, "flexible"),
        (10, 50, "standard"),
        (10, 50, "flexible"),
    ]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (f"vary: {{{GLAND}: {{from: 1, number: 3}}}}", f"vary.{GLAND} has no end: add `to:`"),
        (
            f"vary: {{{GLAND}: {{from: 1, to: 3}}}}",
            "has no number of values: add `number:` to it, or a `design:`",
        ),
        (f"vary: {{{GLAND}: {{from: 3, to: 1, number: 3}}}}", "from = 3 is not below to = 1"),
        (f"vary: {{{GLAND}: {{from: 3, to: 3, number: 3}}}}", "from = 3 is not below to = 3"),
        (f"vary: {{{GLAND}: {{from: 0, to: 1, number: 3, scale: log}}}}", "begins above 0"),
        (f"vary: {{{GLAND}: {{from: 1, to: .inf, number: 3}}}}", "to = inf is no finite number"),
        (f"vary: {{{GLAND}: {{from: 1, to: 2, number: 3, step: 1}}}}", "has no key 'step'"),
        (f"vary: {{{GLAND}: {{from: 1, to: 2, number: 1000000000}}}}", "1,000,000,000 is more than 100,000"),
        (f"vary: {{{GLAND}: []}}", "give a list of values"),
        (f"vary: {{{GLAND}: [1, 2.0, 2]}}", "has 2 twice"),
        (f"vary: {{{GLAND}: [1, .nan]}}", "has nan, which is no finite number"),
        (f"vary: {{{GLAND}: {{from: 1, to: {10**400}, number: 3}}}}", "is no finite number"),
        (f"vary: {{{GLAND}: [1, null]}}", "has an empty value; name it, as {named: {none: null"),
        ("vary: {load.paddle: {named: {'': standard}}}", "an empty name; write one"),
        ('vary: {load.paddle: {named: {"a\\rb": standard}}}', r"has 'a\rb': no line of a table has"),
        ('vary: {load.paddle: [standard, "a\\nb"]}', r"has 'a\nb': no line of a table has such a character"),
        (
            f"vary: {{{GLAND}: {{from: 1, to: 1.0000001}}}}\ndesign: {{sobol: 16}}",
            "1 and 1.0000001 are one value of 6 digits; widen it",
        ),
        (
            "vary: {tissues.skin.thickness_mm: [1, 2], tissues.skin: {named: {thin: {}}}}",
            "vary.tissues.skin.thickness_mm is inside vary.tissues.skin, whose values would take its place",
        ),
        (f"vary: {{{GLAND}: {{from: 1, to: 1.00002, number: 9}}}}", "has 3 values of 6 digits and not 9"),
        (f"vary: {{{GLAND}: {{from: 1, to: 2}}}}\ndesign: {{saltelli: 1}}", "saltelli = 1: no interval"),
        ("vary: {load.paddle: [{tilting: {stiffness_n_mm_per_rad: 1}}]}", "name it, as {named:"),
        (
            f"vary: {{{GLAND}: {{from: 1, to: 2}}}}\ndesign: {{sobol: 100}}",
            "needs a power of two; write 64 or 128",
        ),
        (
            f"vary: {{{GLAND}: {{from: 1, to: 2}}}}\ndesign: {{sobol: 1000000000}}",
            "1,000,000,000 points are more than 100,000",
        ),
        (
            f"vary: {{{GLAND}: {{from: 1, to: 2}}}}\ndesign: {{random: 10}}",
            "write one of sobol, latin_hypercube, saltelli",
        ),
        (f"vary: {{{GLAND}: [1]}}\ndesign: {{sobol: 64}}", "design has nothing to sample"),
        (
            f"vary: {{{GLAND}: {{from: 1, to: 9, number: 1000}}, load.thickness_mm: "
            "{from: 1, to: 9, number: 1000}}",
            "1,000,000 points are more than 100,000",
        ),
        (
            f"vary: {{{GLAND}: [1]}}\nasked: [agd_percent]",
            "no stage answers 'agd_percent'; did you mean 'agd_mgy'?",
        ),
        (
            f"vary: {{{GLAND}: [1]}}\nasked: [nipple_mm]",
            "nipple_mm needs a position: add `load: {position: upright}`",
        ),
        (f"vary: {{{GLAND}: [1]}}\nexclude: ['tissue.glandular > 1']", "'tissue.glandular' is not varied"),
        (f"vary: {{{GLAND}: [1]}}\nexclude: ['__import__(\"os\")']", "is not understood"),
        (f"vary: {{{GLAND}: [1]}}\nexclude: ['{GLAND} ** 9 > 1']", "is not understood"),
        (f"vary: {{{GLAND}: [1]}}\nexclude: ['{GLAND} <']", "exclude[0]"),
    ],
)
def test_a_file_that_cannot_be_meant_is_refused_in_one_line_with_its_key(text, words):
    with pytest.raises(ConfigurationError) as error:
        read(text)
    assert words in str(error.value)
    assert str(error.value).startswith(FILE)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "vary: {tissues.glandular.youngs_modulus_mpa: [1]}",
            "did you mean 'tissues.glandular.youngs_modulus_kpa'?",
        ),
        ("vary: {xray.peak_kv: [28, 30]}", "changes nothing of force_n"),
        ("vary: {compression.sides: [left]}", "changes nothing of force_n"),
        (f"vary: {{{GLAND}: [-1, 1000]}}", "no value of it is allowed"),
        ("vary: {load.paddle: [standard, hard]}\nexclude: ['load.paddle == \"standard\"']", "no point of"),
        (f"vary: {{{GLAND}: [1, 2]}}\nexclude: ['{GLAND} > 0']", "exclude leaves no point"),
        (f"vary: {{{GLAND}: [1, 2]}}\nexclude: ['{GLAND} > \"a\"']", "cannot be decided"),
        (f"vary: {{{GLAND}: [1, 2]}}\nexclude: ['{GLAND}']", "neither true nor false"),
        (f"vary: {{{GLAND}: [1, 2]}}\nexclude: ['not {GLAND}']", "1 is neither true nor false; correct it"),
        (
            f"vary: {{{GLAND}: [1, 2]}}\nexclude: ['{GLAND} == 1 or 2']",
            "2 is neither true nor false; correct",
        ),
        (f'vary: {{{GLAND}: [1, 2]}}\nexclude: [\'"a" * 999999999 == "b"\']', "'a' is no number"),
    ],
)
def test_settings_that_do_not_exist_act_on_nothing_or_have_no_allowed_value_are_refused(
    text, words, case, known
):
    with pytest.raises(ConfigurationError) as error:
        planned(text, case, known)
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_a_value_that_the_schema_does_not_allow_fails_its_points_alone(case, known):
    points = planned(f"vary: {{{GLAND}: [1, -1], load.thickness_mm: [40, 50]}}", case, known)
    assert [bool(point.rejected) for point in points] == [False, False, True, True]
    assert f"{GLAND} = -1: must be a number more than 0" in points[2].rejected
    assert FILE in points[2].rejected


def test_a_value_added_leaves_every_other_point_its_name(case, known):
    text = "vary: {%s: %s, load.thickness_mm: [40, 50]}"
    before, after = (planned(text % (GLAND, v), case, known) for v in ([1, 2], [0.5, 1, 2, 3]))
    names = {point.name for point in before}
    assert len(names) == 4
    assert names < {point.name for point in after}
    # Written in another way, it is the same point; of other code it is another one.
    again = planned(text % (GLAND, "{from: 1, to: 2, number: 2}"), case, known)
    assert {point.name for point in again} == names
    assert not names & {point.name for point in planned(text % (GLAND, [1, 2]), case, known, library="other")}


def test_a_point_reads_of_the_study_what_it_has_in_common_with_it(case, known):
    points = planned("vary: {load.tissues.glandular.youngs_modulus_kpa: [1, 5]}", case, known)
    assert set(points[0].kept) == {"pressed", "stress_free"}, "as the study has it"
    assert {"stress_free", "mesh"} <= set(points[1].kept)
    assert not {"stress_free", "mesh"} & set(points[1].own)
    assert {"pressed", "standard_path"} <= set(points[1].own)
    assert inputs(points) == list(dict.fromkeys(inputs(points)))
    # Another body has another stress-free shape.
    (softer,) = planned(f"vary: {{{GLAND}: [5]}}", case, known)
    assert "stress_free" in softer.own
    assert "mesh" in softer.kept


def test_what_points_share_is_kept_and_brings_them_into_one_batch(case, known):
    moduli, thicknesses = 40, 3
    text = f"vary: {{{GLAND}: {{from: 1, to: 40, number: {moduli}}}, load.thickness_mm: [41, 46, 51]}}"
    points = planned(text, case, known)
    shared = stored(points)
    assert sum(product == "stress_free" for product, _ in shared) == moduli - 1  # one is the study's
    assert not any(product == "pressed" for product, _ in shared)
    found = batches(points)
    assert sorted(p.name for batch in found.values() for p in batch) == sorted({p.name for p in points})
    assert 2 <= len(found) <= 2 * moduli * thicknesses / 25 + 2
    for batch in found.values():
        unloaded = [point.own.get("stress_free") for point in batch]
        assert len({*unloaded}) * thicknesses == len(unloaded), "none is made in two jobs"
        others = sum(a != b for a, b in pairwise(unloaded))
        assert others == len({*unloaded}) - 1, "those that share it are neighbours"
    (given, *_) = (parameters(batch, shared) for batch in found.values())
    assert {"unloaded", "stress_free"} >= {name for point in given["points"] for name in point["stored"]}


def test_points_that_mean_the_same_have_a_row_each_and_are_computed_once(case, known):
    """The paddles of both strategies are rigid."""
    points = planned("vary: {load.paddle: [standard, reduced], load.thickness_mm: [41, 46]}", case, known)
    assert len(points) == 4
    assert len({point.name for point in points}) == 2
    assert stored(points) == set()
    ((batch,),) = [list(batches(points).values())]
    assert sorted(point.shown["load.paddle"] for point in batch) == ["reduced"] * 2 + ["standard"] * 2
    assert prediction.counts(points, RIGID, done=())["standard_path"] == 2


def test_batches_keep_their_points_when_a_value_is_added(case, known):
    text = "vary: {%s: %s, load.thickness_mm: [41, 46]}"
    few, more = [*range(1, 41)], [*range(1, 46)]
    before, after = (batches(planned(text % (GLAND, moduli), case, known)) for moduli in (few, more))
    assert set(before) <= set(after)
    for name, batch in before.items():
        assert {point.name for point in batch} <= {point.name for point in after[name]}
    changed = sum(len(batch) > len(before.get(name, [])) for name, batch in after.items())
    assert changed < len(after)


def test_paddle_strategy_and_thickness_make_one_load(known):
    base = known.settings
    found = changes(
        {"load.paddle": "flexible", "load.until.force_n": 50, "load.thickness_mm": 41}, base, known
    )
    assert found == {
        "load.strategy": {"until": {"force_n": 50}, "paddle": known.strategies["flexible"]["paddle"]},
        "load.thickness_mm": 41,
    }
    both = changes({GLAND: 3}, base, known)
    assert both["tissues"]["tissues"]["glandular"]["youngs_modulus_kpa"] == 3
    assert both["load.tissues"] == both["tissues"], "what hangs is what is pressed"
    alone = changes({f"load.{GLAND}": 3}, base, known)
    assert set(alone) == {"load.tissues"}
    with pytest.raises(ConfigurationError, match="a paddle stops by one of them"):
        changes({"load.until.force_n": 50, "load.until.thickness_share": 1}, base, known)


def test_single_values_may_be_changed_of_a_file_of_tissues(case, known):
    points = planned(f"vary: {{{GLAND}: [3, 4], tissues: [standard, layered]}}", case, known)
    assert len({point.name for point in points}) == 4


def test_sets_of_moduli_are_taken_by_their_names(known):
    base, standard, layered = known.settings, known.tissues["standard"], known.tissues["layered"]
    assert standard != layered
    found = changes({"load.moduli": "layered"}, base, known)
    assert found == {"load.tissues": layered, "load.moduli": "layered"}
    both = changes({"tissues": "layered"}, base, known)
    assert both == {"tissues": layered, "load.tissues": layered}
    softer = changes({"load.moduli": "layered", f"load.{GLAND}": 7}, base, known)["load.tissues"]
    assert softer["tissues"]["glandular"]["youngs_modulus_kpa"] == 7
    assert softer["tissues"]["adipose"] == layered["tissues"]["adipose"]


def test_a_value_is_held_against_both_limits(known):
    limits = {"type": "number", "minimum": 1, "maximum": 2}
    for given in (limits, {"type": "number", "exclusiveMinimum": 0.5, "exclusiveMaximum": 2.5}):
        schema = {"properties": {"a": {"type": "object", "properties": {"b": given}}}}
        other = replace(known, schemas={"config": schema})
        assert [bool(other.fault("a.b", value, FILE)) for value in (0.5, 1, 2, 2.5)] == [
            True,
            False,
            False,
            True,
        ]


def test_effects_may_be_varied_and_tell_points_apart(case, known):
    everything = sorted(case.chain.effects)
    text = f"vary: {{mechanics.effects: {{named: {{all: {everything}, none: []}}}}}}"
    both, none = planned(text, case, known)
    assert both.name != none.name
    assert set(both.effects) >= case.chain.effects
    assert "skin" not in none.effects
    assert both.own.get("body") != none.own["body"]
    assert "mechanics.effects" not in none.changes


def test_a_job_reads_for_each_point_what_that_reads(case, known):
    points = planned("vary: {load.tissues.glandular.youngs_modulus_kpa: [1, 5]}", case, known)
    given = parameters(points, stored(points))
    for point, told in zip(points, given["points"], strict=True):
        assert given["kept"][told["kept"]] == point.kept
    assert given["kept"][0] != given["kept"][1]


def rows(campaign, values):
    for n, point in enumerate(campaign.points()):
        yield {
            **{"point": str(n), "volunteer": "small", "side": "left", "shown": dict(point.shown)},
            **{"answers": {"force_n": values(point.shown)}, "errors": {}, "seconds": 1.0},
            **{"outcome": "converged", "reason": "", "moduli_factor": 1.0},
        }


def test_shares_of_a_full_grid_add_up_and_tell_what_acts_together():
    campaign = read(f"vary: {{{GLAND}: [1, 2, 3], load.thickness_mm: [40, 50]}}")

    def force(shown):
        return (
            shown[GLAND]
            + 0.1 * shown["load.thickness_mm"]
            + 0.05 * shown[GLAND] * (shown["load.thickness_mm"] - 45)
        )

    found = shares(campaign, frame(campaign, rows(campaign, force))).set_index("setting").share
    assert found.sum() == pytest.approx(1)
    # By hand: gland -1, 0, 1 has variance 2/3; thickness at the mean gland 1; together 0.25^2 2/3.
    expected = np.array([2 / 3, 1.0, 0.25**2 * 2 / 3])
    assert found.to_numpy() == pytest.approx(expected / expected.sum())
    gap = frame(
        campaign, [{**row, "answers": {}} if row["point"] == "2" else row for row in rows(campaign, force)]
    )
    assert shares(campaign, gap).empty, "with a gap a grid tells nothing"


def test_sobol_indices_of_saltellis_design_are_those_of_a_linear_answer():
    campaign = read(
        f"vary: {{{GLAND}: {{from: 0, to: 1}}, load.thickness_mm: {{from: 0, to: 1}}}}\n"
        "design: {saltelli: 256}"
    )
    table = frame(campaign, rows(campaign, lambda shown: 2 * shown[GLAND] + shown["load.thickness_mm"]))
    assert len(table) == campaign.size == 256 * 4
    found = shares(campaign, table).set_index("setting")
    assert found.share.to_numpy() == pytest.approx([0.8, 0.2], abs=0.02)
    assert found.total.to_numpy() == pytest.approx([0.8, 0.2], abs=0.02)
    assert (found.low < found.share).all()
    assert (found.share < found.high).all()


def test_what_two_settings_do_only_together_is_in_the_total_and_not_in_the_first_order():
    """Of f = x y with both uniform in -1 to 1 each index of first order is 0, and each total index 1.

    The estimate of the first order has a standard deviation of about 1.5 / sqrt(n).
    """
    campaign = read(
        f"vary: {{{GLAND}: {{from: 0, to: 2}}, load.thickness_mm: {{from: 0, to: 2}}}}\n"
        "design: {saltelli: 1024}"
    )
    table = frame(
        campaign, rows(campaign, lambda shown: (shown[GLAND] - 1) * (shown["load.thickness_mm"] - 1))
    )
    found = shares(campaign, table)
    assert found.share.to_numpy() == pytest.approx([0.0, 0.0], abs=0.15)
    assert found.total.to_numpy() == pytest.approx([1.0, 1.0], abs=0.15)


def test_the_table_has_values_units_errors_and_reasons():
    campaign = replace(read(f"vary: {{{GLAND}: [2, 1]}}"), asked=("nipple_mm", "agd_mgy"))
    answers = {"nipple_x_mm": 1.0, "nipple_y_mm": 2.0, "nipple_z_mm": 3.0, "agd_mgy": 1.5}
    good, bad = (row | {"seconds": 2.5} for row in rows(campaign, lambda shown: 0.0))
    good |= {"answers": answers, "errors": {"agd_mgy": 0.1}}
    bad |= {"answers": {}, "outcome": "failed", "reason": "no equilibrium", "moduli_factor": 1.5}
    table = frame(campaign, [good, bad])
    assert list(table.columns) == [
        *(
            "volunteer",
            "side",
            GLAND,
            "nipple_x_mm",
            "nipple_y_mm",
            "nipple_z_mm",
            "agd_mgy",
            "agd_mgy_error",
        ),
        *("moduli_factor", "outcome", "reason", "seconds", "point"),
    ]
    assert list(table[GLAND]) == [1, 2]
    assert table.agd_mgy_error.iloc[1] == 0.1
    assert table.moduli_factor.tolist() == [1.5, 1.0]
    assert table.agd_mgy.isna().tolist() == [True, False]
    assert failures(table).to_dict("records") == [
        {"outcome": "failed", "reason": "no equilibrium", "points": 1}
    ]
    assert pd.api.types.is_float_dtype(table.seconds)


def test_volunteers_stand_in_the_order_of_the_campaign():
    campaign = read(f"subjects: {{zoe: [left], ada: [left]}}\nvary: {{{GLAND}: [2, 1]}}")
    made = [row | {"volunteer": v} for v in ("ada", "zoe") for row in rows(campaign, lambda shown: 1.0)]
    table = frame(campaign, made)
    assert table.volunteer.tolist() == ["zoe", "zoe", "ada", "ada"]
    assert table[GLAND].tolist() == [1, 2, 1, 2]


def test_a_condition_holds_up_to_its_limit_or_with_it():
    text = f"vary: {{{GLAND}: [1, 2, 3]}}\nexclude: ['{GLAND} %s 2']"
    for sign, kept in {"<": [2, 3], "<=": [3], ">": [1, 2], ">=": [1], "==": [1, 3], "!=": [2]}.items():
        assert [point.shown[GLAND] for point in read(text.replace("%s", sign)).points()] == kept


def test_the_page_counts_answers_points_left_out_and_minutes():
    campaign = read(f"vary: {{{GLAND}: [1, 2, 3]}}\nexclude: ['{GLAND} > 2']")
    table = frame(campaign, rows(campaign, lambda shown: 1.0))
    words = opening(campaign, table.assign(outcome=["converged", "failed"], seconds=90.0))
    assert "2 points, of which 1 have an answer; 1 more were left out" in words
    assert "3.0 minutes of a processor" in words
    assert "Of small left; accuracy `study`, strategy `standard`, moduli `gravity`." in words
    three = pd.concat([table, table[:1]]).assign(force_n=[1.0, 2.0, 6.0])
    assert summary(campaign, three).iloc[0].tolist() == ["force_n", 3, 1.0, 2.0, 6.0]


def test_reasons_are_counted_the_most_frequent_first():
    campaign = read(f"vary: {{{GLAND}: [1, 2, 3, 4]}}")
    table = frame(campaign, rows(campaign, lambda shown: 1.0))
    table = table.assign(outcome=["failed", "unstable", "unstable", "converged"], reason=["a", "b", "b", ""])
    assert failures(table).to_numpy().tolist() == [["unstable", "b", 2], ["failed", "a", 1]]


MARKED = r"costs $5 or $\frac$ of {it}? **a** [b](javascript:c) `d`"


def test_title_names_and_conditions_stand_on_the_page_as_they_were_written():
    given = {"title": MARKED, "subjects": {"small": ["left"]}, "asked": ["force_n"]}
    given["vary"] = {"load.thickness_mm": [40, 50], "load.paddle": {"named": {MARKED: "standard", "b": None}}}
    given["exclude"] = [f"load.thickness_mm > 45 and load.paddle == {MARKED!r}"]
    campaign = Campaign.of("mine", given, file=FILE)
    table = pd.DataFrame({"outcome": ["converged"] * 3, "seconds": 1.0, "moduli_factor": 1.0})
    html = Markup("\n").join(paragraphs(quoted(opening(campaign, table), {})))
    assert f"<strong>{escape(MARKED)}</strong>" in html
    assert f"<code>load.paddle</code>: {escape(MARKED)}, b." in html
    assert escape(given["exclude"][0]) in html


def test_the_page_says_where_all_moduli_were_multiplied():
    campaign = read(f"vary: {{{GLAND}: [1, 2, 3]}}")
    table = frame(campaign, rows(campaign, lambda shown: 1.0))
    assert "moduli_factor" not in opening(campaign, table)
    assert "In 1 of 3 points all moduli were multiplied by 1.5" in opening(
        campaign, table.assign(moduli_factor=[1.5, 1.0, np.nan])
    )
    alike = opening(campaign, table.assign(moduli_factor=2.0))
    assert "In 3 of 3 points all moduli were multiplied by 2" in alike
    assert "jump" not in alike


RIGID, FLEXIBLE = (
    {"until": {"thickness_share": 1.0}},
    {"until": {"thickness_share": 1.0}, "paddle": {"flexible": {}}},
)


def test_the_time_of_a_campaign_counts_what_is_shared_once_and_what_is_finished_not(case, known):
    text = (
        f"vary: {{{GLAND}: [2, 3], load.thickness_mm: [41, 46], load.paddle: [standard, flexible, tilted]}}"
    )
    points = planned(text, case, known)
    made = prediction.counts(points, RIGID, done=())
    presses = {f"pressed:{kind}": 4 for kind in ("standard", "flexible", "tilting")}
    # A path of the standard for each modulus and thickness, whatever paddle goes on from it.
    assert {name: made[name] for name in ("stress_free", "standard_path", *presses)} == {
        "stress_free": 2, "standard_path": 4, **presses,
    }  # fmt: skip
    done = {point.name for point in points if point.shown[GLAND] == 2}
    assert prediction.counts(points, RIGID, done)["stress_free"] == 1
    costs = {"point_stress_free": 5.0, "compress": 21.4, "point_pressed_flexible": 60.0}
    made = {"stress_free": 2, "pressed:flexible": 3, "pressed:tilting": 1, "body": 6}
    seconds = prediction.expected(made, costs, pace=0.5, points=4, batches=1)
    start = prediction.START_S + 4 * prediction.POINT_S
    assert seconds == pytest.approx(start + 0.5 * (2 * 5 + 3 * 60 + 20))
    # What the campaign itself took counts before any table.
    took = {"stress_free": 3.0, "pressed:flexible": 10.0, "pressed:tilting": 8.0}
    seconds = prediction.expected(made, costs, pace=0.5, points=4, batches=1, took=took)
    assert seconds == pytest.approx(start + 2 * 3 + 3 * 10 + 8)


def test_what_points_took_is_told_apart_by_their_paddles():
    rows = [{"point": "a", "took": {"pressed": 1.0, "body": 0.5}}, {"point": "b", "took": {"pressed": 9.0}}]
    rows.append({"point": "b", "took": {"pressed": 5.0}})
    kinds = {"a": prediction.paddle(RIGID), "b": prediction.paddle(FLEXIBLE)}
    found = prediction.measured(rows, kinds)
    assert found == {"pressed:standard": 1.0, "pressed:flexible": 7.0, "body": 0.5}


def test_each_product_costs_what_its_own_rule_takes_and_a_rule_counts_once(repository):
    """`pressed_body` is no breast that was pressed, and `depth` is made together with `slices`."""
    made, known = {}, set()
    for file in (repository / "workflow/rules").glob("*.smk"):
        for rule, text in re.findall(r"^rule (\w+):(.*?)(?=^\S|\Z)", file.read_text(), re.M | re.S):
            known.add(rule)
            if written := re.search(r"\*\*writes\((.*?)\)", text):
                made[rule] = re.findall(r"\w+", written[1])
    first = {products[0]: rule for rule, products in made.items() if rule != "take_labels"}
    assert len(first) > 15
    for name in STAGES:
        rule = prediction.RULES.get(name, name)
        assert (rule if rule in known else None) == first.get(name), name
    costs = dict.fromkeys(known, 10.0)
    alone = prediction.expected({}, costs, pace=1.0, points=1, batches=1)
    each = 10.0 - prediction.RULE_START_S
    for made, rules in (({"pressed_body": 5, "slices": 1, "depth": 1}, 1), ({"pressed:rigid": 2}, 2)):
        seconds = prediction.expected(made, costs, pace=1.0, points=1, batches=1)
        assert seconds == pytest.approx(alone + rules * each)
