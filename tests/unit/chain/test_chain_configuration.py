"""A configuration that cannot be meant is rejected, naming file, key, value, limit and next step."""

import copy
import re
from collections.abc import Iterator
from functools import reduce
from math import pi
from operator import getitem
from typing import Any

import pytest
import yaml

from mammosim.chain.advice import UNITS
from mammosim.chain.configuration import (
    absent,
    check_columns,
    check_listed,
    check_settings,
    check_tissues,
    check_volunteers,
)
from mammosim.chain.relations import RELATIONS, STRATEGIES
from mammosim.core.errors import ConfigurationError
from mammosim.core.positions import gravity_vector

NAN, INFINITY = float("nan"), float("inf")
# Schema -> files that it describes.
FILES = {
    "config": ["default.yaml"],
    "scene": ["scenes/*.yaml"],
    "compression": ["strategies*.yaml"],
    "tissues": ["tissues/*.yaml"],
    "accuracy": ["accuracy/parameters*.yaml"],
    "recovery": ["recovery*.yaml"],
    "peers": ["peers*.yaml"],
}


@pytest.fixture(scope="module")
def schemas(repository):
    folder = repository / "workflow/schemas"
    return {kind: yaml.safe_load((folder / f"{kind}.schema.yaml").read_text()) for kind in FILES}


@pytest.fixture
def schema(schemas):
    return schemas["config"]


@pytest.fixture(scope="module")
def default(repository):
    return yaml.safe_load((repository / "config/default.yaml").read_text())


@pytest.fixture
def settings(default):
    return copy.deepcopy(default)


def rejection(settings, schema, files=("mine.yaml",), **given) -> str:
    with pytest.raises(ConfigurationError) as error:
        check_settings(settings, schema, files=files, **given)
    return str(error.value)


def put(values: Any, name: str, value: Any) -> Any:
    """The values with another one at a dotted name."""
    *group, key = name.split(".")
    reduce(getitem, group, values)[key] = value
    return values


def numbers_in(values: Any) -> Iterator[tuple[Any, Any, str]]:
    """The holder, key and dotted name of every number in nested values."""
    pairs = values.items() if isinstance(values, dict) else enumerate(values)
    for key, value in pairs:
        if isinstance(value, (dict, list)):
            yield from ((holder, each, f"{key}.{name}") for holder, each, name in numbers_in(value))
        elif isinstance(value, (int, float)) and not isinstance(value, bool):
            yield values, key, str(key)


@pytest.mark.parametrize("wrong", [NAN, INFINITY, -INFINITY, None, True, "ten", "0,5", [1.0], {}], ids=str)
@pytest.mark.parametrize("kind", FILES)
def test_what_is_no_number_is_rejected_at_every_number_of_every_file(repository, schemas, kind, wrong):
    """The values of a numerical parameter may be text or groups; every other number may not."""
    count = 0
    for pattern in FILES[kind]:
        for file in sorted((repository / "config").glob(pattern)):
            values = yaml.safe_load(file.read_text())
            check_settings(values, schemas[kind], files=[file.name])
            found = list(numbers_in(values))
            if kind == "accuracy" and wrong not in (NAN, INFINITY, -INFINITY, None):
                found = [each for each in found if ".values." not in each[2]]
            for holder, key, _ in found:
                holder[key] = copy.copy(wrong)
            lines = rejection(values, schemas[kind], [file.name]).splitlines()
            named = {
                line.split()[1] for line in lines if line.startswith(f"{file.name}: ") and "must be" in line
            }
            assert named >= {name for _, _, name in found}
            count += len(found)
    assert count > {"config": 220, "scene": 10}.get(kind, 5)


def test_the_published_study_is_accepted(default, schema):
    check_settings(default, schema, files=["config/default.yaml"], relations=RELATIONS["config"])


@pytest.mark.parametrize(
    ("name", "text", "number"),
    [
        ("mechanics.newton_tolerance", "1e-6", 1e-6),
        ("xray.peak_kv", "3e1", 30.0),
        ("xray.peak_kv", "28.5", 28.5),
        ("digital.scan.marker_mm", "7", 7),
        ("xray.pixel_mm", ".5", 0.5),
        ("seed", "2e3", 2000),
        ("seed", 2000.0, 2000),
        ("registration.samples", 1.0e5, 100000),
    ],
)
def test_text_that_is_a_number_is_read_as_one_and_a_whole_number_stays_whole(
    settings, schema, name, text, number
):
    """YAML 1.1 has no number without a point before an exponent; a count of 1.0e5 is no count for `range`."""
    check_settings(put(settings, name, text), schema, files=["-"])
    found = reduce(getitem, name.split("."), settings)
    assert found == number
    assert type(found) is type(number)


def test_numbers_in_lists_are_read_too_and_text_stays_text(settings, schema):
    put(settings, "mechanics.sweep.youngs_modulus_kpa", ["2e-1", "1e1"])
    put(settings, "volunteers", ["1e1", "small"])
    check_settings(settings, schema, files=["-"])
    assert settings["mechanics"]["sweep"]["youngs_modulus_kpa"] == [0.2, 10.0]
    assert settings["volunteers"] == ["1e1", "small"]


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        # Limits, in the unit of the key; what the value would be in another unit is asked only where it fits.
        ("xray.peak_kv", NAN, "xray.peak_kv = nan: must be a number from 20 to 40"),
        (
            "mechanics.sweep.youngs_modulus_kpa",
            [500.0],
            "youngs_modulus_kpa.0 = 500.0: must be a number more than 0 and at most 90; was it given "
            "in Pa? Write 0.5",
        ),
        (
            "compression.thickness_mm",
            {"small": 4.5},
            "thickness_mm.small = 4.5: must be a number from 15 to 120; was it given in cm? Write 45",
        ),
        ("compression.thickness_mm", {"small": 0.045}, "was it given in m? Write 45"),
        ("xray.filter_um", 0.05, "was it given in mm? Write 50"),
        ("xray.peak_kv", 28000, "was it given in V? Write 28"),
        ("xray.calcifications.diameter_mm", 130, "was it given in um? Write 0.13"),
        ("digital.women.large.gland.fraction", 22, "was it given in percent? Write 0.22"),
        (
            "digital.women.large.breast.inferior_deg",
            80,
            "inferior_deg = 80: must be a number from -45 to 45 (",
        ),
        ("mechanics.sweep.density_g_cm3", 1000, "was it given in kg/m3? Write 1"),
        (
            "mechanics.sweep.poisson_ratio",
            0.5,
            "poisson_ratio = 0.5: must be a number at least 0 and less than 0.5 (",
        ),
        ("digital.scan.echo_time_ms", 0.07, "was it given in s? Write 70"),
        ("seed", -1, "seed = -1: must be a whole number at least 0"),
        ("seed", 1.5, "seed = 1.5: must be a whole number at least 0"),
        # Of another kind.
        (
            "xray.peak_kv",
            True,
            "xray.peak_kv = True: must be a number from 20 to 40; YAML reads yes, no, on and off as",
        ),
        ("xray.detector", False, "one of: selenium, caesium_iodide; YAML reads yes, no"),
        (
            "volunteers",
            ["small", False],
            "volunteers.1 = False: must be text of lower case letters, digits and _ (60 at most); YAML reads",
        ),
        (
            "volunteers",
            ["small", 7],
            "volunteers.1 = 7: must be text of lower case letters, digits and _ (60 at most); put it in",
        ),
        ("volunteers", "small", "volunteers = 'small': must be a list"),
        (
            "xray.peak_kv",
            None,
            "xray.peak_kv is empty: must be a number from 20 to 40; give it, or leave the key out",
        ),
        ("xray", None, "xray is empty: must be a group of keys"),
        ("xray", [{"peak_kv": 28}], "must be a group of keys"),
        # Text that was meant as a number.
        ("xray.pixel_mm", "0,5", "write a decimal point, not a comma"),
        ("registration.samples", "100,000", "write no comma, blank or ' between thousands"),
        ("registration.samples", "100 000", "write no comma, blank or ' between thousands"),
        ("mesh.beyond_markers_mm", "\u22124.0", "its minus is a typographic one"),
        ("xray.peak_kv", "28 kV", "write the number alone; the key names its unit"),
        ("xray.peak_kv", "28kV", "write the number alone; the key names its unit"),
        # Names and lists.
        (
            "volunteers",
            ["small "],
            "volunteers.0 = 'small ': must be text of lower case letters, digits and _ (60 at most); write",
        ),
        ("volunteers", ["Small"], "write small"),
        ("volunteers", ["ada_" * 16], "must be text of lower case letters, digits and _ (60 at most) (a"),
        ("volunteers", ["small", "small"], "volunteers = ['small', 'small']: 'small' stands twice; keep one"),
        (
            "digital.scan.spacing_mm",
            [2.0, 2.0],
            "digital.scan.spacing_mm = [2.0, 2.0]: has 2 entries and must have 3",
        ),
        ("volunteers", [], "volunteers = []: has 0 entries and must have at least 1"),
        ("xray.detector", "selenum", "must be one of: selenium, caesium_iodide; did you mean 'selenium'?"),
        ("softening.factors", [1], "softening.factors.0 = 1: must not be 1"),
        ("xray.effects", ["scatter", "blur"], "xray.effects lacks 'quantum_noise', which is needed; add it"),
        # Keys.
        (
            "compression.thickness_mm",
            {"Small": 45.0},
            "thickness_mm has no key 'Small': must be text of lower case letters, digits and _; write small",
        ),
        ("xray.peak_kv ", 28, "xray has no key 'peak_kv '; did you mean 'peak_kv'?"),
        ("xray.Peak_kV", 28, "xray has no key 'Peak_kV'; did you mean 'peak_kv'?"),
        ("mechanics.swep", {}, "mechanics has no key 'swep'; did you mean 'sweep'?"),
        ("sede", 1, "there is no key 'sede'; did you mean 'seed'?"),
    ],
)
def test_a_value_that_cannot_be_meant_is_told_in_one_line(settings, schema, name, value, words):
    message = rejection(put(settings, name, value), schema)
    assert message.startswith("mine.yaml: ")
    assert words in message
    assert "\n" not in message


def test_no_unit_is_guessed_that_would_not_make_the_value_right(settings, schema):
    assert "was it given" not in rejection(put(settings, "xray.peak_kv", 120), schema)
    put(settings, "xray.peak_kv", 28.0)
    assert "was it given" not in rejection(put(settings, "digital.women.small.skin.mean_mm", 6), schema)


# A unit, in that of SI.
SIZES = {
    **{"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9},
    **{"kPa/mm": 1e6, "MPa/mm": 1e9, "Pa/mm": 1e3, "mN": 1e-3, "N": 1.0, "kN": 1e3, "kg/m3": 1.0},
    **{"N m per rad": 1.0, "N mm per rad": 1e-3, "mN mm per rad": 1e-6, "g/cm3": 1e3, "V": 1.0, "kV": 1e3},
    **{
        "eV": 1.0,
        "keV": 1e3,
        "MeV": 1e6,
        "s": 1.0,
        "ms": 1e-3,
        "us": 1e-6,
        "uGy": 1e-6,
        "mGy": 1e-3,
        "Gy": 1.0,
    },
    **{"rad": 1.0, "deg": pi / 180, "percent": 1e-2, "parts of one": 1.0, "share": 1.0},
}
SPELLED = {"kpa": "kPa", "mpa": "MPa", "kpa_per_mm": "kPa/mm", "n": "N", "n_mm_per_rad": "N mm per rad",
           "g_cm3": "g/cm3", "kv": "kV", "kev": "keV", "ugy": "uGy"}  # fmt: skip


@pytest.mark.parametrize("key", UNITS)
def test_what_one_unit_is_in_another_follows_from_their_sizes(key):
    for other, factor in UNITS[key]:
        assert factor == pytest.approx(SIZES[other] / SIZES[SPELLED.get(key, key)]), other


def test_no_unit_is_guessed_that_would_put_the_value_just_out_of_its_limits():
    schema = {"properties": {"gland_share": {"type": "number", "exclusiveMaximum": 0.5}}}
    assert rejection({"gland_share": 40}, schema).endswith("was it given in percent? Write 0.4")
    assert rejection({"gland_share": 50}, schema).endswith("must be a number less than 0.5")


def test_only_the_bad_name_is_blamed(settings, schema):
    message = rejection(put(settings, "digital.women.Ada", {"seed": 3}), schema)
    words = "a name has lower case letters, digits and _ (60 at most) only; write ada"
    assert message == f"mine.yaml: digital.women has no key 'Ada': {words}"


def test_a_missing_key_is_named_with_what_it_means(settings, schema):
    del settings["xray"]["peak_kv"]
    meant = schema["properties"]["xray"]["properties"]["peak_kv"]["description"]
    assert f"xray lacks peak_kv ({meant}); add it" in rejection(settings, schema)


def test_every_problem_is_reported_at_once_and_each_once(settings, schema):
    settings["sede"] = 1
    settings["xray"]["peak_kv"] = INFINITY
    settings["propagation"] |= {"draws": 3, "pressed": 6}
    lines = rejection(settings, schema, relations=RELATIONS["config"]).splitlines()
    assert len(lines) == 3
    assert all(line.startswith("mine.yaml: ") for line in lines)
    for words in ("'seed'", "xray.peak_kv = inf", "propagation.pressed = 6"):
        assert len([line for line in lines if words in line]) == 1


def test_a_relation_of_a_value_that_is_wrong_by_itself_is_not_told_beside_it(settings, schema):
    settings["compression"]["strategies"] = ["standard", 7]
    message = rejection(settings, schema, relations=RELATIONS["config"], known={STRATEGIES: ["standard"]})
    assert message.startswith("mine.yaml: compression.strategies.1 = 7: must be text")
    assert "\n" not in message


def test_the_file_that_gave_a_value_is_named(settings, schema):
    """Settings are laid over each other; the one that was given last is at fault, of two keys the later."""
    mine = {"xray": {"peak_kv": 120}, "mechanics": {"stress_free": {"methods": ["fixed_point"]}}}
    settings["xray"]["peak_kv"] = 120
    settings["mechanics"]["stress_free"]["methods"] = ["fixed_point"]
    settings["seed"] = -1
    files = {"default.yaml": copy.deepcopy(settings), "mine.yaml": mine, "--config": {"seed": -1}}
    lines = rejection(settings, schema, files, relations=RELATIONS["config"]).splitlines()
    assert sorted(line.split(": ")[0] for line in lines) == ["--config", "mine.yaml", "mine.yaml"]


def test_of_a_value_of_several_kinds_the_one_that_is_meant_is_judged(repository, schemas):
    scene = yaml.safe_load((repository / "config/scenes/dose.yaml").read_text())
    check_settings(scene | {"accuracy": {"agd_percent": "1e0"}}, schemas["scene"], files=["-"])
    wrong = scene | {"accuracy": {"agd_percent": -1}}
    assert "accuracy.agd_percent = -1: must be a number more than 0" in rejection(wrong, schemas["scene"])
    assert "accuracy = 3: must be" in rejection(scene | {"accuracy": 3}, schemas["scene"])


@pytest.mark.parametrize("nothing", [None, [], "seed:1", 3])
def test_a_file_without_keys_is_rejected(schemas, nothing):
    message = rejection(nothing, schemas["compression"])
    assert message.startswith("mine.yaml: the file ")
    assert "must be a group of keys" in message


def test_what_hard_cases_try_may_be_no_number(repository):
    """The mechanics has to reject it, which is what they are about."""
    schema = yaml.safe_load((repository / "workflow/schemas/hard_cases.schema.yaml").read_text())
    cases = yaml.safe_load((repository / "config/hard_cases.yaml").read_text())
    check_settings(cases, schema, files=["-"], finite=False)
    assert "= nan" in rejection(cases, schema)


def table(**change) -> list[dict[str, str]]:
    rows = [
        {"volunteer": "a", "position": "prone", "gravity": "0 -1 0"},
        {"volunteer": "a", "position": "supine", "gravity": "0 1 0"},
    ]
    rows = [
        row | {"images": f"series_{row['position']}", "strokes": "strokes.csv", "labels": ""} for row in rows
    ]
    return [rows[0] | change, rows[1]]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"gravity": "0 1 0"}, "contradicts 'prone'"),
        ({"gravity": "down"}, "write three numbers"),
        ({"position": "supine_tilted", "gravity": "0 1 0"}, "contradicts 'supine_tilted'"),
        ({"position": "sitting"}, "choose one of: prone, supine"),
        ({"position": "supine", "gravity": "0 1 0"}, "stand twice"),
        ({"images": ""}, "'a', prone, lacks images; give images, or labels"),
        (
            {"codes": "victre"},
            "'a', prone: codes 'victre': codes explain labels; give labels, or leave codes out",
        ),
        ({"labels": "l.nii.gz", "images": ""}, "labels of prone and none of supine; give labels of each"),
        ({"gaps": "yes"}, "'a', prone: gaps 'yes' is not known; write 'resample'"),
        ({"labels": "l.nii.gz", "images": "", "series": "5"}, "'a', prone, has series without images"),
        ({"images": "series_supine"}, "images 'series_supine' are given for a prone and a supine"),
    ],
)
def test_a_volunteer_table_that_contradicts_itself_is_rejected(change, words):
    with pytest.raises(ConfigurationError, match=words):
        check_volunteers(table(**change), file="volunteers.tsv")


def test_one_position_alone_and_labels_alone_can_be_meant():
    check_volunteers(table()[:1], file="volunteers.tsv")
    check_volunteers(table(strokes=""), file="volunteers.tsv")  # segmented without strokes
    rows = [row | {"labels": f"{row['position']}.nii.gz", "images": "", "strokes": ""} for row in table()]
    check_volunteers(rows, file="volunteers.tsv")


def test_codes_are_a_preset_or_a_file_that_is_there():
    row = {"volunteer": "a", "position": "prone", "gravity": "0 -1 0", "labels": "l.mha"}
    for codes in ("pelicano_simple", "mine.tsv"):
        check_volunteers(
            [row | {"codes": codes}], file="t.tsv", there=lambda path: path in ("l.mha", "mine.tsv")
        )
    with pytest.raises(
        ConfigurationError, match=r"codes 'pelicano': is no file and no preset; presets are: mammosim"
    ):
        check_volunteers([row | {"codes": "pelicano"}], file="t.tsv", there=lambda path: path == "l.mha")


PATHS = {
    "~/scan": "images '~/scan': ~ is not expanded here; write the whole path",
    "scans/{visit}": "braces are wildcards of the workflow; rename it",
    "results/images/a/prone.nii.gz": "the study makes it of this row",
    "scans/none": "volunteer 'a', prone: images 'scans/none': is not there; correct the path",
}


@pytest.mark.parametrize(("path", "words"), PATHS.items())
def test_a_path_that_cannot_be_used_is_named_by_its_row(path, words):
    with pytest.raises(ConfigurationError, match=re.escape(words)):
        check_volunteers(table(images=path), file="volunteers.tsv", there=lambda path: "none" not in path)


def test_each_row_has_images_of_its_own():
    rows = [row | {"images": "scan"} for row in table()]
    with pytest.raises(ConfigurationError, match="images 'scan' are given for a prone and a supine"):
        check_volunteers(rows, file="volunteers.tsv")


@pytest.mark.parametrize("given", [("folder", "folder/"), ("folder/", "folder")])
def test_a_folder_is_the_same_with_a_stroke_behind_it(given):
    rows = [row | {"images": path} for row, path in zip(table(), given)]
    with pytest.raises(ConfigurationError, match="images 'folder' are given for a prone and a supine"):
        check_volunteers(rows, file="volunteers.tsv")


def test_each_row_has_labels_of_its_own():
    rows = [row | {"images": "", "labels": "map.nii.gz"} for row in table()]
    with pytest.raises(ConfigurationError, match=r"labels 'map\.nii\.gz' are given for a prone and a supine"):
        check_volunteers(rows, file="volunteers.tsv")


@pytest.mark.parametrize("kind", ["images", "labels", "strokes", "fiducials"])
def test_every_path_of_a_row_must_be_there(kind):
    rows = [row | {"labels": f"map_{row['position']}"} for row in table()]
    with pytest.raises(ConfigurationError, match=f"a', prone: {kind} 'none': is not there; correct the path"):
        check_volunteers([rows[0] | {kind: "none"}, rows[1]], file="t.tsv", there=lambda path: path != "none")


@pytest.mark.parametrize("kind", ["images", "labels", "strokes", "fiducials"])
def test_whose_files_are_not_there_is_told_with_the_first_of_them(kind):
    rows = [
        *({"volunteer": v, "position": "prone", "images": f"{v}/scan"} for v in ("ada", "bea")),
        {"volunteer": "bea", "position": "supine", "images": "bea/supine", kind: "none"},
        {"volunteer": "bea", "position": "supine_tilted", "images": "none either"},
    ]
    assert absent(rows, there=lambda path: "none" not in path) == {"bea": f"{kind} none"}
    assert absent(rows, there=lambda path: True) == {}


def test_a_volunteer_of_ones_own_has_no_name_of_a_digital_one():
    with pytest.raises(ConfigurationError, match=r"'a' is the name of a digital volunteer, .* another name"):
        check_volunteers(table(), file="volunteers.tsv", digital=["a"])
    rows = [row | {"images": f"results/raw/a/{row['position']}"} for row in table()]
    check_volunteers(rows, file="volunteers.tsv", digital=["a"])
    for own in ({"images": "mine"}, {"images": "", "labels": "mine.nii.gz"}):
        with pytest.raises(ConfigurationError, match="name of a digital volunteer"):
            check_volunteers([rows[0], rows[1] | own], file="volunteers.tsv", digital=["a"])


def test_what_is_wrong_with_one_row_hides_nothing_of_another():
    rows = [
        row | {"gravity": "down"} if row["position"] == "prone" else row | {"images": ""} for row in table()
    ]
    with pytest.raises(ConfigurationError) as error:
        check_volunteers(rows, file="volunteers.tsv")
    first, second = str(error.value).splitlines()
    assert "prone: gravity 'down' is no direction; write three numbers with decimal points" in first
    assert "supine, lacks images" in second


def test_columns_that_lack_or_are_named_almost_rightly_are_named():
    with pytest.raises(ConfigurationError, match=r"my\.tsv has a column 'Gravity'; did you mean 'gravity'"):
        check_columns([{"volunteer": "", "position": "", "Gravity": ""}], file="my.tsv")
    with pytest.raises(
        ConfigurationError, match=r"no column position, gravity; .* tabs .* reads 'volunteer'"
    ):
        check_columns([{"volunteer": ""}], file="my.tsv")
    check_columns([row | {"remark": ""} for row in table()], file="my.tsv")
    check_columns([], file="my.tsv")


def test_gravity_is_normalised():
    assert gravity_vector("0 -2 0").tolist() == [0.0, -1.0, 0.0]


def test_a_tissue_without_parameters_is_named():
    with pytest.raises(
        ConfigurationError, match="no parameters for tissue 'glandular'; add youngs_modulus_kpa"
    ):
        check_tissues(["adipose", "muscle"], ["adipose", "glandular", "muscle"], file="standard.yaml")


def test_one_folder_may_hold_the_series_of_two_positions():
    check_volunteers(table(images="series_supine", series="3", gaps="resample"), file="volunteers.tsv")


def test_a_volunteer_without_rows_is_named():
    table = [{"volunteer": "small"}, {"volunteer": "large"}]
    with pytest.raises(ConfigurationError, match=r"my\.tsv has no row of 'ada', .* rows of: small, large"):
        check_listed(table, ["small", "ada"], file="my.tsv")


def test_a_table_of_labels_needs_no_column_of_images():
    row = {"volunteer": "a", "position": "supine", "gravity": "0 1 0", "labels": "labels.nii.gz"}
    check_volunteers([row], file="volunteers.tsv", digital=["small"])
