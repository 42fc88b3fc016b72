"""Axes are turned as ITK turns them, whichever way a scanner's slices run; no voxel leaves its place."""

from itertools import permutations, product

import numpy as np
import pytest

from mammosim.core.rigid import rotation
from mammosim.core.volume import Grid
from mammosim.io.images import image_of, itk_volume
from mammosim.io.orientation import rising

SHAPE, SPACING, ORIGIN = (3, 4, 5), np.array([1.5, 2.0, 3.0]), np.array([10.0, -20.0, 30.0])
VALUES = np.arange(60, dtype=np.float32).reshape(SHAPE)


def _directions() -> list[np.ndarray]:
    """All right-handed arrangements of axes."""
    arranged = [
        np.eye(3)[:, order] * signs
        for order in permutations(range(3))
        for signs in product((1, -1), repeat=3)
    ]
    return [direction for direction in arranged if np.linalg.det(direction) > 0]


@pytest.mark.parametrize("tilt_deg", [(0.0, 0.0, 0.0), (20.0, -13.0, 31.0)])
def test_as_itk_does(tilt_deg: tuple[float, float, float]) -> None:
    for direction in _directions():
        grid = Grid(SHAPE, SPACING, ORIGIN, rotation(np.array(tilt_deg)) @ direction)
        found, values = rising(grid, VALUES)
        expected = image_of(itk_volume(grid, VALUES))
        assert found.same_as(expected.grid)
        np.testing.assert_array_equal(values, expected.values)


def test_every_voxel_stays_in_its_place() -> None:
    grid = Grid(SHAPE, SPACING, ORIGIN, _directions()[7])
    found, values = rising(grid, VALUES)
    where = {value: tuple(point) for value, point in zip(VALUES.ravel(), grid.centres().round(6))}
    for value, point in zip(values.ravel(), found.centres().round(6)):
        assert where[value] == pytest.approx(tuple(point))
    assert np.all(np.diag(found.direction) > 0)
