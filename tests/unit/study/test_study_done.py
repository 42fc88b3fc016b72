"""The page of one woman after a run: what was done, what could not be and why, and what more would add."""

import pandas as pd
import pytest
import yaml

from mammosim.chain.allowed import TOLD
from mammosim.io.tabulated import tabulated
from mammosim.study.report.answers import answers_in_words, carried_words, telling
from mammosim.study.report.done import Done, done_sections
from mammosim.study.report.pages import Listing, Picture, report

ALONE = "ada was scanned in one position, two are needed"
PLAN = [(TOLD["mesh"], ""), (TOLD["fit"], ALONE)]
GAINS = [
    (("a supine series",), ["registration", "fit of moduli"]),
    (("a supine series", "a list of markers and nipples"), ["sweep of moduli"]),
]
NOTHING = pd.DataFrame(columns=["reason", "tables", "figures"])
PRESSED = pd.DataFrame(
    {"side": ["left", "left"], "strategy": "standard", "moduli": ["gravity", "compression"]}
    | {"plates_mm": 45.2, "thickness_from": "chosen: half", "force_n": [3.2, 17.1]}
    | {"chest_gap_mm": 23.4, "chest_gap_from": "clear of held skin", "outcome": "converged"}
    | {"mean_pressure_kpa": float("nan")}
)
IMAGE = pd.DataFrame(
    {"side": ["left"], "strategy": "standard", "moduli": "gravity", "mas": 99.6}
    | {"dose_mgy": 1.857, "dose_se_mgy": 0.026, "cnr": 0.35, "calcification_d": 4.1}
)
MISSING_IMAGE = pd.DataFrame(
    {"side": ["left"], "strategy": "standard", "moduli": "gravity", "outcome": "missing: the field is narrow"}
)


def sections(plan=PLAN, gains=GAINS, missing=NOTHING, **there):
    """The sections of ada's page, prone, of whom there is nothing but what is named."""
    given = pd.DataFrame({"position": ["prone"], "images": "a.nii.gz", "listed": "", "gaps": "resample"})
    done = Done("ada", **{"tables": {}, "pictures": {}, "files": {}} | there, missing=missing, given=given,
                modelled="prone", home="results/women/ada")  # fmt: skip
    return done_sections(done, plan, gains, thickness="Half of her depth.")


def page(*args, **named) -> str:
    return report("ada", sections(*args, **named), numbers={})


def statuses(*parts: str, **there) -> dict[str, tuple[str, str]]:
    """Of parts of TOLD that her data allow: whether each is done, and why not."""
    (listing,) = sections(plan=[(TOLD[part], "") for part in parts], **there)[0].blocks
    return {what: (done, why) for done, whats, why in listing.rows for what in whats.split(", ")}


def test_the_answers_come_first_with_what_they_depend_on():
    (words,) = answers_in_words({"compression": PRESSED, "image": IMAGE})
    assert words.startswith(
        "**Left breast, standard compression: plates 45 mm apart** (thickness chosen: half)"
    )
    assert "3.2 to 17.1 N, by the moduli assumed" in words
    assert "**Mean glandular dose 1.86 mGy** (standard error 0.03) at 100 mAs" in words
    (one,) = answers_in_words({"compression": PRESSED[1:], "image": MISSING_IMAGE})
    assert "17.1 N with compression moduli" in one
    assert "dose" not in one, "which is missing"


def test_of_an_image_what_is_known_is_told():
    (words,) = answers_in_words(
        {"compression": PRESSED, "image": IMAGE.assign(calcification_d=float("nan"), dose_mgy=float("nan"))}
    )
    assert words.endswith(" by the moduli assumed. Contrast to noise of the lesion 0.35 in a pixel.")


def test_of_each_breast_its_own_first_strategy_is_told():
    other = PRESSED.assign(strategy="reduced", plates_mm=60.0)
    right = PRESSED.assign(side="right", plates_mm=50.0)
    both = pd.concat([PRESSED, other, right])
    images = pd.concat([IMAGE.assign(side="right", strategy="reduced", mas=7.0), IMAGE.assign(side="right")])
    words = answers_in_words({"compression": both, "image": images})
    assert [("plates 45" in each, "plates 50" in each) for each in words] == [(True, False), (False, True)]
    assert ["at 100 mAs" in each for each in words] == [False, True], "of the same strategy"
    assert answers_in_words({"compression": MISSING_IMAGE}) == answers_in_words({}) == []


def test_a_part_is_done_where_its_table_or_picture_is_there():
    found = statuses(
        *("mesh", "mammogram", "pressed", "exposed_dose", "scan", "upright", "softening", "listed", "slices"),
        tables={
            "mesh_quality": pd.DataFrame({"volume_mm3": [1.0]}),
            "image": MISSING_IMAGE,
            "compression": pd.concat([PRESSED, MISSING_IMAGE]),
            "dose": IMAGE,
        },
        pictures={"positions_ada": b"png"},
    )
    assert found[TOLD["mesh"]] == found[TOLD["scan"]] == found[TOLD["listed"]] == ("yes", "")
    assert found["mammogram"] == ("failed", "the field is narrow")
    assert found[TOLD["exposed_dose"]] == ("yes", "")
    assert found[TOLD["pressed"]] == ("in part", "the field is narrow")
    assert found[TOLD["slices"]] == ("not asked", "the settings do not ask for it")
    assert found[TOLD["upright"]] == ("not yet", "her data allow it: snakemake study makes it")
    assert found[TOLD["softening"]] == ("not yet", "her data allow it: snakemake softening makes it")


def test_what_her_data_do_not_allow_is_told_once_for_each_reason():
    plan = [(TOLD["mesh"], ""), (TOLD["fit"], ALONE), (TOLD["validation"], ALONE)]
    rows = sections(plan=plan, pictures={"mesh_ada_prone": b""})[0].blocks[0].rows
    assert ["no", f"{TOLD['fit']}, {TOLD['validation']}", ALONE] in rows


def test_pictures_stand_in_their_sections_under_what_they_show():
    names = ("positions_ada", "mesh_ada_prone", "mesh_adam_prone", "mammogram_ada_left", "other_ada")
    found = sections(pictures={name: name.encode() for name in names}, tables={"image": IMAGE})
    shown = {
        (section.title, block.data.decode(), block.caption)
        for section in found
        for block in section.blocks
        if isinstance(block, Picture)
    }
    assert {(title, name) for title, name, _ in shown} == {
        ("What was given", "positions_ada"),
        ("Tissues and mesh", "mesh_ada_prone"),
        ("Mammogram, dose, and what would show", "mammogram_ada_left"),
    }, "of nobody else, and of nothing that has no words"
    captions = {name: caption for _, name, caption in shown}
    assert captions["mesh_ada_prone"].startswith("The mesh of prone:")
    assert "Compression" not in [section.title for section in found], "of which there is nothing"


def test_the_page_has_what_was_given_what_was_found_and_links_from_her_folder():
    missing = pd.DataFrame({"reason": ["the breast slipped out"], "tables": ["image"], "figures": [""]})
    text = page(
        missing=missing,
        tables={"compression": PRESSED, "field": PRESSED},
        files={"dose": ["results/dose/ada.csv"], "field": []},
    )
    assert '<a href="../../../results/dose/ada.csv">dose/ada.csv</a>' in text
    for words in ("a.nii.gz", "resample", "the breast slipped out", ALONE, "Half of her depth.", "17.1"):
        assert words in text
    assert "left 23.4 mm (clear of held skin)" in text
    assert "Field" not in text, "a table without a file"
    assert "mean pressure" not in text, "a column without a value"
    assert "<strong>A supine series would add:</strong> registration, fit of moduli." in text
    assert "a supine series and a list of markers and nipples" in text
    assert "none is a finding about her" in text
    assert text.count("chosen: half") == 1, "only the tables that answer are shown"
    assert "points</th>" not in text, "a column that says nothing"


def test_every_breast_has_its_gap_between_ribs_and_plates():
    right = PRESSED.assign(side="right")
    words = telling("compression", pd.concat([PRESSED, right]), "prone")[1]
    assert words.count("mm (clear of held skin)") == 2, "told once for each"
    assert "right 23.4 mm" in words


def test_numbers_stand_under_their_own_headings():
    image = IMAGE.assign(calcification_d_low=3.4, calcification_d_high=4.8, moduli="gravity")
    tables = {"image": image, "validation": predicted("supine", nipple_left=1.5)}
    listings = [each for part in sections(tables=tables)[2:4] for each in part.blocks]
    moved, seen = (dict(zip(each.headings, each.rows[0])) for each in listings)
    assert (seen["dose (mGy)"], seen["± (mGy)"]) == ("1.857", "0.026")
    assert [seen[name] for name in ("d' from", "d'", "d' to")] == ["3.4", "4.1", "4.8"]
    assert (moved["predicted (mm)"], moved["before (mm)"]) == ("1.5", "9")


def predicted(position: str, **values: float) -> pd.DataFrame:
    rows = [{"position": position, "quantity": name, "value_mm": each} for name, each in values.items()]
    return pd.DataFrame(rows).assign(fitted=True, before_mm=9.0, outcome="converged")


def test_the_position_that_the_model_is_made_of_is_no_test_of_it():
    own = predicted("prone", breast_6=0.6, skin_mean=1e-9, skin_hausdorff=4e-7)
    other = predicted("supine", breast_1=1.3, nipple_left=1.5, skin_hausdorff=3.1)
    rows, words = telling("validation", pd.concat([own, other]), "prone")
    assert set(rows.position) == {"supine"}
    assert list(rows.quantity) == ["nipple_left", "skin_hausdorff"], "single markers stand in the file"
    assert "made of the prone series" in words
    assert "(less than 0.001 mm)" in words
    assert "(at most 0.12 mm)" in telling("validation", predicted("prone", skin_mean=0.123), "prone")[1]
    assert telling("validation", other, "prone")[1] == ""
    assert telling("validation", MISSING_IMAGE, "prone")[0].equals(MISSING_IMAGE)
    failed = own.assign(value_mm=float("nan"), outcome="missing: no shape")
    rows, words = telling("validation", failed, "prone")
    assert list(rows.outcome.unique()) == ["missing: no shape"], "a reason is not left out"
    assert words == ""
    only = sections(tables={"validation": own})
    (part,) = [each for each in only if each.title.startswith("Predicted")] or [None]
    assert part is None, "a table without rows, where there is no picture"


def test_a_modulus_that_her_positions_do_not_tell_is_a_dash_with_its_interval():
    fitted = pd.DataFrame(
        {"side": "left", "tissue": ["adipose", "fascia"], "fitted_kpa": [0.8, 0.0], "low_kpa": [0.7, 0.0]}
        | {"high_kpa": [1.0, 313.6], "identifiable": [True, False]}
    )
    (found,) = [each for each in sections(tables={"identification": fitted}) if "Stiffness" in each.title]
    (listing,) = found.blocks
    assert listing.headings == ["side", "tissue", "fitted (kPa)", "from (kPa)", "to (kPa)"]
    assert listing.rows == [["left", "adipose", "0.8", "0.7", "1"], ["left", "fascia", "–", "0", "313.6"]]


def test_distances_below_a_micrometre_and_outcomes_that_say_nothing_are_not_shown():
    tried = attempts(("inverse", 1.0, "converged")).assign(largest_mm=1.2e-9)
    tried = pd.concat([tried, tried.assign(largest_mm=0.0123)])
    (found,) = [
        each for each in sections(tables={"stress_free_attempts": tried}) if "without gravity" in each.title
    ]
    (listing,) = found.blocks
    assert isinstance(listing, Listing)
    assert dict(zip(listing.headings, listing.rows[0]))["largest error (mm)"] == "0"
    assert listing.rows[1][-1] == "0.012", "to a micrometre"
    assert "outcome" not in listing.headings
    failed = tried.assign(outcome="failed: no shape")
    (found,) = [
        each for each in sections(tables={"stress_free_attempts": failed}) if "without gravity" in each.title
    ]
    assert found.blocks[0].rows[0][-1] == "failed: no shape"


def attempts(*tried):
    rows = [
        {"method": method, "moduli_factor": factor, "adipose_kpa": factor, "glandular_kpa": factor}
        | {"skin_kpa": 10 * factor, "outcome": outcome}
        for method, factor, outcome in tried
    ]
    return pd.DataFrame(rows)


def test_other_moduli_than_those_given_are_told_with_what_they_are():
    failed = "failed: the fixed point diverges"
    words = carried_words(
        attempts(("anderson", 1.0, failed), ("inverse", 1.0, failed), ("inverse", 2.0, "converged"))
    )
    assert "**anderson found no shape" in words
    assert "inverse did, with all moduli times 2** (fat 2, gland 2, skin 20 kPa)" in words
    assert "0.2 to 5 kPa" in words
    other = carried_words(attempts(("anderson", 1.0, failed), ("inverse", 1.0, "converged")))
    assert "inverse did, with the moduli as given" in other
    assert carried_words(attempts(("anderson", 1.0, "converged"))) == ""
    assert carried_words(attempts(("anderson", 1.0, "missing: no shape"))) == ""
    assert carried_words(pd.DataFrame()) == ""


def test_the_interval_that_is_told_is_that_of_published_moduli(repository):
    published = tabulated("published_biomechanics")
    fat = published[published.tissue.isin(["adipose", "breast"])]
    assert (fat.low_kpa.min(), fat.high_kpa.max()) == (0.2, 5.0)
    config = yaml.safe_load((repository / "config/default.yaml").read_text())
    standard = yaml.safe_load((repository / f"config/tissues/{config['tissues']}.yaml").read_text())
    stiffest = max(config["mechanics"]["stress_free"]["moduli_factors"])
    assert stiffest * standard["tissues"]["adipose"]["youngs_modulus_kpa"] == fat.high_kpa.max()
    upper = yaml.safe_load((repository / "config/tissues/compression.yaml").read_text())
    assert upper["tissues"]["adipose"]["youngs_modulus_kpa"] == fat.high_kpa.max()


def test_where_nothing_is_missing_or_to_be_added_the_page_says_so():
    text = page(plan=PLAN[:1], gains=[])
    assert "Everything that was planned for her is there." in text
    assert "Nothing: all that the study can do is planned for her." in text
    assert "would add:" not in text


@pytest.mark.parametrize("name", sorted(TOLD))
def test_of_every_part_that_can_be_planned_the_page_knows_how_it_shows(name):
    """A stage that is told of before a run is accounted for after it."""
    evidence = statuses(name)[TOLD[name].split(", ")[0]]
    assert evidence[0] in ("not asked", "not yet", "yes")
    assert (evidence[0] == "yes") == (name == "listed"), "nothing of her is there"
