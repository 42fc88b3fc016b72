"""What is given of a position is checked together: labels, image, tag of a series, list of markers."""

from types import SimpleNamespace

import numpy as np
import pytest

from mammosim.core.errors import FiducialError, ImageError, SegmentationError
from mammosim.core.fiducials import Fiducials
from mammosim.core.labels import Label
from mammosim.core.volume import Image, LabelMap, grid_around
from mammosim.io.images import write_labels
from mammosim.io.label_maps import read_label_map
from mammosim.io.tables import read_table

GRID = grid_around(np.zeros(3), np.full(3, 8.0), 4.0)
LABELS = LabelMap(GRID, np.full(GRID.shape, Label.ADIPOSE, np.uint8))
IMAGE = Image(GRID, np.full(GRID.shape, 7.0, np.float32))
PRONE = np.array([0.0, -1.0, 0.0])
JOB = {"volunteer": "007", "position": "prone"}
CORNERS = np.array([[0.0, 0, 0], [90, 0, 0], [0, 0, 90], [90, 0, 90]])
NOTES = ["3 cm3 in 1 holes are filled", "no skin is labelled"]
SAID = {"notes": "; ".join(NOTES)}
FOUR = Fiducials(tuple(f"chest_{n}" for n in range(1, 5)), ("chest",) * 4, CORNERS)
NONE = Fiducials(("nipple_left",), ("nipple",), CORNERS[:1])
THREE = Fiducials(FOUR.names[:3], FOUR.kinds[:3], CORNERS[:3])


@pytest.fixture
def check(script, monkeypatch, tmp_path):
    """check_input with these files; `judged` is told each picture with what it is judged by."""
    module = script("check_input")
    coded = SimpleNamespace(grid=LABELS.grid, codes=LABELS.values)
    monkeypatch.setattr(module, "read_label_map", lambda path: coded)
    monkeypatch.setattr(module, "found_points", lambda labels, path, sides: None)  # see the page's tests
    monkeypatch.setattr(
        module,
        "read_scan",
        lambda path, series, gaps: SimpleNamespace(
            image=IMAGE, patient_position="HFP", notes=[f"{series} {gaps}"]
        ),
    )
    monkeypatch.setattr(module, "image_quality", lambda image, *, position: {"brightest": image.values.max()})

    monkeypatch.setattr(module, "require_plausible", lambda listed, image: None)
    monkeypatch.setattr(module, "require_drawn_in", lambda labels, image: None)
    monkeypatch.setattr(module, "require_painted", lambda strokes, image: None)
    monkeypatch.setattr(module, "read_strokes", lambda path: path)

    def run(
        files, judged=lambda image, **about: None, listed=FOUR, *, found=False, registered=True, sides=()
    ):
        monkeypatch.setattr(module, "require_usable", judged)
        monkeypatch.setattr(module, "read_fiducials", lambda path: listed)
        out = tmp_path / "row.csv"
        how = {"series": "5", "gaps": "resample"}
        taken = lambda coded: (LABELS, NOTES)  # noqa: E731
        asked = module.Asked(found=found, registered=registered, sides=sides, how=how, taken=taken)
        module.main(files, JOB, PRONE, asked, out=str(out))
        return read_table(out).to_dict("records")

    run.module = module
    return run


def test_the_row_is_of_the_image_where_one_is_given_beside_labels(check):
    assert check({"labels": "l.nii.gz", "images": "i.nii.gz"}) == [
        JOB | {"brightest": 7.0, "notes": f"{SAID['notes']}; 5 resample"}
    ]
    assert check({"labels": "l.nii.gz"}) == [JOB | {"brightest": 1000.0} | SAID], (
        "of the outline of her labels"
    )


def test_labels_and_image_are_both_judged_by_her_position_and_a_series_by_its_tag(check, tmp_path):
    judged = []

    def recorded(image, **about):
        judged.append((float(image.values.max()), about))

    check({"labels": "l.nii.gz", "images": str(tmp_path)}, recorded)
    (outline, by_position), (image, by_tag) = judged
    assert (outline, image) == (1000.0, 7.0)
    assert by_position == {"position": "prone", "gravity": PRONE, "patient_position": None}
    assert by_tag == {"position": "prone", "gravity": PRONE, "patient_position": "HFP"}


def test_the_named_series_is_read_and_what_stands_out_is_logged(check, caplog):
    with caplog.at_level("INFO"):
        check({"images": "folder"})
    assert caplog.messages == ["folder: 5 resample"]


@pytest.mark.parametrize(("sides", "said"), [(["left", "right"], 1), (["left"], 0)])
def test_an_image_of_one_breast_is_noted_where_both_are_asked_for(check, monkeypatch, sides, said):
    monkeypatch.setattr(check.module, "shows_one_breast", lambda image: True)
    (row,) = check({"images": "i.nii.gz"}, sides=sides)
    assert row["notes"].count("one breast is shown and both are asked for") == said
    monkeypatch.setattr(check.module, "shows_one_breast", lambda image: False)
    (row,) = check({"images": "i.nii.gz"}, sides=sides)
    assert row["notes"] == "5 resample"


def test_labels_in_the_place_of_an_image_are_rejected_by_their_file(check, monkeypatch):
    codes = SimpleNamespace(image=Image(GRID, np.arange(GRID.shape[0] ** 3).reshape(GRID.shape) % 6.0))
    codes.patient_position, codes.notes = None, []
    monkeypatch.setattr(check.module, "read_scan", lambda path, series, gaps: codes)
    with pytest.raises(ImageError, match=r"^i\.nii\.gz: it has 6 values, from 0 to 5, .* the column labels"):
        check({"images": "i.nii.gz"})


def test_labels_are_of_the_image_beside_them(check, monkeypatch):
    def rejected(labels, image):
        raise ImageError(f"{labels.values.max()} in {image.values.max():g}")

    monkeypatch.setattr(check.module, "require_drawn_in", rejected)
    with pytest.raises(ImageError, match=r"^l\.nii\.gz with i\.nii\.gz: 1 in 7$"):
        check({"labels": "l.nii.gz", "images": "i.nii.gz"})
    check({"labels": "l.nii.gz"})
    check({"images": "i.nii.gz"})


@pytest.mark.parametrize(("value", "kind"), [(1000.0, "labels"), (7.0, "images")])
def test_a_picture_that_cannot_be_used_is_named_by_its_file(check, value, kind):
    def rejected(image, **about):
        if image.values.max() == value:
            raise ImageError("the breast is cut off")

    with pytest.raises(ImageError, match=rf"^{kind}\.nii\.gz: the breast is cut off$"):
        check({"labels": "labels.nii.gz", "images": "images.nii.gz"}, rejected)


def test_a_list_needs_four_chest_markers_only_where_positions_are_brought_together(check):
    files = {"images": "i.nii.gz", "listed": "list.csv"}
    with pytest.raises(FiducialError, match=r"^list\.csv with its image: 3 chest markers at"):
        check(files, listed=THREE)
    check(files, listed=THREE, registered=False)
    check(files, listed=FOUR)
    check(files, listed=NONE)


def test_chest_markers_are_looked_for_in_the_image_where_they_are_to_be_found(check, monkeypatch):
    seen = []

    monkeypatch.setattr(check.module, "worn_on_chest", lambda listed, image: seen.append((listed, image)))
    check({"images": "i.nii.gz", "listed": "list.csv"}, listed=THREE, found=True)
    check({"images": "i.nii.gz", "listed": "list.csv"}, listed=FOUR)
    assert seen == [(THREE, IMAGE), (FOUR, None)]


def test_a_list_has_the_nipples_of_the_sides_that_are_studied(check):
    files = {"images": "i.nii.gz", "listed": "list.csv"}
    with pytest.raises(FiducialError, match=r"^list\.csv with its image: nipple_left is missing"):
        check(files, sides=["left"])
    nipple = Fiducials((*FOUR.names, "nipple_left"), (*FOUR.kinds, "nipple"), np.vstack([CORNERS, [9, 9, 9]]))
    check(files, listed=nipple, sides=["left"])
    with pytest.raises(
        FiducialError, match=r"nipple_right is missing; mark it, or set compression.sides: \[left\]"
    ):
        check(files, listed=nipple, sides=["left", "right"])
    with pytest.raises(FiducialError, match=r"nipple_left and nipple_right are missing; mark them$"):
        check(files, sides=["left", "right"])


def test_points_are_judged_by_the_picture_they_go_with_and_named_by_their_file(check, monkeypatch):
    def rejected(listed, image):
        raise FiducialError(f"{len(listed.names)} points on {image.values.max():g}")

    monkeypatch.setattr(check.module, "require_plausible", rejected)
    with pytest.raises(FiducialError, match=r"^list\.csv with its image: 4 points on 7$"):
        check({"labels": "l.nii.gz", "images": "i.nii.gz", "listed": "list.csv"})


def test_strokes_are_judged_where_they_are_used_and_named_by_their_file(check, monkeypatch):
    def rejected(strokes, image):
        raise SegmentationError(f"nothing of {strokes} on {image.values.max():g}")

    monkeypatch.setattr(check.module, "require_painted", rejected)
    with pytest.raises(SegmentationError, match=r"^strokes\.csv: nothing of strokes\.csv on 7$"):
        check({"images": "i.nii.gz", "strokes": "strokes.csv"})
    check({"images": "i.nii.gz", "labels": "l.nii.gz", "strokes": "strokes.csv"})  # labels stand for them


def test_nipples_are_looked_for_in_labels_of_prone_alone_and_where_nobody_marked_them(check, monkeypatch):
    module, seen = check.module, []
    monkeypatch.setattr(module, "found_points", lambda labels, path, sides: seen.append(path))
    monkeypatch.setattr(module, "require_usable", lambda image, **about: None)
    monkeypatch.setattr(module, "read_fiducials", lambda path: NONE)
    asked = module.Asked(found=False, registered=False, sides=[], how={}, taken=lambda coded: (LABELS, []))
    for position in ("supine", "prone"):
        assert module.look({"labels": position}, position, PRONE, asked).faults == []
    module.look({"labels": "marked", "listed": "list.csv"}, "prone", PRONE, asked)
    assert seen == ["prone"]


def test_labels_in_which_no_breast_stands_out_are_rejected_at_once(script, monkeypatch):
    """Later stages would end there: the mesh, where nobody marked the chest."""
    grid = grid_around(np.array([-100.0, 0, -50]), np.array([100.0, 60, 50]), 10.0)
    flat = np.full(grid.shape, Label.ADIPOSE, np.uint8)
    flat[:, 0], flat[:, 4:] = Label.AIR, Label.THORAX
    both = Fiducials(
        ("nipple_left", "nipple_right"), ("nipple",) * 2, np.array([[60.0, 10, 0], [-60, 10, 0]])
    )
    module = script("check_input")
    monkeypatch.setattr(module, "nipples", lambda labels: both)
    with pytest.raises(FiducialError, match=r"^l\.nii\.gz: no breast stands out in front of the midline"):
        module.found_points(LabelMap(grid, flat), "l.nii.gz", ["left", "right"])


def test_every_part_is_judged_and_each_fault_is_a_line(check):
    def rejected(image, **about):
        raise ImageError("the breast is cut off")

    with pytest.raises(ImageError) as error:
        check({"labels": "l.nii.gz", "images": "i.nii.gz", "listed": "list.csv"}, rejected, listed=THREE)
    first, second, third = str(error.value).splitlines()
    assert first == "l.nii.gz: the breast is cut off"
    assert second == "i.nii.gz: the breast is cut off"
    assert third.startswith("list.csv with its image: 3 chest markers")


def test_a_label_map_is_read_by_its_codes_and_what_is_mended_is_said(script, tmp_path):
    """A slab of one voxel, thinner than half an element, in codes of a table."""
    grid = grid_around(np.zeros(3), np.full(3, 40.0), 5.0)
    values = np.zeros(grid.shape, np.uint8)
    values[:, 5], values[:, 6:] = 9, 7
    write_labels(LabelMap(grid, values), tmp_path / "l.nii.gz")
    (tmp_path / "codes.tsv").write_text("code\ttissue\n0\tair\n7\tthorax\n9\tadipose\n")
    settings = {"glandularity_percent": 20.0, "codes": str(tmp_path / "codes.tsv")}
    taken = script("check_input").taken_by(settings, {"breast": 12.0, "chest": 16.0})
    labels, notes = taken(read_label_map(tmp_path / "l.nii.gz"))
    assert np.unique(labels.values).tolist() == [Label.AIR, Label.ADIPOSE, Label.THORAX]
    assert notes[-1] == f"{40 * 40 * 5 / 1000:.0f} cm3 are thinner than half an element"
