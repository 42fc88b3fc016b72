"""Without markers the rib cage alone is registered: it says how sure that is, and rejects what is not."""

from dataclasses import replace

import numpy as np
import pytest

from mammosim.core.errors import ImageError
from mammosim.core.rigid import IDENTITY, RigidTransform, rotation
from mammosim.core.volume import Image, grid_around
from mammosim.imaging import alignment
from mammosim.imaging.alignment import aligned_skins, evened, starts
from mammosim.imaging.certainty import PARTS, Certainty, PartsOfChest, part_numbers, parts_of_chest
from mammosim.imaging.outline import body_mask
from mammosim.imaging.registration import COLUMNS, register, rib_cage, transform_error
from mammosim.imaging.unmarked import Pair, coarse_chest, register_unmarked

MOTION = RigidTransform(rotation(np.array([-4.0, 6.0, 8.0])), np.array([15.0, -8.0, 12.0]))
NEAR = RigidTransform(rotation(np.array([0.3, -0.3, 0.4])), np.array([0.8, -0.6, 0.7]))


@pytest.fixture(scope="module")
def moving(render):
    """The chest at 4 mm, far from where it was."""
    return render(4.0, MOTION, seed=2)


@pytest.fixture(scope="module", autouse=True)
def few_turns():
    """Those near the turn of the skin, and one other: the whole grid takes seconds, and finds the same."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(alignment, "TURNS_DEG", (0.0,))
        yield


@pytest.fixture(scope="module")
def found(chest, moving, few_turns):
    """Its registration without markers."""
    return register_unmarked(chest.image, moving.image)


def test_a_chest_is_found_far_from_where_it_was_and_the_error_is_within_what_is_stated(found, moving):
    error = transform_error(found.refined, MOTION.inverse(), moving.chest)
    stated = found.table.iloc[-1]
    # A tenth of a voxel is what a smooth texture of this contrast-to-noise ratio fixes, see the other tests.
    assert error["max_mm"] < 0.4
    assert error["max_mm"] < stated.error_95_mm < 2.0
    assert error["rotation_deg"] < stated.error_95_deg < 1.0


def test_the_table_says_that_there_were_no_markers(found, chest, moving):
    assert tuple(found.table.columns) == COLUMNS
    assert found.table["step"].tolist() == ["surface", "image"]
    assert set(found.table.method) == {"rib cage"}
    assert found.table.marker_residual_mm.isna().all()
    assert found.table.error_95_mm.is_monotonic_decreasing
    assert found.table.used.tolist() == [False, True]
    marked = register(chest.image, moving.image, chest.chest, moving.chest).table
    assert tuple(marked.columns) == COLUMNS
    assert set(marked.method) == {"markers"}


def test_the_skin_alone_says_how_the_torso_lies(chest, moving):
    """All but its place along the torso, of which a cylinder's skin says nothing."""
    skin = aligned_skins(coarse_chest(chest.image), coarse_chest(moving.image))
    axis = np.array([0.0, 0.0, 1.0])
    off = np.degrees(np.arccos(np.clip(axis @ skin.R @ MOTION.R @ axis, -1, 1)))
    assert off < 2.0 < MOTION.angle_deg


def test_starts_are_ordered_and_apart(chest, moving, monkeypatch):
    monkeypatch.setattr(alignment, "TURNS_DEG", (-20.0, 20.0))
    fixed, other = coarse_chest(chest.image), coarse_chest(moving.image)
    first, second, *_ = found = starts(fixed, other)
    assert [start.correlation for start in found] == sorted((s.correlation for s in found), reverse=True)
    places = [start.motion(other.middle[None])[0] for start in (first, second)]
    assert np.linalg.norm(places[0] - places[1]) > 20.0
    assert np.linalg.norm(places[0] - MOTION.inverse()(other.middle[None])[0]) < 15.0


def test_where_the_skin_misleads_the_grid_of_turns_finds_the_chest(chest, moving, monkeypatch):
    fixed, other = coarse_chest(chest.image), coarse_chest(moving.image)
    away = RigidTransform(rotation(np.array([0.0, 0, 90])), np.zeros(3))
    monkeypatch.setattr(alignment, "aligned_skins", lambda fixed, moving: away)
    monkeypatch.setattr(alignment, "NEAR_TURNS_DEG", (0.0,))
    monkeypatch.setattr(alignment, "TURNS_DEG", (-10.0, 0.0, 10.0))
    best = starts(fixed, other)[0].motion
    assert np.linalg.norm(best(other.middle[None]) - MOTION.inverse()(other.middle[None])) < 15.0
    assert best.after(MOTION).angle_deg < 10.0


@pytest.mark.parametrize("what", ["noise", "layers", "another chest"])
def test_an_image_of_something_else_is_rejected_in_one_line(chest, what):
    grid, rng = chest.image.grid, np.random.default_rng(1)
    values = {
        "noise": np.where(body_mask(chest.image), rng.normal(500, 50, grid.shape), 10.0),
        "another chest": chest.image.values[:, :, ::-1],  # of the same outline
        "layers": np.where(body_mask(chest.image), 500.0, 10.0) + 5 * rng.normal(size=grid.shape),
    }[what]
    with pytest.raises(ImageError, match="the rib cages of the two images do not match: at best") as told:
        register_unmarked(chest.image, Image(grid, np.abs(values).astype(np.float32)))
    assert "\n" not in str(told.value)
    assert "list chest_1 to chest_4" in str(told.value)


def test_what_a_coil_does_is_taken_away(chest):
    """Brightness falls to a third from front to rear; evened, the rib cage looks as before."""
    grid, body, inside = chest.image.grid, body_mask(chest.image), rib_cage(chest.image).values == 1
    y = grid.centres().reshape(*grid.shape, 3)[..., 1]
    coil = np.exp(-(y - y.min()) / 160).astype(np.float32)
    dimmed = replace(chest.image, values=chest.image.values * coil)
    raw = np.corrcoef(chest.image.values[inside], dimmed.values[inside])[0, 1]
    even = np.corrcoef(*(evened(image, body).values[inside] for image in (chest.image, dimmed)))[0, 1]
    assert 1 - even < 0.2 * (1 - raw)


def test_noise_makes_it_less_sure(chest, render):
    stated = []
    for noise in (10.0, 80.0):
        noisy = render(4.0, NEAR, seed=5, noise=noise)
        _, parts, _ = Pair.of(chest.image, noisy.image).last_steps(IDENTITY)
        stated.append(parts.certainty.at(chest.chest).max())
    assert stated[1] > 2 * stated[0]


def test_errors_are_within_their_limits_as_often_as_stated():
    """Of texts of noise whose parts are independent, by 95 in 100, less what 60 tries can tell."""
    grid = grid_around(np.full(3, -36.0), np.full(3, 36.0), 4.0)
    x, y, z = grid.centres().reshape(*grid.shape, 3).transpose(3, 0, 1, 2)
    truth = (np.sin(x / 9) + np.cos(y / 8) * np.sin(z / 10)).astype(np.float32)
    rng, points = np.random.default_rng(3), np.array([[30.0, 0, 0], [0, -30, 20]])
    inside, tries, within = np.ones(grid.shape, bool), 60, 0
    for _ in range(tries):
        f, m = (Image(grid, truth + rng.normal(scale=0.3, size=grid.shape)) for _ in range(2))
        parts = parts_of_chest(f, m, inside)
        alone = replace(
            parts, g=parts.g - parts.A @ parts.theta
        )  # stepped: what is left is not counted twice
        off = np.linalg.norm(parts.step(points) - points, axis=1)
        within += bool(np.all(off <= alone.certainty.at(points)))
    # Binomial: 0.95 n, two standard deviations down; three of four parts of a limit are no limit.
    assert 0.95 * tries - 2 * np.sqrt(0.95 * 0.05 * tries) <= within


def test_the_limit_of_an_error_follows_from_the_covariance():
    """A turn of 1 mrad and no shift: at 100 mm from the middle 0.1 mm across, times Student's quantile."""
    covariance = np.zeros((6, 6))
    covariance[5, 5] = 1e-6
    sure = Certainty(covariance, np.array([1.0, 2.0, 3.0]), 8)
    limits = sure.at(np.array([[1.0, 2.0, 50.0], [101.0, 2.0, 3.0]]))
    np.testing.assert_allclose(limits, [0.0, 2.365 * 0.1], atol=1e-4)
    assert sure.turn_deg == pytest.approx(2.365 * np.degrees(1e-3), rel=1e-3)


def test_parts_hold_as_many_voxels_each():
    points = np.random.default_rng(1).uniform(0, [300, 100, 200], (12_000, 3))
    counts = np.bincount(part_numbers(points))
    assert len(counts) == np.prod(PARTS)
    assert counts.min() > 0.9 * len(points) / len(counts)


def test_layers_fix_no_motion():
    grid = grid_around(np.full(3, -36.0), np.full(3, 36.0), 4.0)
    layers = Image(grid, np.sin(grid.centres()[:, 2] / 9).reshape(grid.shape).astype(np.float32))
    with pytest.raises(ImageError, match="too little structure to fix a rigid motion; list chest_1"):
        parts_of_chest(layers, layers, np.ones(grid.shape, bool))


def test_parts_step_to_where_the_images_match(chest, render):
    pair = Pair.of(chest.image, render(4.0, NEAR, seed=2).image)
    parts = pair.parts(IDENTITY)
    assert isinstance(parts, PartsOfChest)
    before, after = (
        transform_error(m, NEAR.inverse(), chest.chest)["max_mm"] for m in (IDENTITY, parts.step)
    )
    assert after < before / 3


def test_of_parts_that_weigh_alike_the_covariance_is_that_of_their_mean():
    """The jackknife of a mean is s^2 / n; what is not yet stepped comes on top."""
    found = np.random.default_rng(5).normal(0.3, 1.0, (8, 6)) * ([1.0] * 3 + [0.01] * 3)
    A = np.diag([1.0] * 3 + [1e4] * 3)
    parts = PartsOfChest(np.tile(A, (8, 1, 1)), found @ A, np.array([5.0, -60.0, 20.0]), 1.0)
    mean = found.mean(axis=0)
    np.testing.assert_allclose(parts.theta, mean)
    np.testing.assert_allclose(parts.certainty.covariance, np.cov(found.T) / 8 + np.outer(mean, mean))
    np.testing.assert_allclose(parts.step(parts.middle[None])[0], parts.middle + mean[:3])


def test_an_error_of_shift_and_turn_together_is_that_of_the_motion_at_a_point():
    u, w, middle = np.array([1.0, 0.5, -0.2]), np.array([0.02, -0.01, 0.03]), np.array([5.0, -60.0, 20.0])
    sure = Certainty(np.outer([*u, *w], [*u, *w]), middle, 8)
    r = np.random.default_rng(6).normal(0, 50, (5, 3))
    share = sure.at(middle[None])[0] / np.linalg.norm(u)
    np.testing.assert_allclose(sure.at(middle + r), share * np.linalg.norm(u + np.cross(w, r), axis=1))
