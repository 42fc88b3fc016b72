"""From raw images to a breast: settings reach those who register and segment; gravity turns with the body."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from mammosim.chain import images
from mammosim.chain.given_labels import LabelSettings, Prepared
from mammosim.chain.graph import Chain
from mammosim.chain.stages import STAGES
from mammosim.chain.subject import Subject
from mammosim.core.fiducials import Fiducials
from mammosim.core.rigid import IDENTITY, RigidTransform
from mammosim.core.volume import Grid, Image
from mammosim.imaging import registration, segmentation
from mammosim.io.fiducials import read_fiducials

REFERENCE = Image(Grid((2, 2, 2), np.ones(3), np.zeros(3)), np.ones((2, 2, 2), np.float32))
IMAGE = Image(Grid((2, 2, 2), np.ones(3), np.zeros(3)), np.zeros((2, 2, 2), np.float32))
QUARTER = RigidTransform(np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]), np.zeros(3))
SETTINGS = {
    "registration": {
        **{"chest_markers": "listed", "voxel_mm": 2.0, "smoothing_mm": [3.0, 0.0]},
        **{"iterations": 7, "samples": 500},
    },
    "segmentation": {
        "classifier": "random_forest", "trees": 9, "voxel_mm": 4.0, "neighbourhood_mm": 5.0, "smoothing": 1,
    },
}  # fmt: skip


@pytest.fixture
def called(monkeypatch):
    """What the two were called with."""
    found = {}

    def register(fixed, moving, fixed_markers, moving_markers, *, settings):
        found["registration"] = settings
        found["fixed"], found["moving"] = fixed, moving
        found["markers"] = fixed_markers.tolist(), moving_markers.tolist()
        return SimpleNamespace(refined=QUARTER, table=pd.DataFrame())

    def unmarked(fixed, moving, *, settings):
        found["unmarked"], found["fixed"], found["moving"] = settings, fixed, moving
        return SimpleNamespace(refined=QUARTER, table=pd.DataFrame())

    def segment(image, strokes, *, settings):
        found["segmentation"], found["strokes"] = settings, strokes
        return SimpleNamespace(labels="labels")

    monkeypatch.setattr(registration, "register", register)
    monkeypatch.setattr(images, "register_unmarked", unmarked)
    monkeypatch.setattr(segmentation, "segment", segment)
    return found


def _chain(*, moves=True, seed=1):
    fiducials = Fiducials(("chest_1",), ("chest",), np.zeros((1, 3)))
    subject = Subject("left", "0 -1 0", (seed, "w", "left"), (seed, "w"), moves)
    measured = {"scan": IMAGE, "strokes": pd.DataFrame(), "fiducials": fiducials}
    reference = {"reference_scan": REFERENCE, "reference_fiducials": fiducials} if moves else {}
    return Chain(subject, SETTINGS, frozenset(), STAGES).given(measured | reference)


def test_settings_reach_registration_and_segmentation(called):
    breast = _chain()["breast"]
    assert called["registration"] == registration.Settings(2.0, (3.0, 0.0), 7, 500)
    assert (called["fixed"], called["moving"]) == (REFERENCE, IMAGE), "into the frame of the reference"
    assert called["segmentation"].trees == 9
    assert called["segmentation"].voxel_mm == 4.0
    assert breast.labels == "labels"
    np.testing.assert_allclose(breast.gravity, [1, 0, 0], atol=1e-12)


def test_markers_of_the_reference_stay_and_those_of_the_position_are_moved(called):
    here, there = (Fiducials(("chest_1",), ("chest",), np.array([[x, 2.0, 3.0]])) for x in (1.0, 4.0))
    chain = _chain().given({"fiducials": here, "reference_fiducials": there})
    np.testing.assert_allclose(chain["moved_fiducials"].points, [[-2, 1, 3]], atol=1e-12)
    assert called["markers"] == ([[4, 2, 3]], [[1, 2, 3]])


@pytest.mark.parametrize(("how", "image"), [("found", IMAGE), ("listed", None)])
@pytest.mark.parametrize("beside", [True, False])
def test_chest_markers_are_as_asked_for_where_positions_are_brought_together(monkeypatch, how, image, beside):
    listed, worn = Fiducials(("chest_1",), ("chest",), np.zeros((1, 3))), []
    monkeypatch.setattr(images, "worn_on_chest", lambda *given: worn.append(given) or listed)
    subject = Subject(
        "left", "0 -1 0", (1,), has=("images", "fiducials", *(("reference",) if beside else ()))
    )
    settings = SETTINGS | {"registration": SETTINGS["registration"] | {"chest_markers": how}}
    chain = Chain(subject, settings, frozenset(), STAGES).given({"scan": IMAGE, "listed": listed})
    assert chain["fiducials"] is listed
    assert worn == ([(listed, image)] if beside else [])


def test_tissues_are_learnt_only_from_strokes_that_are_given(called):
    _chain().make("labels").required()
    assert isinstance(called["strokes"], pd.DataFrame)
    unpainted = Subject("left", "0 -1 0", (1, "w", "left"), (1, "w"), False, has=("images", "fiducials"))
    Chain(unpainted, SETTINGS, frozenset(), STAGES).given({"scan": IMAGE}).make("labels").required()
    assert called["strokes"] is None


def test_given_labels_are_taken_as_the_settings_say_and_what_is_mended_is_logged(monkeypatch, caplog):
    asked = []

    def prepared(coded, settings):
        asked.append((coded, settings))
        return Prepared("labels", ("a hole is filled", "no skin is labelled"))

    monkeypatch.setattr(images, "prepared", prepared)
    subject = Subject("left", "0 -1 0", (1,), has=("labels",))
    settings = SETTINGS | {"labels": {"glandularity_percent": 33.0, "codes": "mine.tsv"}}
    with caplog.at_level("INFO"):
        found = Chain(subject, settings, frozenset(), STAGES).given({"given_labels": "coded"})["labels"]
    assert found == "labels"
    assert asked == [("coded", LabelSettings(33.0, "mine.tsv"))]
    assert caplog.messages[:2] == ["a hole is filled", "no skin is labelled"]


def test_the_reference_position_is_not_moved(called):
    breast = _chain(moves=False)["breast"]
    assert breast.to_reference is IDENTITY
    assert _chain(moves=False)["registration"].motion is IDENTITY
    assert "registration" not in called


@pytest.mark.parametrize("unmarked", ["fiducials", "reference_fiducials"])
def test_without_chest_markers_in_both_positions_the_rib_cage_is_registered(called, unmarked):
    nipple = Fiducials(("nipple_left",), ("nipple",), np.zeros((1, 3)))
    breast = _chain().given({unmarked: nipple})["breast"]
    assert called["unmarked"] == registration.Settings(2.0, (3.0, 0.0), 7, 500)
    assert "registration" not in called
    assert (called["fixed"], called["moving"]) == (REFERENCE, IMAGE), "into the frame of the reference"
    np.testing.assert_allclose(breast.gravity, [1, 0, 0], atol=1e-12)


@pytest.mark.parametrize(
    ("gravity", "found"), [("0 -1 0", 2), ("0 -0.9 0.4", 2), ("0 1 0", 0), ("0 0 -1", 0)]
)
def test_nipples_are_looked_for_in_labels_only_where_breasts_hang(monkeypatch, tmp_path, gravity, found):
    two = Fiducials(("nipple_left", "nipple_right"), ("nipple",) * 2, np.zeros((2, 3)))
    monkeypatch.setattr(images, "nipples", lambda labels: two)
    subject = Subject("left", gravity, (1,), has=("images", "reference"))
    points = Chain(subject, SETTINGS, frozenset(), STAGES).given({"labels": "labels"})["fiducials"]
    assert len(points.names) == found
    kept = {"fiducials": str(tmp_path / "points.csv"), "markups": str(tmp_path / "points.mrk.json")}
    images.save_fiducials(points, kept, {})
    assert images.load_fiducials(kept).names == points.names, "a list without points is a list"


def test_another_stream_grows_another_forest(called):
    seeds = []
    for seed in (1, 1, 2):
        _chain(seed=seed).make("labels")
        seeds.append(called["segmentation"].seed)
    assert seeds[0] == seeds[1] != seeds[2]


def test_points_are_kept_as_a_table_and_as_slicer_reads_them(called, tmp_path):
    for name in ("fiducials", "moved_fiducials"):
        stage, files = STAGES[name], STAGES[name].files
        paths = {
            key: str(tmp_path / f"{name}{end}") for key, end in {**files.endings, **files.beside}.items()
        }
        given = _chain()[name]
        stage.save(given, paths, {})
        markups = read_fiducials(next(path for path in paths.values() if path.endswith(".mrk.json")))
        np.testing.assert_array_equal(markups.points, stage.load(paths).points)
        np.testing.assert_array_equal(markups.points, given.points)
