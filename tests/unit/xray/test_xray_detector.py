"""Detector, exposure and observer: signal, noise and contrast."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from mammosim.core.errors import XrayError
from mammosim.core.rng import generator
from mammosim.core.volume import grid_around
from mammosim.xray.attenuation import material
from mammosim.xray.detector import Scatter, expose, on_pixels
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.observer import cnr, detectability, laguerre_gauss
from mammosim.xray.phantom import Phantom
from mammosim.xray.projector import Primary, primary
from mammosim.xray.quality import automatic_mas
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.transport import Accuracy, transport

X, Y, _ = np.eye(3)
BEAM = Spectrum(np.array([15.0, 25.0]), np.array([1e5, 1e5]), 600.0)
SHAPE = (24, 24)
SIGNAL = 0.4 * laguerre_gauss(SHAPE, width_pixels=8.0, count=1)[0]


def flat(n: int = 200) -> Primary:
    """1000 photons of 20 keV per mm2 and mAs, everywhere."""
    ones = np.ones((n, n))
    return Primary(2e4 * ones, 4e5 * ones, 1e-3 * ones, 2e4 * ones)


def test_quantum_noise_of_one_energy_is_poisson_times_the_energy():
    shot = expose(flat(), None, mas=10.0, pixel_mm=0.5, rng=generator(1, "noise"))
    n = 1000 * 10 * 0.25  # photons per pixel
    counts = shot.image / 20
    assert counts.mean() == pytest.approx(n, abs=4 * np.sqrt(n / counts.size))
    # the sample variance of N Poisson numbers has relative standard error sqrt(2/N)
    assert np.mean((counts - n) ** 3) == pytest.approx(n, abs=4 * np.sqrt(15 * n**3 / counts.size))
    assert counts.var() == pytest.approx(n, rel=4 * np.sqrt(2 / counts.size))
    np.testing.assert_allclose(shot.noise, 20 * np.sqrt(n))


def test_few_photons_come_as_whole_numbers():
    counts = expose(flat(), None, mas=0.01, pixel_mm=0.5, rng=generator(1, "noise")).image / 20
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-9)
    assert counts.mean() == pytest.approx(2.5, abs=4 * np.sqrt(2.5 / counts.size))


def test_signal_to_noise_grows_with_the_root_of_mas():
    one, four = (expose(flat(), None, mas=mas, pixel_mm=0.5, rng=generator(1)) for mas in (1.0, 4.0))
    np.testing.assert_allclose(four.mean / four.noise, 2 * one.mean / one.noise)


def test_scatter_adds_to_signal_and_variance():
    ones = np.ones((200, 200))
    shot = expose(flat(), Scatter(1e4 * ones, 1.8e5 * ones), mas=1.0, pixel_mm=1.0, rng=generator(2))
    assert shot.mean[0, 0] == pytest.approx(3e4)
    assert shot.noise[0, 0] == pytest.approx(np.sqrt(5.8e5))
    assert shot.image.std() == pytest.approx(shot.noise[0, 0], rel=4 / np.sqrt(2 * 200**2))


def test_equal_streams_give_equal_images_and_no_photons_give_zero():
    a, b = (expose(flat(5), None, mas=1.0, pixel_mm=1.0, rng=generator(3)) for _ in range(2))
    np.testing.assert_array_equal(a.image, b.image)
    dark = Primary(*(np.zeros((2, 2)) for _ in range(4)))
    assert not expose(dark, None, mas=1.0, pixel_mm=1.0, rng=generator(3)).image.any()


def test_scatter_on_pixels_keeps_the_level_of_the_cells():
    geometry = Geometry(
        np.array([0, 0, 600.0]), Detector(np.array([-49.5, -49.5, 0.0]), X, Y, (100, 100), 1.0)
    )
    grid = grid_around(np.array([-60.0, -60.0, 10.0]), np.array([60.0, 60.0, 50.0]), 10.0)
    phantom = Phantom(grid, np.ones(grid.shape, np.uint8), (material("air"), material("adipose")))
    run = transport(phantom, geometry, BEAM, accuracy=Accuracy(1, 0.005), seed=1)
    cells, squared = run.per_mas(run.scatter), run.per_mas(run.scatter_squared)
    parts = (cells.value, squared.value)
    scatter = Scatter(*(on_pixels(part, run.detector, geometry.detector) for part in parts))
    middle = cells.value[2:8, 2:8].mean()
    assert scatter.signal[20:80, 20:80].mean() == pytest.approx(
        middle, rel=0.02
    )  # neighbours enter at the edges
    # photons have between 13 and 25 keV, so the mean of E^2 is between these times the mean of E
    q = scatter.signal_squared / scatter.signal
    assert 13 < q.min() < q.max() < 25
    assert 0.1 < middle / primary(phantom, geometry, BEAM).signal[50, 50] < 1.0


def test_automatic_exposure_brings_the_target_kerma_behind_the_densest_square():
    K = np.full((50, 50), 1e-3)
    K[20:30, 20:30] = 5e-4
    breast = np.ones(K.shape, bool)
    breast[:, 40:] = False
    assert automatic_mas(K, breast, target_mgy=0.05, sensor_pixels=6) == pytest.approx(0.05 / 5e-4)
    with pytest.raises(XrayError, match="make sensor_pixels smaller"):
        automatic_mas(K, breast, target_mgy=0.05, sensor_pixels=45)
    with pytest.raises(XrayError, match="target_mgy"):
        automatic_mas(K, breast, target_mgy=0.0, sensor_pixels=6)


def test_cnr_is_contrast_over_noise_with_its_standard_error():
    """Over repeated images, CNR is 3 within its standard error, and spreads by its standard error."""
    signal, background = np.zeros((40, 40), bool), np.zeros((40, 40), bool)
    signal[:10], background[20:] = True, True
    rng, found = generator(4), []
    for _ in range(300):
        image = rng.normal(100.0, 5.0, (40, 40)) + 15.0 * signal
        found.append(cnr(image, signal, background))
    values, errors = np.array([[f.cnr, f.standard_error] for f in found]).T
    assert values.mean() == pytest.approx(3.0, abs=4 * errors.mean() / np.sqrt(300))
    assert values.std() == pytest.approx(errors.mean(), rel=4 / np.sqrt(2 * 300))


def test_impossible_exposures_and_masks_are_rejected():
    with pytest.raises(XrayError, match="mas = 0"):
        expose(flat(3), None, mas=0, pixel_mm=1.0, rng=generator(1))
    with pytest.raises(XrayError, match="different pixels"):
        expose(flat(3), Scatter(np.ones((2, 2)), np.ones((2, 2))), mas=1, pixel_mm=1.0, rng=generator(1))
    image, mask = np.arange(16.0).reshape(4, 4), np.eye(4, dtype=bool)
    with pytest.raises(XrayError, match="overlap"):
        cnr(image, mask, mask)
    with pytest.raises(XrayError, match="at least 2"):
        cnr(image, ~mask, np.zeros((4, 4), bool))
    with pytest.raises(XrayError, match="flat"):
        cnr(np.ones((4, 4)), ~mask, mask)


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
