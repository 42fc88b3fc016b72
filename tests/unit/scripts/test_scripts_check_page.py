"""The page of a woman whose data are rejected shows why, and what can be seen of them."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import SimpleITK as sitk
from tiny_woman import tiny_image, tiny_labels

from mammosim.core.fiducials import Fiducials
from mammosim.core.labels import Label
from mammosim.core.volume import Grid, LabelMap
from mammosim.io.images import itk_volume, write_image, write_labels

TOLD = {
    "planned": [("mesh", "")],
    "gains": [],
    "thickness": "No thickness is given.",
    "waits": False,
    "modelled": "prone",
    "stated": False,
    "asked": {"found": False, "registered": False, "sides": ["left", "right"]},
    "element_mm": {"breast": 12.0, "chest": 16.0},
    "compression": {
        "sides": ["left", "right"],
        "depth_share": 0.5,
        "smallest_mm": 20.0,
    },
}


READ = {"how": {"series": "", "gaps": ""}, "codes": {"glandularity_percent": 20.0, "codes": ""}}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Good labels and image of a tiny woman."""
    folder = tmp_path_factory.mktemp("tiny")
    labels = tiny_labels(8.0)
    write_labels(labels, folder / "labels.nii.gz")
    write_image(tiny_image(labels), folder / "image.nii.gz")
    return SimpleNamespace(folder=folder, labels=labels)


@pytest.fixture
def page(script, tmp_path):
    """Page and reasons to stop, of files of one prone position."""
    module = script("check_page")

    def made(given: dict, **told) -> tuple[str, list[str]]:
        given = {kind: str(path) for kind, path in given.items()}
        row = {"position": "prone", "used": True, "there": True, "files": given, "gravity": "0 -1 0", **READ}
        out = {"page": str(tmp_path / "p.html"), "verdict": str(tmp_path / "p.json")}
        module.main("ada", [row], TOLD | told, out)
        return (tmp_path / "p.html").read_text(), json.loads((tmp_path / "p.json").read_text())["stops"]

    made.module = module
    return made


def test_good_labels_have_a_picture_nipples_and_the_thickness_that_will_be_chosen(page, files):
    text, stops = page({"labels": files.folder / "labels.nii.gz"})
    assert stops == []
    assert text.count("data:image/png") == 1
    assert "Noted: " in text, "that skin counts as fat"
    # 60 mm and the 16 mm to the ribs, half of it, to a voxel of 8 mm.
    (left,) = [part for part in text.split("about ")[1:] if "(left)" in part[:20]]
    assert 30 <= float(left.split(" mm")[0]) <= 42
    assert "In her labels" not in page({"labels": files.folder / "labels.nii.gz"}, stated=True)[0]


def test_how_the_files_were_read_stands_on_the_page(page, files):
    """Codes and who explains them, and where her head is taken to be, which a symmetric body cannot show."""
    text, _ = page({"labels": files.folder / "labels.nii.gz"})
    assert "the program&#39;s own (preset mammosim): the column codes is empty" in text
    assert "; 1: adipose, " in text
    assert "her head towards larger z (S in the pictures)" in text
    assert "as the header&#39;s sform or qform says; a body whose ends look alike shows no exchange" in text


def test_who_says_where_her_head_is_is_told_of_the_image_beside_labels(page, files, tmp_path):
    image = itk_volume(files.labels.grid, tiny_image(files.labels).values)
    sitk.WriteImage(image, str(tmp_path / "image.nrrd"))
    text, stops = page({"labels": files.folder / "labels.nii.gz", "images": tmp_path / "image.nrrd"})
    assert stops == []
    assert "as the file&#39;s header says; a body" in text


def test_labels_have_no_noise_and_an_image_has(page, files):
    labels, image = {"labels": files.folder / "labels.nii.gz"}, {"images": files.folder / "image.nii.gz"}
    assert "fat to noise" not in page(labels)[0]
    assert "fat to noise" in page(labels | image)[0]


def test_codes_that_nobody_explains_are_listed_beside_the_reason(page, files, tmp_path):
    labels = replace(
        files.labels, values=np.where(files.labels.values == 2, np.uint8(12), files.labels.values)
    )
    write_labels(labels, tmp_path / "l.nii.gz")
    text, (why,) = page({"labels": tmp_path / "l.nii.gz"})
    assert "no tissue for code 12" in why
    assert "; 12: no tissue, " in text


def test_a_thickness_that_makes_no_sense_is_a_reason_to_stop_before_anything_is_computed(page, files):
    compression = TOLD["compression"] | {"smallest_mm": 60.0}
    _, stops = page({"labels": files.folder / "labels.nii.gz"}, compression=compression)
    assert len(stops) == 2, "of either side"
    assert "outside [60, 120]; state hers in compression.thickness_mm" in stops[0]


def test_a_nipple_that_is_not_listed_is_one_reason_and_not_two(page, files, tmp_path):
    (tmp_path / "list.csv").write_text("name,kind,x_mm,y_mm,z_mm\nnipple_left,nipple,70,-60,0\n")
    text, stops = page({"labels": files.folder / "labels.nii.gz", "listed": tmp_path / "list.csv"})
    (stop,) = stops
    assert "nipple_right is missing; mark it, or set compression.sides: [left]" in stop
    assert "(left)" in text, "the thickness of the side that has one"


def test_rejected_labels_have_their_codes_as_a_picture(page, files, tmp_path):
    others = np.where(files.labels.values == Label.THORAX, np.uint8(50), files.labels.values)
    write_labels(LabelMap(files.labels.grid, others), tmp_path / "codes.nii.gz")
    text, (why,) = page({"labels": tmp_path / "codes.nii.gz"})
    assert "has no tissue for code 50" in why
    assert "1 reason to stop" in text
    assert "data:image/png" in text


def test_labels_of_one_breast_stop_where_both_are_asked_for(page, files, tmp_path):
    grid, left = files.labels.grid, files.labels.values[:, :, files.labels.grid.shape[2] // 2 :]
    half = Grid(left.shape, grid.spacing, grid.origin + [grid.spacing[0] * (grid.shape[2] // 2), 0, 0])
    write_labels(LabelMap(half, left), tmp_path / "one.nii.gz")
    _, stops = page({"labels": tmp_path / "one.nii.gz"})
    (why,) = stops
    assert "one.nii.gz holds the left breast alone, and left and right are asked for" in why
    assert "set compression.sides: [left]" in why


def test_a_file_that_cannot_be_read_and_one_that_can_stand_on_one_page(page, files, tmp_path):
    (tmp_path / "cut.nii.gz").write_bytes((files.folder / "image.nii.gz").read_bytes()[:100])
    text, stops = page({"labels": files.folder / "labels.nii.gz", "images": tmp_path / "cut.nii.gz"})
    assert len(stops) == 1
    assert "cut.nii.gz" in stops[0]
    assert "data:image/png" in text, "her labels"


def test_a_fault_of_the_program_is_a_reason_on_the_page_and_not_the_end_of_it(
    page, files, monkeypatch, caplog
):
    def broken(*args, **more):
        raise KeyError("prone")

    monkeypatch.setattr(page.module.check_input, "look", broken)
    text, (why,) = page({"labels": files.folder / "labels.nii.gz"})
    assert why == "prone: a fault of the program, KeyError: 'prone'"
    assert "a fault of the program" in text
    assert "in broken" in caplog.text, "the log tells where"


def test_a_reason_to_stop_is_told_also_while_other_scans_wait(page, tmp_path):
    text, stops = page({"images": tmp_path / "none.nii.gz"}, waits=True)
    assert len(stops) == 1
    assert "1 reason to stop" in text


def test_a_picture_has_all_that_is_known_of_its_position_and_says_what_that_is(page, files, monkeypatch):
    module, drawn = page.module, []

    def understood(image, **about):
        drawn.append(about)
        return "figure"

    monkeypatch.setattr(module, "understood", understood)
    monkeypatch.setattr(module, "png_of", lambda figure: figure)
    seen = module.check_input.Seen(images={"labels": tiny_image(files.labels)}, labels=files.labels)
    row = {"position": "supine_tilted", "gravity": "0 1 0", "files": {}}
    (picture,) = module.pictures_of("ada", row, seen)
    assert "ada, supine tilted: 8.00 x 8.00 x 8.00 mm, with outlines of the labels. g is" in picture.caption
    seen.listed, seen.labels = Fiducials((), (), np.empty((0, 3))), None
    (picture,) = module.pictures_of("ada", row, seen)
    assert "mm, with points as listed or found. g is" in picture.caption
    first, second = drawn
    assert (first["labels"], first["fiducials"]) == (files.labels, None)
    assert (second["labels"], second["fiducials"]) == (None, seen.listed)
    assert first["gravity"].tolist() == [0, 1, 0]


def test_a_picture_that_cannot_be_drawn_is_a_reason_to_stop(page, files, monkeypatch):
    def broken(*args, **more):
        raise KeyError("slices")

    monkeypatch.setattr(page.module, "understood", broken)
    _, (why,) = page({"labels": files.folder / "labels.nii.gz"})
    assert why == "prone: a fault of the program, KeyError: 'slices'"


def test_each_position_is_read_and_judged_as_its_own_row_says(page, tmp_path, monkeypatch):
    module, seen = page.module, []
    codes = {"prone": "a.tsv", "supine": "b.tsv"}
    monkeypatch.setattr(module.check_input, "taken_by", lambda settings, element_mm: settings["codes"])

    def looked(files, position, gravity, asked):
        seen.append((position, files["images"], gravity.tolist(), asked.how["series"], asked.taken))
        return module.check_input.Seen()

    monkeypatch.setattr(module.check_input, "look", looked)
    rows = [
        {
            **{"position": p, "used": True, "there": p != "upright", "files": {"images": p}, "gravity": g},
            **{"how": {"series": n, "gaps": ""}, "codes": {"codes": codes.get(p, "")}},
        }
        for p, g, n in (("supine", "0 1 0", "3"), ("prone", "0 -1 0", "12"), ("upright", "0 0 -1", ""))
    ]
    out = {"page": str(tmp_path / "p.html"), "verdict": str(tmp_path / "p.json")}
    module.main("ada", rows, TOLD | {"waits": True}, out)
    assert seen == [
        ("supine", "supine", [0, 1, 0], "3", "b.tsv"),
        ("prone", "prone", [0, -1, 0], "12", "a.tsv"),
    ]
    assert json.loads((tmp_path / "p.json").read_text()) == {"volunteer": "ada", "stops": [], "waits": True}
    assert "Her scans are made by the study itself" in (tmp_path / "p.html").read_text()


def test_the_thickness_is_told_of_the_position_that_is_modelled(page, files):
    module = page.module
    nipples = Fiducials(
        ("nipple_left", "nipple_right"), ("nipple",) * 2, np.array([[60.0, -40, 0], [-60, -40, 0]])
    )
    seen = module.check_input.Seen(labels=files.labels, listed=nipples)
    told = {name: TOLD[name] for name in ("modelled", "stated", "compression")}
    assert len(module.thickness_words({"supine": module.check_input.Seen(), "prone": seen}, told)) == 2
    assert module.thickness_words({"supine": seen}, told) == []
    assert module.thickness_words({"supine": seen, "prone": module.check_input.Seen()}, told) == []


def test_a_position_that_is_not_used_stops_nothing(page, tmp_path):
    row = {
        "position": "supine",
        "used": False,
        "there": True,
        "files": {"images": "none.nii.gz"},
        "gravity": "0 1 0",
    }
    out = {"page": str(tmp_path / "p.html"), "verdict": str(tmp_path / "p.json")}
    page.module.main("ada", [row], TOLD, out)
    assert json.loads((tmp_path / "p.json").read_text())["stops"] == []
    assert "none.nii.gz" in (tmp_path / "p.html").read_text()
