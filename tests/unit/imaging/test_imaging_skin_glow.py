"""What fades steadily from the skin inwards is no gland; what rises above it, or begins under fat, is."""

import numpy as np
import pytest

from mammosim.core.volume import Grid
from mammosim.imaging.skin_glow import skin_glow, skin_is_bright
from mammosim.imaging.unsupervised import outermost

SPACING_MM, GLAND = 1.5, 1.3
GRID = Grid((40, 30, 40), np.full(3, SPACING_MM), np.zeros(3), np.eye(3))
DEPTH = np.broadcast_to(((np.arange(30) + 0.5) * SPACING_MM)[:, None], GRID.shape).astype(np.float32)


def _gland(ratio: np.ndarray) -> np.ndarray:
    """What is brighter than fat and glow together, at least 3 mm under the skin."""
    where = DEPTH > 3
    return where & (ratio / skin_glow(ratio.astype(np.float32), where, DEPTH, GRID) > GLAND)


def test_a_bright_sheet_under_the_skin_is_no_gland_and_a_strand_through_it_is() -> None:
    k, _, i = np.indices(GRID.shape)
    strand = np.hypot(k - 20, i - 20) * SPACING_MM < 3
    sheet = DEPTH < 8
    found = _gland(np.where(strand, 2.6, np.where(sheet, 1.6, 1.0)))
    assert not found[sheet & ~strand].any()
    assert found[strand & (DEPTH > 3)].all()


def test_gland_that_begins_under_a_layer_of_fat_stays() -> None:
    ratio = np.where((DEPTH > 8) & (DEPTH < 20), 1.7, 1.0)
    np.testing.assert_array_equal(_gland(ratio), ratio > 1)


@pytest.mark.parametrize(("skin", "bright"), [(1.8, True), (1.1, False)])
def test_skin_is_bright_compared_with_what_is_deep(skin, bright) -> None:
    assert skin_is_bright(np.where(DEPTH < 9, skin, 1.0).ravel(), DEPTH.ravel()) == bright


def test_skin_covers_every_face_where_voxels_are_not_cubes() -> None:
    depth = np.array([0.0, 1.1, 1.6, 2.2, 3.2])
    np.testing.assert_array_equal(
        outermost(depth, np.array([1.6, 1.6, 1.1])), [False, True, True, False, False]
    )
    thick = outermost(np.array([0.9, 4.0]), np.array([0.9, 0.9, 4.0]))
    np.testing.assert_array_equal(thick, [True, False])
