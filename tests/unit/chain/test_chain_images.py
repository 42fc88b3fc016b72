"""From raw images to a breast: settings reach those who register and segment; gravity turns with the body."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from mammosim.chain.graph import Chain
from mammosim.chain.stages import STAGES
from mammosim.chain.subject import Subject
from mammosim.core.fiducials import Fiducials
from mammosim.core.rigid import IDENTITY, RigidTransform
from mammosim.core.volume import Grid, Image
from mammosim.imaging import registration, segmentation

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
        return SimpleNamespace(refined=QUARTER, table=pd.DataFrame())

    def segment(image, strokes, *, settings):
        found["segmentation"], found["strokes"] = settings, strokes
        return SimpleNamespace(labels="labels")

    monkeypatch.setattr(registration, "register", register)
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


def test_tissues_are_learnt_only_from_strokes_that_are_given(called):
    _chain().make("labels").required()
    assert isinstance(called["strokes"], pd.DataFrame)
    unpainted = Subject("left", "0 -1 0", (1, "w", "left"), (1, "w"), False, has=("images", "fiducials"))
    Chain(unpainted, SETTINGS, frozenset(), STAGES).given({"scan": IMAGE}).make("labels").required()
    assert called["strokes"] is None


def test_the_reference_position_is_not_moved(called):
    breast = _chain(moves=False)["breast"]
    assert breast.to_reference is IDENTITY
    assert "registration" not in called


def test_another_stream_grows_another_forest(called):
    seeds = []
    for seed in (1, 1, 2):
        _chain(seed=seed).make("labels")
        seeds.append(called["segmentation"].seed)
    assert seeds[0] == seeds[1] != seeds[2]
