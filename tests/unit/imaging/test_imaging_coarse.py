"""Fewer voxels keep the place and the mean of what they show."""

import numpy as np

from mammosim.core.rigid import rotation
from mammosim.core.volume import Grid, Image
from mammosim.imaging.outline import block, coarsened, spread, spread_linearly

FINE = Grid((6, 9, 8), np.array([0.5, 0.5, 0.6]), np.array([3.0, -4, 5]), rotation(np.array([1.0, 2, 3])))
VALUES = np.random.default_rng(1).normal(size=FINE.shape).astype(np.float32)


def test_blocks_have_about_the_asked_size() -> None:
    assert block(FINE, 1.5).tolist() == [2, 3, 3]
    assert block(Grid((2, 2, 2), np.array([0.8, 1.0, 2.0]), np.zeros(3)), 1.5).tolist() == [1, 1, 2]


def test_the_mean_of_whole_blocks_is_kept() -> None:
    fine = Image(
        Grid((6, 9, 9), FINE.spacing, FINE.origin, FINE.direction), np.pad(VALUES, [(0, 0)] * 2 + [(0, 1)])
    )
    coarse = coarsened(fine, 1.5)
    assert coarse.grid.shape == (3, 3, 3)
    np.testing.assert_allclose(coarse.values.mean(), fine.values.mean(), atol=1e-6)


def test_a_linear_image_stays_in_its_place() -> None:
    normal = np.array([1.0, -2.0, 0.5])
    fine = Image(FINE, (FINE.centres() @ normal).reshape(FINE.shape))
    coarse = coarsened(fine, 1.5)
    expected = (coarse.grid.centres() @ normal).reshape(coarse.grid.shape)
    # The last block in x holds two voxels of three and the repeated border: it has no mean of its own.
    np.testing.assert_allclose(coarse.values[..., :-1], expected[..., :-1], rtol=1e-5)


def test_every_fine_voxel_gets_the_value_of_its_block() -> None:
    coarse = coarsened(Image(FINE, VALUES), 1.5)
    back = spread(coarse.values, FINE, 1.5)
    assert back.shape == FINE.shape
    assert np.all(back[2:4, 3:6, 3:6] == coarse.values[1, 1, 1])


def test_a_linear_field_is_carried_back_to_the_fine_voxels_between_the_middles_of_blocks() -> None:
    normal = np.array([1.0, -2.0, 0.5])
    exact = (FINE.centres() @ normal).reshape(FINE.shape)
    coarse = coarsened(Image(FINE, exact), 1.5)
    field = (coarse.grid.centres() @ normal).reshape(coarse.grid.shape).astype(np.float32)
    back = spread_linearly(field, FINE, 1.5)
    np.testing.assert_allclose(back[1:-1, 1:-1, 1:-1], exact[1:-1, 1:-1, 1:-1], rtol=1e-5)
    np.testing.assert_array_equal(back[0, 0, 0], field[0, 0, 0])  # before the first middle, as there


def test_an_image_that_is_coarse_already_is_not_touched() -> None:
    image = Image(FINE, VALUES)
    assert coarsened(image, 0.5) is image
