"""Detector, exposure and observer: signal, noise and contrast."""

import numpy as np
import pytest

from mammosim.core.errors import XrayError
from mammosim.core.rng import generator
from mammosim.core.volume import grid_around
from mammosim.xray.attenuation import material
from mammosim.xray.detector import Scatter, expose, on_pixels
from mammosim.xray.exposure import automatic_mas
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.observer import cnr
from mammosim.xray.phantom import Phantom
from mammosim.xray.projector import Primary, primary
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.transport import Accuracy, transport

X, Y, _ = np.eye(3)
BEAM = Spectrum(np.array([15.0, 25.0]), np.array([1e5, 1e5]), 600.0)


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
