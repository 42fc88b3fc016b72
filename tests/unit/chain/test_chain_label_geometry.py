"""Distances between pieces of a label map are in mm, whatever the voxels are like."""

import numpy as np
import pytest

from mammosim.chain.label_geometry import filled_in, is_outside, overhanging
from mammosim.core.labels import Label
from mammosim.core.volume import Grid, LabelMap


def labels(values: np.ndarray, spacing: tuple[float, float, float]) -> LabelMap:
    return LabelMap(Grid(values.shape, np.array(spacing), np.zeros(3)), values.astype(np.uint8))


@pytest.mark.parametrize(("inside", "expected"), [(1, True), (2, False)])
def test_a_mask_is_outside_where_half_of_it_touches_the_air(inside, expected):
    air, mask = np.zeros((2, 9, 9, 9), bool)
    air[:, 0] = True
    mask[4, 1, 4] = True
    mask[4, 5, 3 : 3 + 2 * inside : 2] = True
    assert is_outside(mask, air) == expected


def test_what_is_unknown_becomes_as_the_nearest_in_mm():
    values = np.full((3, 3, 3), Label.ADIPOSE)
    values[0, 1, 1] = values[2, 1, 1] = Label.GLANDULAR  # along z, whose steps are the shortest
    unknown = np.zeros(values.shape, bool)
    unknown[1, 1, 1] = True
    assert filled_in(labels(values, (5.0, 3.0, 1.0)), unknown).values[1, 1, 1] == Label.GLANDULAR


def test_a_rim_that_ends_in_front_of_what_is_within_15_mm_overhangs_and_a_dent_does_not():
    """Steps of 1 mm along x and 10 mm along z: 10 columns are within, 20 are not, and 1 along z is."""
    last = np.full((9, 60), 40)
    last[:, :5] = -1
    last[:, 5:15] = 5  # the rim
    last[:, 30:36] = 5  # a dent
    grid = labels(np.zeros((9, 50, 60)), (1.0, 1.0, 10.0))
    found = overhanging(last, grid)
    assert found[:, 5:15].all()
    assert not found[:, 15:].any()
    wide = last.copy()
    wide[:, 5:40] = 5
    assert not overhanging(wide, grid).any()
