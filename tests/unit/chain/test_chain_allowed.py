"""What a volunteer's data allow: what they lack is named with its reason, and what follows from it, too."""

from dataclasses import replace

import pytest
from small_breast import study_settings

from mammosim.chain.allowed import Data, gains, in_one_line, not_planned, reasons, told
from mammosim.chain.graph import Chain
from mammosim.chain.stages import STAGES
from mammosim.chain.subject import Subject

SERIES = frozenset({"images", "strokes", "fiducials"})
ADA = Data("ada", dict.fromkeys(("prone", "supine", "supine_tilted"), SERIES))
ONE = "ada was scanned in one position, two are needed"


def prone(*given: str) -> Data:
    return replace(ADA, given={"prone": frozenset(given)})


@pytest.fixture(scope="module")
def found(repository):
    """Why her data do not allow a stage or question; changes: of the settings of the stress-free shape."""
    settings = study_settings(repository)

    def of(data: Data, **changes: str) -> dict[str, str]:
        subject = Subject("left", "0 -1 0", (1,), moves=data.base != data.frame, has=data.has(data.base))
        chain = Chain(subject, settings, frozenset(), STAGES).with_settings(
            {f"mechanics.stress_free.{name}": value for name, value in changes.items()}
        )
        return reasons(data, chain)

    return of


def test_three_marked_positions_allow_everything(found):
    given = found(ADA)
    assert given.pop("given_labels") == given.pop("taken_labels") == "no labels are given for ada"
    assert set(given.values()) == {""}
    assert (ADA.base, ADA.frame, ADA.used) == ("prone", "supine", tuple(ADA.given))


def test_one_position_has_no_fit_and_no_registration_and_still_a_mammogram(found):
    given = found(prone("images", "strokes", "fiducials"))
    for name in (
        "registration",
        "transform",
        "moved_scan",
        "mean_shape",
        "sweep",
        "fit",
        "validation",
        "softening",
    ):
        assert given[name] == ONE, name
    for name in (
        "labels",
        "fiducials",
        "mesh",
        "stress_free",
        "pressed",
        "dose",
        "mammogram",
        "slices",
        "upright",
    ):
        assert given[name] == "", name


def test_one_series_without_strokes_and_markers_is_segmented(found):
    given = found(prone("images"))
    for name in ("segmentation", "labels", "gland_probability", "mesh", "pressed", "mammogram"):
        assert given[name] == "", name


def test_one_position_cannot_begin_with_the_mean_of_two(found):
    given = found(prone(*SERIES), default="fixed_point", start="mean")
    assert given["stress_free"] == given["mammogram"] == ONE
    assert given["mesh"] == ""


def test_labels_given_skip_the_segmentation_only(found):
    given = found(prone("labels", "fiducials"))
    assert given["segmentation"] == given["gland_probability"] == "labels are given for ada"
    assert given["scan"] == "no images are given for ada"
    assert given["labels"] == given["mammogram"] == ""


def test_two_positions_of_labels_alone_are_not_fitted_and_the_reason_says_how_unsure_that_would_be(found):
    labelled = replace(ADA, given=dict.fromkeys(("prone", "supine"), frozenset({"labels"})))
    given = found(labelled)
    assert given["registration"] == given["fit"]
    assert given["fit"].startswith(
        "no images are given for ada; the rib cage of labels alone does not register"
    )
    assert (given["mammogram"], labelled.used) == ("", ("prone",))


def test_without_markers_the_rib_cages_are_registered_and_all_positions_are_used(found):
    unmarked = replace(ADA, given=dict.fromkeys(ADA.given, SERIES - {"fiducials"}))
    given = found(unmarked)
    assert given["registration"] == given["fit"] == given["validation"] == given["mammogram"] == ""
    assert given["sweep"] == "no nipples are given for ada supine"
    assert (unmarked.used, unmarked.frame) == (tuple(ADA.given), "supine")
    partly = replace(ADA, given=ADA.given | {"supine_tilted": SERIES - {"fiducials"}})
    assert found(partly)["registration"] == found(partly)["sweep"] == ""


def test_a_sweep_needs_the_nipples_of_the_reference(found):
    partly = replace(ADA, given=ADA.given | {"supine": SERIES - {"fiducials"}})
    assert found(partly)["sweep"] == "no nipples are given for ada supine"
    assert found(replace(ADA, given=ADA.given | {"prone": SERIES - {"fiducials"}}))["sweep"] == ""


def test_without_an_image_of_each_position_nothing_is_registered(found):
    partly = replace(ADA, given=ADA.given | {"supine": frozenset({"labels", "fiducials"})})
    given = found(partly)
    assert given["registration"] == given["fit"] == given["sweep"] == "no images are given for ada supine"
    assert (partly.used, partly.frame) == (("prone",), "prone")


def test_nipples_that_nobody_marked_are_found_in_prone_only(found):
    supine = replace(ADA, given={"supine": SERIES - {"fiducials"}})
    given = found(supine)
    assert (
        given["mesh"] == given["mammogram"] == "no nipples are given for ada, which are found in prone only"
    )
    assert found(replace(ADA, given={"supine": SERIES}))["mammogram"] == ""


def test_a_fit_without_a_held_out_position_is_not_validated(found):
    given = found(replace(ADA, given=dict.fromkeys(("prone", "supine"), SERIES)))
    assert given["fit"] == ""
    assert given["validation"] == given["propagation"] == "no position of ada is held out of the fit"


def test_a_volunteer_is_told_in_one_line(found):
    rows = not_planned(found(prone("labels")))
    assert ("fit of moduli", ONE) in rows
    assert rows[0][0] == "nipples and chest marked by hand"
    assert "found in prone, to about 10 mm, and dose and force depend on them" in rows[0][1]
    line = in_one_line(rows)
    assert "no segmentation: labels are given for ada" in line
    assert line.count(ONE) == 1, "a reason stands once"
    assert "\n" not in line


def test_positions_without_the_one_that_others_are_brought_to_are_used_alone(found):
    apart = replace(ADA, given=dict.fromkeys(("prone", "supine_tilted"), SERIES))
    assert found(apart)["registration"] == "ada was not scanned supine"
    assert (apart.used, apart.frame) == (("prone",), "prone")


def test_upright_is_predicted_from_prone_only(found):
    assert found(replace(ADA, given={"supine": SERIES}))["upright"] == "ada was not scanned prone"


def test_a_thickness_is_chosen_in_prone_only(found):
    unstated = replace(prone(*SERIES), thickness=False)
    assert found(unstated)["mammogram"] == ""
    given = found(replace(ADA, given={"supine": SERIES}, thickness=False))
    assert given["pressed"] == "no thickness is given for ada, which is chosen in prone only"
    assert given["mesh"] == ""
    assert found(replace(ADA, given={"supine": SERIES}))["pressed"] == ""


def test_what_one_more_series_adds_is_told_of_the_fewest_that_it_takes(found):
    more = dict(gains(prone(*SERIES), found))
    assert set(more) == {("a supine series",), ("a supine series", "a supine tilted series")}
    assert "fit of moduli" in more["a supine series",]
    assert more["a supine series", "a supine tilted series"] == [
        "validation",
        "propagation of the fit's uncertainty",
    ]
    assert gains(ADA, found) == [], "who has all needs no more"


def test_points_that_are_listed_are_listed_of_each_position(found):
    unmarked = replace(ADA, given=dict.fromkeys(("prone", "supine"), SERIES - {"fiducials"}))
    more = dict(gains(unmarked, found))
    assert set(more["a list of markers and nipples",]) == {
        "nipples and chest marked by hand",
        "sweep of moduli",
    }, "positions are brought together by the rib cage"


def test_each_part_of_the_study_is_told_with_its_reason(found):
    rows = dict(told(found(prone("labels"))))
    assert rows["mesh"] == rows["glandular dose"] == ""
    assert rows["fit of moduli"] == ONE
