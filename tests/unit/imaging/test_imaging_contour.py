"""The contour grows from its seeds where the tissue is likely, and its curvature decides the doubtful."""

import numpy as np

from mammosim.imaging.segmentation import grow, speed

Z, Y, X = np.indices((24, 24, 24)) - 11.5
BALL = Z**2 + Y**2 + X**2 < 8**2
EVERYWHERE = np.ones(BALL.shape, bool)
MIDDLE = np.zeros(BALL.shape, bool)
MIDDLE[12, 12, 12] = True


def test_speed_runs_from_inward_to_outward() -> None:
    np.testing.assert_array_equal(speed(np.array([0.0, 0.5, 1.0])), [-1, 0, 1])


def test_a_clear_object_is_found_exactly_without_smoothing() -> None:
    p = np.where(BALL, 0.8, 0.2)
    np.testing.assert_array_equal(grow(p, MIDDLE, within=EVERYWHERE, smoothing=0), BALL)


def test_a_contour_does_not_jump_to_an_object_without_seed() -> None:
    p = np.where(BALL, 0.8, 0.2)
    p[0:3, 0:3, 0:3] = 0.8
    assert not grow(p, MIDDLE, within=EVERYWHERE, smoothing=2)[0:3, 0:3, 0:3].any()


def test_what_is_nearly_certain_needs_no_stroke() -> None:
    p = np.where(BALL, 0.95, 0.2)
    np.testing.assert_array_equal(grow(p, ~EVERYWHERE, within=EVERYWHERE, smoothing=0), BALL)


def test_curvature_removes_speckle_of_doubtful_voxels() -> None:
    rng = np.random.default_rng(1)
    p = np.clip(np.where(BALL, 0.65, 0.35) + rng.normal(scale=0.2, size=BALL.shape), 0, 1)
    rough, smooth = (grow(p, MIDDLE, within=EVERYWHERE, smoothing=n) for n in (0, 3))
    assert np.count_nonzero(smooth != BALL) < 0.25 * np.count_nonzero(rough != BALL)


def test_a_contour_stays_within_its_region() -> None:
    half = X < 0
    found = grow(np.full(BALL.shape, 0.9), MIDDLE | (X == -0.5), within=half, smoothing=2)
    assert not found[~half].any()
