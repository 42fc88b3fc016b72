"""Where the midline of a measured body is, whose frame may begin anywhere."""

from dataclasses import replace

import numpy as np
import pytest

from mammosim.chain.breast import Breast
from mammosim.core.fiducials import Fiducials
from mammosim.core.labels import Label
from mammosim.core.rigid import IDENTITY, RigidTransform
from mammosim.core.volume import LabelMap, grid_around

GRID = grid_around(np.zeros(3), np.ones(3), 1.0)
LABELS = LabelMap(GRID, np.full(GRID.shape, Label.ADIPOSE, np.uint8))


def breast(side: str, **nipples_x: float) -> Breast:
    """A breast with nipples at these x."""
    points = np.array([[x, 0.0, 0.0] for x in nipples_x.values()]).reshape(-1, 3)
    names = tuple(f"nipple_{name}" for name in nipples_x)
    listed = Fiducials(names, ("nipple",) * len(names), points)
    return Breast(LABELS, listed, IDENTITY, np.array([0.0, -1.0, 0.0]), side)


@pytest.mark.parametrize(
    ("midline", "given"),
    [
        (0.0, breast("left", left=90.0, right=-70.0)),  # a scan, 10 mm off
        (170.0, breast("left", left=250.0, right=90.0)),  # a map whose first voxel is the origin
        (0.0, breast("left", left=55.0)),
        (-np.inf, breast("left", left=10.0)),
        (np.inf, breast("right", right=60.0)),
        (0.0, breast("left")),
    ],
)
def test_the_midline_is_between_the_nipples_unless_the_frame_begins_near_it(midline, given):
    assert given.midline_mm == midline


def test_the_midline_is_of_the_common_frame():
    moved = replace(
        breast("left", left=60.0, right=-60.0),
        to_reference=RigidTransform(np.eye(3), np.array([100.0, 0, 0])),
    )
    assert moved.midline_mm == 100.0
