"""Where the midline of a measured body is, whose frame may begin anywhere."""

from dataclasses import replace

import numpy as np
import pytest

from mammosim.chain.breast import Breast
from mammosim.core.fiducials import Fiducials
from mammosim.core.labels import Label
from mammosim.core.rigid import IDENTITY, RigidTransform
from mammosim.core.volume import LabelMap, grid_around


def breast(side: str, first: float, last: float, **nipples_x: float) -> Breast:
    """A body from x = first to last mm, with nipples at these x."""
    grid = grid_around(np.array([first, 0.0, 0.0]), np.array([last, 20.0, 20.0]), 10.0)
    labels = LabelMap(grid, np.full(grid.shape, Label.ADIPOSE, np.uint8))
    points = np.array([[x, 0.0, 0.0] for x in nipples_x.values()]).reshape(-1, 3)
    names = tuple(f"nipple_{name}" for name in nipples_x)
    listed = Fiducials(names, ("nipple",) * len(names), points)
    return Breast(labels, listed, IDENTITY, np.array([0.0, -1.0, 0.0]), side)


@pytest.mark.parametrize(
    ("midline", "given"),
    [
        (0.0, breast("left", -170, 190, left=90.0, right=-70.0)),  # a scan, 10 mm off
        (170.0, breast("left", 0, 340, left=250.0, right=90.0)),  # a map whose first voxel is the origin
        (0.0, breast("left", -170, 190, left=90.0)),
        (170.0, breast("left", 0, 340, left=250.0)),  # the other one is there, and was not marked
        (170.0, breast("right", 0, 340, right=90.0)),
        (-np.inf, breast("left", -40, 60, left=10.0)),  # a lone breast
        (-np.inf, breast("left", 0, 110, left=55.0)),
        (np.inf, breast("right", 0, 110, right=60.0)),
        (0.0, breast("left", -170, 190)),
    ],
)
def test_the_midline_is_between_two_breasts_unless_the_frame_begins_near_it(midline, given):
    assert given.midline_mm == midline


def test_the_midline_is_of_the_common_frame():
    moved = replace(
        breast("left", -170, 170, left=60.0, right=-60.0),
        to_reference=RigidTransform(np.eye(3), np.array([100.0, 0, 0])),
    )
    assert moved.midline_mm == 100.0
