"""The page of one woman before a run: what was understood of her data, and what is planned."""

import re
from dataclasses import replace

import pytest

from mammosim.study.report.pages import Picture, report
from mammosim.study.report.women import Checked, checked_sections, verdict

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
    assert "Her data can be used: nothing in them would stop the study" in page
    assert "data:image/png;base64" in page
    for words in ("a.nii.gz", "spacing x mm", "0.8", "To 45 mm, as given.", PLAN[1][1], "a supine series"):
        assert words in page
    assert re.search(f'<td[^>]*>{re.escape(PLAN[0][0])}</td><td class="label">yes</td>', page)
    assert re.search(f'<td[^>]*>{re.escape(PLAN[1][0])}</td><td class="label">no</td>', page)


def test_a_note_is_told_as_it_stands():
    """A segment may have any name."""
    page = checked(replace(PRONE, notes=("the segment $a$ **[b](c)** is no tissue",)))
    assert "Noted: the segment $a$ **[b](c)** is no tissue." in page


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


def test_who_lacks_nothing_is_told_so():
    sections = checked_sections([PRONE], PLAN[:1], [], thickness="", waits=False)
    assert "Nothing: all that the study can do is planned for her." in report("ada", sections, numbers={})


@pytest.mark.parametrize(
    ("stops", "said"),
    [
        ([], "her data can be used"),
        (["prone: a.nii:\n cut off"], "prone: a.nii: cut off"),
        (["one", "two"], "one (2 reasons, this is the first)"),
        (["one", "two", "three"], "one (3 reasons, this is the first)"),
    ],
)
def test_a_verdict_is_one_line_with_the_first_reason_and_how_many_there_are(stops, said):
    found = {"volunteer": "ada", "stops": stops, "waits": False}
    assert verdict(found, "ada.html") == f"ada: {said}; see ada.html"
