"""Observers: d' in white and in coloured noise, and what its interval says."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from mammosim.core.errors import XrayError
from mammosim.core.rng import generator
from mammosim.xray.detectability import detectability, laguerre_gauss

SHAPE = (24, 24)
SIGNAL = 0.4 * laguerre_gauss(SHAPE, width_pixels=8.0, count=1)[0]


def images(rng: np.random.Generator, signal: np.ndarray, n: int) -> np.ndarray:
    """White noise of standard deviation one."""
    return signal + rng.standard_normal((n, *SHAPE))


def test_without_correlation_d_is_the_norm_of_the_signal_over_the_noise():
    """Both observers, since the signal is the first channel: within four standard deviations."""
    rng, truth = generator(1), float(np.linalg.norm(SIGNAL))
    pair = images(rng, SIGNAL, 400), images(rng, 0 * SIGNAL, 400)
    for channels in (SIGNAL[None], laguerre_gauss(SHAPE, width_pixels=8.0, count=5)):
        found = detectability(*pair, channels)
        assert found.low < found.d < found.high
        assert abs(found.d - truth) < 4 * (found.high - found.low) / 3.92


@pytest.mark.parametrize("count", [1, 4])
def test_the_interval_holds_the_truth_as_often_as_it_says(count):
    """90 percent of 100 experiments, with a standard deviation of 3. The mean of d'^2 is right, too."""
    rng, truth = generator(2, count), float(np.linalg.norm(SIGNAL))
    channels = laguerre_gauss(SHAPE, width_pixels=8.0, count=count)
    # in white noise of deviation one, orthogonal channels of norm |u| see white noise of deviation |u|
    norms = np.linalg.norm(channels.reshape(count, -1), axis=1)
    mean = channels.reshape(count, -1) @ SIGNAL.ravel()
    held, squares = 0, []
    for _ in range(100):
        seen = [
            (m + norms * rng.standard_normal((20, count))).reshape(20, 1, count) for m in (mean, 0 * mean)
        ]
        found = detectability(*seen, np.eye(count)[:, None, :], confidence=0.9)
        held += found.low <= truth <= found.high
        squares.append(found.d**2)
    assert abs(held - 90) < 3.5 * 3
    assert np.mean(squares) == pytest.approx(truth**2, abs=4 * np.std(squares) / np.sqrt(100))


def test_in_coloured_noise_channels_see_more_than_the_signal_alone():
    """Noise smoother than the signal: whitening by the covariance of the channels helps."""
    rng = generator(3)
    noise = np.array([gaussian_filter(x, 3, mode="wrap") for x in rng.standard_normal((800, *SHAPE))])
    pair = 0.2 * SIGNAL + noise[:400], noise[400:]
    plain, channelised = (
        detectability(*pair, c) for c in (SIGNAL[None], laguerre_gauss(SHAPE, width_pixels=8.0, count=6))
    )
    assert channelised.low > plain.high


def test_images_without_a_signal_have_an_interval_from_zero():
    rng = generator(4)
    found = detectability(images(rng, 0 * SIGNAL, 60), images(rng, 0 * SIGNAL, 60), SIGNAL[None])
    assert found.low == 0.0
    assert found.high < 0.8


def test_impossible_observers_are_rejected():
    few = np.zeros((2, *SHAPE))
    with pytest.raises(XrayError, match="too few"):
        detectability(few, few, laguerre_gauss(SHAPE, width_pixels=8.0, count=4))
    with pytest.raises(XrayError, match="do not match"):
        detectability(few, few[:, :5], SIGNAL[None])
    with pytest.raises(XrayError, match="at least one"):
        laguerre_gauss(SHAPE, width_pixels=8.0, count=0)
