"""The modelled tissue ends where the chest markers say, and its mesh stands in the common frame."""

import numpy as np
import pytest

from mammosim.chain import meshed
from mammosim.chain.breast import Breast
from mammosim.chain.meshed import ElementEdges, MeshSettings
from mammosim.core.fiducials import Fiducials
from mammosim.core.labels import Label
from mammosim.core.rigid import RigidTransform, rotation
from mammosim.core.volume import LabelMap, grid_around
from mammosim.meshing.body import ElementSize
from mammosim.meshing.shapes import box

GRID = grid_around(np.zeros(3), np.ones(3), 1.0)
LABELS = LabelMap(GRID, np.full(GRID.shape, Label.ADIPOSE, np.uint8))
CHEST = np.array([[0.0, 4, -50], [10, 9, 60], [5, 7, 0], [0, 8, 20]])
MESH = box((2, 2, 2), np.array([10.0, 20, 30]))


class _Inputs(dict):
    """A breast and its settings, as a stage has them."""

    def __init__(self, breast: Breast, settings: dict) -> None:
        super().__init__(breast=breast)
        self.setting = {"mesh": settings}.__getitem__


@pytest.fixture
def cut(monkeypatch):
    """Where labels were cut, and how large elements were."""
    found = {}

    def crop_body(labels, *, posterior_limit_mm, height_limits_mm):
        found.update(posterior=posterior_limit_mm, heights=height_limits_mm)
        return "cropped"

    def mesh_body(labels, *, size):
        found.update(labels=labels, size=size)
        return MESH

    monkeypatch.setattr(meshed, "crop_body", crop_body)
    monkeypatch.setattr(meshed, "mesh_body", mesh_body)
    return found


def test_tissue_ends_behind_the_frontmost_marker_and_beyond_the_highest_and_lowest(cut):
    meshed.scanned_mesh(LABELS, CHEST, MeshSettings(ElementEdges(12.0, 16.0), 20.0, 15.0))
    assert cut == {
        "posterior": 24.0,
        "heights": (-65.0, 75.0),
        "labels": "cropped",
        "size": ElementSize(12.0, 16.0),
    }


@pytest.mark.parametrize("marked", [True, False])
def test_a_mesh_is_cut_in_the_frame_of_its_labels_and_moved_into_the_common_one(cut, monkeypatch, marked):
    motion = RigidTransform(rotation(np.array([10.0, 0, 30])), np.array([1.0, 2, 3]))
    monkeypatch.setattr(meshed, "chest_limits", lambda labels, listed: CHEST + [0, 100, 0])
    listed = Fiducials(("chest_1",), ("chest",), CHEST[:1]) if marked else Fiducials((), (), np.empty((0, 3)))
    breast = Breast(LABELS, listed, motion, np.array([0.0, -1, 0]), "left")
    settings = {
        "element_mm": {"breast": 12.0, "chest": 16.0},
        "behind_markers_mm": 20.0,
        "beyond_markers_mm": 15.0,
    }
    found = meshed.mesh(_Inputs(breast, settings))
    np.testing.assert_allclose(found.points, motion(MESH.points))
    assert cut["posterior"] == (24.0 if marked else 124.0)
