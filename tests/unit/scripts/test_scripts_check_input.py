"""What is given of a position is checked together: labels, image, tag of a series, list of markers."""

from types import SimpleNamespace

import numpy as np
import pytest

from mammosim.core.errors import FiducialError, ImageError
from mammosim.core.fiducials import Fiducials
from mammosim.core.labels import Label
from mammosim.core.volume import Image, LabelMap, grid_around
from mammosim.io.tables import read_table

GRID = grid_around(np.zeros(3), np.full(3, 8.0), 4.0)
LABELS = LabelMap(GRID, np.full(GRID.shape, Label.ADIPOSE, np.uint8))
IMAGE = Image(GRID, np.full(GRID.shape, 7.0, np.float32))
PRONE = np.array([0.0, -1.0, 0.0])
JOB = {"volunteer": "007", "position": "prone"}
CORNERS = np.array([[0.0, 0, 0], [90, 0, 0], [0, 0, 90], [90, 0, 90]])
FOUR = Fiducials(tuple(f"chest_{n}" for n in range(1, 5)), ("chest",) * 4, CORNERS)
NONE = Fiducials(("nipple_left",), ("nipple",), CORNERS[:1])
THREE = Fiducials(FOUR.names[:3], FOUR.kinds[:3], CORNERS[:3])


@pytest.fixture
def check(script, monkeypatch, tmp_path):
    """check_input with these files; `judged` is told each picture with what it is judged by."""
    module = script("check_input")
    monkeypatch.setattr(module, "read_labels", lambda path: LABELS)
    monkeypatch.setattr(module, "read_image", lambda path: IMAGE)
    monkeypatch.setattr(
        module, "read_series", lambda path: SimpleNamespace(image=IMAGE, patient_position="HFP")
    )
    monkeypatch.setattr(module, "image_quality", lambda image, *, position: {"brightest": image.values.max()})

    def run(files, judged=lambda image, **about: None, listed=FOUR, *, found=False, registered=True):
        monkeypatch.setattr(module, "require_usable", judged)
        monkeypatch.setattr(module, "read_fiducials", lambda path: listed)
        out = tmp_path / "row.csv"
        module.main(files, JOB, PRONE, found=found, registered=registered, out=str(out))
        return read_table(out).to_dict("records")

    run.module = module
    return run


def test_the_row_is_of_the_image_where_one_is_given_beside_labels(check):
    assert check({"labels": "l.nii.gz", "images": "i.nii.gz"}) == [JOB | {"brightest": 7.0}]
    assert check({"labels": "l.nii.gz"}) == [JOB | {"brightest": 1000.0}], "of the outline of her labels"


def test_labels_and_image_are_both_judged_by_her_position_and_a_series_by_its_tag(check, tmp_path):
    judged = []

    def recorded(image, **about):
        judged.append((float(image.values.max()), about))

    check({"labels": "l.nii.gz", "images": str(tmp_path)}, recorded)
    (outline, by_position), (image, by_tag) = judged
    assert (outline, image) == (1000.0, 7.0)
    assert by_position == {"position": "prone", "gravity": PRONE, "patient_position": None}
    assert by_tag == {"position": "prone", "gravity": PRONE, "patient_position": "HFP"}


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
