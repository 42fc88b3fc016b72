"""The pages of one woman: what was understood of her data, and what was done with them."""

import pandas as pd
import yaml

from mammosim.io.tabulated import tabulated
from mammosim.study.report.pages import Picture, report
from mammosim.study.report.women import Checked, carried_words, checked_sections, done_sections, verdict

PLAN = [("mesh", ""), ("fit of moduli", "ada was scanned in one position, two are needed")]
GAINS = [(("a supine series",), ["registration", "fit of moduli"])]
CUT = "a.nii.gz: the prone image cuts the breast off"
PRONE = Checked(
    "prone", True, {"images": "a.nii.gz"}, (), {"spacing_x_mm": 0.8}, (Picture(b"\x89PNG", "Prone."),)
)


def checked(*positions: Checked, waits: bool = False) -> str:
    sections = checked_sections(positions, PLAN, GAINS, thickness="To 45 mm, as given.", waits=waits)
    return report("ada", sections, numbers={})


def test_a_page_shows_pictures_files_and_what_is_planned_and_why_not():
    page = checked(PRONE)
    assert "Nothing that is given of her would stop the study" in page
    assert "data:image/png;base64" in page
    for words in ("a.nii.gz", "spacing x mm", "0.8", "To 45 mm, as given.", PLAN[1][1], "a supine series"):
        assert words in page


def test_every_reason_stands_on_the_page_with_its_position():
    tilted = Checked("supine_tilted", False, {}, ("no image",), {}, ())
    page = checked(Checked("prone", True, {}, (CUT, "three markers"), {}, ()), tilted)
    assert "<strong>2 reasons to stop.</strong>" in page, (
        "one of a position that nothing is made of stops nothing"
    )
    assert all(words in page for words in (CUT, "three markers", "no image"))
    assert "This position is not used" in page


def test_who_is_still_to_be_scanned_is_no_reason_to_stop():
    assert "made by the study itself" in checked(waits=True)


def test_a_verdict_is_one_line_with_the_first_reason():
    found = {"volunteer": "ada", "stops": [f"prone: {CUT}\nagain", "b", "c"], "waits": False}
    words = verdict(found, "results/checked/ada.html")
    assert words == f"ada: prone: {CUT} again (3 reasons, this is the first); see results/checked/ada.html"
    assert verdict(found | {"stops": []}, "p").startswith("ada: her data can be used")
    assert verdict(found | {"stops": [], "waits": True}, "p") == "ada: her scans are made by the study; see p"


def test_what_was_done_shows_answers_gaps_and_links_from_her_folder():
    pressed = pd.DataFrame(
        {"side": ["left"], "strategy": ["standard"], "thickness_from": ["chosen: half"], "force_n": [3.2]}
        | {"chest_gap_mm": [23.4], "chest_gap_from": ["clear of held skin"]}
    )
    missing = pd.DataFrame({"reason": ["the breast slipped out"], "tables": ["image"], "figures": [""]})
    sections = done_sections(
        {"compression": pressed, "field": pressed},
        {"Tables": ["results/dose/ada.csv"], "Figures": []},
        missing,
        PLAN,
        GAINS,
        given=pd.DataFrame({"position": ["prone"], "images": ["a.nii.gz"]}),
        thickness="Half of her depth.",
        home="results/women/ada",
    )
    page = report("ada", sections, numbers={})
    assert '<a href="../../../results/dose/ada.csv">dose/ada.csv</a>' in page
    for words in (
        "chosen: half",
        "23.4",
        "clear of held skin",
        "3.2",
        "the breast slipped out",
        PLAN[1][1],
        "Half of her depth.",
    ):
        assert words in page
    assert page.count("chosen: half") == 1, "only the tables that answer are shown"


def attempts(*tried):
    rows = [
        {"method": method, "moduli_factor": factor, "adipose_kpa": factor, "glandular_kpa": factor}
        | {"skin_kpa": 10 * factor, "outcome": outcome}
        for method, factor, outcome in tried
    ]
    return {"stress_free_attempts": pd.DataFrame(rows)}


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
    assert carried_words({}) == ""


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
    nothing = pd.DataFrame(columns=["reason", "tables", "figures"])
    given = pd.DataFrame({"position": ["prone"]})
    page = report(
        "ada",
        done_sections({}, {}, nothing, PLAN[:1], [], given=given, thickness="", home="results/women/ada"),
        numbers={},
    )
    assert "Everything that was planned for her is there." in page
    assert "Nothing: all that the study can do is planned for her." in page
