"""Dice of label maps whose overlap is known by counting."""

import numpy as np
import pytest

from mammosim.core.errors import SegmentationError
from mammosim.core.labels import Label
from mammosim.core.volume import Grid, LabelMap
from mammosim.imaging.overlap import dice

GRID = Grid((1, 1, 8), np.array([2.0, 1.0, 1.0]), np.zeros(3))


def _map(*labels: int) -> LabelMap:
    return LabelMap(GRID, np.array(labels, np.uint8).reshape(GRID.shape))


def test_dice_is_twice_the_common_part_over_the_sum() -> None:
    frame = dice(_map(0, 1, 1, 1, 2, 2, 5, 5), _map(0, 0, 1, 1, 1, 2, 5, 5)).set_index("tissue")
    assert frame.dice["adipose"] == pytest.approx(2 * 2 / (3 + 3))
    assert frame.dice["glandular"] == pytest.approx(2 * 1 / (2 + 1))
    assert frame.dice["deformable"] == pytest.approx(2 * 4 / (5 + 4))
    assert frame.dice["thorax"] == 1.0
    assert (frame.volume_mm3["glandular"], frame.truth_volume_mm3["glandular"]) == (4.0, 2.0)


def test_a_marker_is_air_to_a_reconstruction() -> None:
    frame = dice(_map(0, 0, 1, 1, 1, 1, 1, 1), _map(0, Label.MARKER, 1, 1, 1, 1, 1, 1)).set_index("tissue")
    assert frame.dice["air"] == 1.0
    assert "marker" not in frame.index


def test_maps_of_different_images_are_not_compared() -> None:
    other = LabelMap(Grid((1, 1, 8), np.ones(3), np.zeros(3)), np.zeros((1, 1, 8), np.uint8))
    with pytest.raises(SegmentationError, match="compare maps of one image"):
        dice(_map(*[0] * 8), other)
