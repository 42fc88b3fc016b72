"""Keys that contradict each other are rejected, all of them at once, with both their values."""

import pytest

from mammosim.chain import relations
from mammosim.chain.relations import RELATIONS, entries, unmet

CONFIG = {
    "volunteers": ["small", "ada"],
    "peers": "peers.yaml",
    "reference_position": "supine",
    "tissues": "standard",
    "segmentation": {"positions": ["prone", "supine"]},
    "mechanics": {
        "stress_free": {"position": "prone", "methods": ["fixed_point", "anderson"], "default": "anderson"}
    },
    "compression": {
        "strategies": ["standard", "tilted"],
        "moduli": ["gravity"],
        "thickness_mm": {"small": 45.0, "ada": 50.0},
        "thresholds": {"energy_kpa": [0.1, 1.0]},
    },
    "xray": {"strategies": ["standard"]},
    "validation": {"wrong_model": {"fibrous": "small"}},
    "propagation": {"draws": 8, "pressed": 3},
    "scenes": {"names": ["dose"], "accuracy": "study", "coarse": "screening"},
    "digital": {
        "tissues": "standard",
        "scan": {"field_of_view_mm": {"x": [-150, 150], "y": [-10, 20]}},
        "women": {
            "small": {"skin": {"mean_mm": 1.4, "variation_mm": 0.4}},
            "fibrous": {"skin": {"mean_mm": 2.5, "variation_mm": 2.0}},
        },
    },
    "morph": {"stiffness_kpa_per_mm": [0.1, 0.3]},
    "registration": {"smoothing_mm": [4.0, 0.0]},
}
KNOWN = {
    relations.FILES: ["peers.yaml"],
    relations.TISSUES: ["standard", "soft"],
    relations.MODULI: ["gravity", "standard", "soft"],
    relations.STRATEGIES: ["standard", "tilted", "reduced"],
    relations.SCENES: ["dose", "force"],
    relations.ACCURACIES: ["study", "screening"],
    relations.VOLUNTEERS: ["small", "fibrous", "ada"],
}


def changed(values, name, value):
    """Nested values with another one at a dotted name."""
    first, _, rest = name.partition(".")
    return {**values, first: changed(values[first], rest, value) if rest else value}


def words_of(values, kind="config", known=KNOWN):
    return [words for _, words in unmet(values, RELATIONS[kind], known)]


def test_what_agrees_is_accepted():
    assert words_of(CONFIG) == []


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        (
            "xray.strategies",
            ["standard", "reduced"],
            "xray.strategies = ['standard', 'reduced']: 'reduced' is not in compression.strategies "
            "(standard, tilted); press by it, too",
        ),
        (
            "compression.strategies",
            ["standard", "squash", "hug"],
            "'squash', 'hug' are not in the file of compression.strategies_file (standard, tilted, reduced)",
        ),
        (
            "compression.moduli",
            ["gravity", "hard"],
            "'hard' is not in gravity and config/tissues (gravity, standard, soft)",
        ),
        ("tissues", "hard", "tissues = 'hard': 'hard' is not in config/tissues (standard, soft)"),
        ("digital.tissues", "hard", "digital.tissues = 'hard'"),
        ("scenes.names", ["dose", "pain"], "'pain' is not in config/scenes"),
        ("scenes.accuracy", "exact", "'exact' is not in study and config/accuracy"),
        ("scenes.coarse", "exact", "scenes.coarse = 'exact'"),
        (
            "mechanics.stress_free.methods",
            ["fixed_point"],
            "stress_free.default = 'anderson': 'anderson' is not in mechanics.stress_free.methods "
            "(fixed_point); add it",
        ),
        ("mechanics.stress_free.position", "upright", "'upright' is not in segmentation.positions"),
        ("reference_position", "upright", "reference_position = 'upright'"),
        (
            "validation.wrong_model",
            {"ada": "small"},
            "validation.wrong_model = {'ada': 'small'}: 'ada' is not in digital.women",
        ),
        (
            "validation.wrong_model",
            {"small": "ada"},
            "validation.wrong_model.small = 'ada': 'ada' is not in digital.women",
        ),
        (
            "propagation.pressed",
            8,
            "propagation.pressed = 8: must be less than propagation.draws = 8; draw more",
        ),
        (
            "digital.scan.field_of_view_mm.x",
            [150, -150],
            "field_of_view_mm.x = [150, -150]: each number must be more than the one before; put the "
            "lowest first",
        ),
        ("compression.thresholds", {"energy_kpa": [1.0, 0.1]}, "thresholds.energy_kpa = [1.0, 0.1]"),
        ("morph.stiffness_kpa_per_mm", [0.3, 0.1], "put the weakest first"),
        (
            "registration.smoothing_mm",
            [0.0, 4.0],
            "each number must be less than the one before; put the coarsest",
        ),
        (
            "digital.women.fibrous.skin.variation_mm",
            2.5,
            "women.fibrous.skin.variation_mm = 2.5: must be less than "
            "digital.women.fibrous.skin.mean_mm = 2.5",
        ),
        ("peers", "none.yaml", "peers = 'none.yaml': there is no such file; correct the path"),
        ("peers", "", "peers = '': there is no such file"),
        (
            "compression.thickness_mm",
            {"small": 45.0, "ada": 50.0, "samll": 50.0},
            "'samll' is not in volunteer_table and the digital volunteers (small, fibrous, ada)",
        ),
    ],
)
def test_a_contradiction_is_told_with_both_keys(name, value, words):
    (told,) = words_of(changed(CONFIG, name, value))
    assert words in told


def test_all_contradictions_are_told_and_both_places_of_each():
    wrong = changed(changed(CONFIG, "propagation.pressed", 9), "tissues", "hard")
    found = list(unmet(wrong, RELATIONS["config"], KNOWN))
    assert [places for places, _ in found] == [
        (("tissues",),),
        (("propagation", "pressed"), ("propagation", "draws")),
    ]


def test_keys_that_are_missing_or_of_another_kind_are_left_to_the_schema():
    assert words_of({}) == []
    assert words_of(changed(CONFIG, "propagation.pressed", "three")) == []
    assert words_of(changed(CONFIG, "xray", None)) == []
    assert words_of(changed(CONFIG, "compression.strategies", ["standard", "squash"]), known={}) == []


def test_files_beside_the_configuration_have_relations_of_their_own():
    (told,) = words_of({"ranges": {"adipose_kpa": [2.0, 0.5], "skin_kpa": [1.0, 2.0]}}, "recovery")
    assert told.startswith("ranges.adipose_kpa = [2.0, 0.5]")
    (told,) = words_of({"between": ["small", "small"]}, "recovery")
    assert told == "between = ['small', 'small']: its entries must differ; name two women"
    assert (
        "'eva' is not in digital.women"
        in words_of({"between": ["small", "eva"]}, "recovery", {relations.WOMEN: ["small"]})[0]
    )
    (told,) = words_of({"volunteer": "eva"}, "accuracy")
    assert told.startswith("volunteer = 'eva': 'eva' is not in volunteer_table")
    peers = {
        "cases": {"soft": {}},
        "runs": [{"case": "soft"}, {"case": "sfot"}],
        "xray": {"runs": {"least": 5, "most": 3}},
    }
    case, runs = words_of(peers, "peers")
    assert case.startswith("runs.1.case = 'sfot': 'sfot' is not in cases (soft)")
    assert runs.startswith("xray.runs.least = 5: must be at most xray.runs.most = 3")


def test_entries_of_groups_and_lists_are_found_by_a_star():
    values = {"a": {"x": [1, 2], "y": [3]}}
    assert entries(values, "a.*") == [(("a", "x"), [1, 2]), (("a", "y"), [3])]
    assert entries(values, "a.x.*") == [(("a", "x", 0), 1), (("a", "x", 1), 2)]
    assert entries(values, "a.z") == []


def test_limits_of_other_keys_belong_to_them_and_equal_neighbours_neither_rise_nor_fall():
    assert words_of({"xray": {"runs": {"least": 3, "most": 3}}}, "peers") == []
    for name, values in {
        "morph.stiffness_kpa_per_mm": [0.1, 0.1],
        "registration.smoothing_mm": [4.0, 4.0],
    }.items():
        (told,) = words_of(changed(CONFIG, name, values))
        assert "than the one before" in told


def test_numbers_that_no_float_holds_are_left_to_their_limits():
    values = changed(CONFIG, "propagation", {"draws": 10**400, "pressed": 10**401})
    assert words_of(values) == []


def test_a_scene_names_what_files_describe_or_states_errors():
    scene = {"tissues": "soft", "load": {"strategy": "tilted"}, "accuracy": {"force_n": 0.1}}
    assert words_of(scene, "scene") == []
    found = "\n".join(words_of({"tissues": "hard", "load": {"strategy": "hug"}, "accuracy": "fast"}, "scene"))
    for words in (
        "tissues = 'hard'",
        "load.strategy = 'hug': 'hug' is not in",
        "accuracy = 'fast': 'fast' is not in",
    ):
        assert words in found
