"""The rigid motion between two images: exact from exact points, and better still from the rib cage."""

from itertools import permutations

import numpy as np
import pytest

from mammosim.core.errors import ConfigurationError, FiducialError, ImageError
from mammosim.core.rigid import IDENTITY, RigidTransform, rotation
from mammosim.core.volume import Grid, Image
from mammosim.imaging.registration import (
    Settings,
    icp,
    kabsch,
    match,
    register,
    resample,
    residual,
    rib_cage,
    transform_error,
)

MOTION = RigidTransform(rotation(np.array([3.0, -2.0, 2.5])), np.array([4.0, -5.0, 3.0]))
MARKERS = np.array([[0.0, -40, 75], [-65, -25, 70], [12, -45, 20], [80, -15, -75]])


def test_kabsch_recovers_an_exact_motion() -> None:
    found = kabsch(MARKERS, MOTION(MARKERS))
    np.testing.assert_allclose(found.R, MOTION.R, atol=1e-12)
    np.testing.assert_allclose(found.t, MOTION.t, atol=1e-10)


def test_a_mirror_image_is_no_rotation() -> None:
    mirrored = MARKERS * [-1.0, 1.0, 1.0]
    assert np.linalg.det(kabsch(MARKERS, mirrored).R) == pytest.approx(1.0)
    with pytest.raises(FiducialError, match="do not match: at best one is"):
        match(MARKERS, mirrored)


def test_the_order_of_the_markers_does_not_matter() -> None:
    for order in permutations(range(4)):
        found = match(MARKERS[list(order)], MOTION(MARKERS))
        np.testing.assert_allclose(found(MARKERS), MOTION(MARKERS), atol=1e-10)


def test_icp_ends_at_the_least_squares_motion() -> None:
    noisy = MOTION(MARKERS) + np.random.default_rng(1).normal(size=(4, 3))
    found, iterations = icp(MARKERS, noisy[::-1], IDENTITY)
    np.testing.assert_allclose(found(MARKERS), kabsch(MARKERS, noisy)(MARKERS), atol=1e-10)
    assert iterations <= 5


@pytest.mark.parametrize(
    ("markers", "message"),
    [
        (MARKERS[:3], "3 chest markers at"),
        (np.outer([0, 30, 60, 100], [1.0, 0.2, 0.1]), "collinear"),
        (
            MARKERS + np.array([[0, 0, 0], [0, 0, 0], [0, 0, 0], [60, 0, 50]]),
            r"the limits are 15 mm and a turn of 45",
        ),
    ],
)
def test_markers_that_fix_no_motion_are_rejected(markers: np.ndarray, message: str) -> None:
    with pytest.raises(FiducialError, match=message):
        match(markers, MARKERS)


def test_an_image_moves_with_its_points() -> None:
    grid = Grid((30, 30, 30), np.full(3, 2.0), np.full(3, -29.0))
    centre = np.array([4.0, -6.0, 3.0])
    values = np.exp(-np.sum((grid.centres() - centre) ** 2, axis=1) / (2 * 6.0**2)).reshape(grid.shape)
    shift = RigidTransform(rotation(np.array([0, 0, 20.0])), np.array([3.0, 2.0, -5.0]))
    w = resample(Image(grid, values.astype(np.float32)), shift, grid).values.ravel()
    # Linear interpolation keeps the centroid of a smooth blob; 0.1 mm for the part that leaves the grid.
    np.testing.assert_allclose(w @ grid.centres() / w.sum(), shift(centre[None])[0], atol=0.1)


def test_the_error_of_a_shift_is_its_length() -> None:
    shifted = RigidTransform(MOTION.R, MOTION.t + np.array([1.0, 2.0, 2.0]))
    error = transform_error(shifted, MOTION, MARKERS)
    assert error == pytest.approx({"mean_mm": 3.0, "max_mm": 3.0, "rotation_deg": 0.0}, abs=1e-5)


def test_the_rib_cage_holds_nothing_that_deforms(chest) -> None:
    inside = rib_cage(chest.image).values == 1
    assert inside.sum() > 0.7 * (chest.labels.values == 5).sum()
    assert np.all(chest.labels.values[inside] == 5)


def test_a_flat_image_has_no_rib_cage() -> None:
    grid = Grid((10, 10, 10), np.full(3, 4.0), np.zeros(3))
    with pytest.raises(ImageError, match="all voxels have the value 0"):
        rib_cage(Image(grid, np.zeros(grid.shape, np.float32)))


def test_the_image_refines_what_misplaced_markers_say(chest, render) -> None:
    moving = render(4.0, MOTION, seed=2)
    slipped = moving.chest + np.random.default_rng(1).normal(scale=2.0, size=(4, 3))
    found = register(chest.image, moving.image, chest.chest, slipped[::-1])
    true = MOTION.inverse()
    before, after = (
        transform_error(motion, true, moving.breast) for motion in (found.landmark, found.refined)
    )
    # A tenth of a voxel is what a smooth texture of this contrast-to-noise ratio fixes; 0.5 mm is an eighth.
    assert after["max_mm"] < 0.5 < before["max_mm"]
    assert after["rotation_deg"] < 0.25
    assert found.table["step"].tolist() == ["landmarks", "image"]
    assert found.table["used"].tolist() == [False, True]
    assert found.table["correlation"].is_monotonic_increasing


def test_an_image_that_shows_nothing_leaves_the_markers_in_charge(chest) -> None:
    noise = np.random.default_rng(1).normal(500, 50, chest.image.grid.shape).astype(np.float32)
    found = register(chest.image, Image(chest.image.grid, noise), chest.chest, MOTION(chest.chest))
    moved = residual(found.refined, MOTION(chest.chest), chest.chest)
    assert moved.max() <= 10.0
    used = found.table[found.table["used"]]
    assert used["correlation"].iloc[0] >= found.table["correlation"][0]


def test_registering_twice_gives_the_same_numbers(chest, render) -> None:
    moving = render(4.0, MOTION, seed=2)
    first, second = (register(chest.image, moving.image, chest.chest, moving.chest) for _ in range(2))
    np.testing.assert_array_equal(first.refined.R, second.refined.R)
    np.testing.assert_array_equal(first.refined.t, second.refined.t)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"smoothing_mm": ()}, "give at least one level"),
        ({"smoothing_mm": (-1.0, 0.0)}, "none below 0"),
        ({"voxel_mm": 0.0}, "voxel_mm = 0"),
        ({"samples": 10}, "samples = 10"),
        ({"iterations": 0}, "iterations = 0"),
    ],
)
def test_impossible_settings_are_rejected(wrong, words) -> None:
    with pytest.raises(ConfigurationError, match=words):
        Settings(**wrong)
