"""Markers are found where they are, and too few or useless ones are rejected before any registration."""

import numpy as np
import pytest

from mammosim.core.errors import FiducialError
from mammosim.core.fiducials import Fiducials
from mammosim.core.rigid import RigidTransform, rotation
from mammosim.imaging.markers import chest_markers, find_markers, require_four, worn_on_chest

TURNED = RigidTransform(rotation(np.array([2.0, -1.0, 3.0])), np.array([3.3, -2.1, 1.7]))


# A ball of 7 mm at 4 mm voxels is drawn with 2 mm sub-voxels: its own centroid wanders by up to half of one.
@pytest.mark.parametrize(("spacing", "tolerance"), [(4.0, 1.5), ((2.0, 2.0, 3.0), 0.6)])
def test_every_marker_and_nothing_else_is_found(render, spacing, tolerance) -> None:
    scan = render(spacing, TURNED, high=(164, 30, 90))
    truth = np.vstack([scan.chest, scan.breast])
    distance = np.linalg.norm(find_markers(scan.image)[:, None] - truth, axis=2)
    assert distance.shape == (8, 8)
    assert distance.min(axis=1).max() < tolerance
    assert sorted(distance.argmin(axis=1)) == list(range(8))


def test_blobs_that_nobody_listed_are_the_chest_markers(chest) -> None:
    found = chest_markers(chest.image, chest.listed())
    assert found.names[:5] == ("chest_1", "chest_2", "chest_3", "chest_4", "breast_1")
    distance = np.linalg.norm(found.of_kind("chest")[:, None] - chest.chest, axis=2)
    assert distance.min(axis=1).max() < 1.5
    assert np.all(np.diff(found.of_kind("chest")[:, 2]) <= 0)


def test_the_chest_markers_of_the_list_are_replaced(chest) -> None:
    listed = chest.listed()
    away = Fiducials(
        ("chest_1", *listed.names), ("chest", *listed.kinds), np.vstack([[[0, 0, 0]], listed.points])
    )
    assert chest_markers(chest.image, away).names == chest_markers(chest.image, listed).names


def test_an_unlisted_breast_marker_is_not_taken_for_a_chest_marker(chest) -> None:
    listed = chest.listed()
    short = Fiducials(listed.names[1:], listed.kinds[1:], listed.points[1:])
    with pytest.raises(FiducialError, match=r"5 chest markers at .* mm, 4 are needed; list chest_1"):
        chest_markers(chest.image, short)


def test_fewer_than_four_chest_markers_are_rejected(render) -> None:
    scan = render(4.0, high=(164, 70, 60))  # the two upper markers lie outside the image
    with pytest.raises(FiducialError, match=r"2 chest markers at .* mm, 4 are needed"):
        chest_markers(scan.image, scan.listed())


def test_collinear_markers_are_rejected() -> None:
    line = np.array([[1.0, 0, 0], [0, 0, 40], [0, 2, 80], [0, 0, 120]])
    with pytest.raises(FiducialError, match=r"collinear: they spread 89 mm along a line and 1\.. mm across"):
        require_four(line)


def test_chest_markers_may_be_worn_or_not_but_not_in_part(chest, monkeypatch) -> None:
    nowhere = chest.listed()
    assert worn_on_chest(nowhere, None) is nowhere
    four = chest_markers(chest.image, nowhere)
    assert worn_on_chest(four, None) is four
    three = Fiducials(four.names[1:], four.kinds[1:], four.points[1:])
    with pytest.raises(FiducialError, match=r"^3 chest markers at"):
        worn_on_chest(three, None)
    assert worn_on_chest(nowhere, chest.image).names == four.names, "found, though nobody listed them"
    none = np.zeros((0, 3))
    monkeypatch.setattr("mammosim.imaging.markers.find_markers", lambda image, *, diameter_mm: none)
    assert worn_on_chest(nowhere, chest.image) is nowhere
    with pytest.raises(FiducialError, match=r"^0 chest markers at nowhere"):
        worn_on_chest(four, chest.image)
