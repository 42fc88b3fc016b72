"""Detector and noise: what is put into an image is what is measured on it."""

import numpy as np
import pytest

from mammosim.core.errors import XrayError
from mammosim.core.rng import generator
from mammosim.xray.attenuation import linear_attenuation, material
from mammosim.xray.detector import Scatter, expose, template_sum
from mammosim.xray.equipment import blur_of, electronic_noise_of, grid_of, heel, structure_of
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.imaging_steps import (
    Blur,
    ElectronicNoise,
    FocalSpot,
    Grid,
    Heel,
    QuantumNoise,
    Structure,
    poisson_at,
)
from mammosim.xray.measured import Curve, edge_transfer, noise_power
from mammosim.xray.projector import Primary
from mammosim.xray.response import Response, detector_row, response_of

PIXEL = 0.1
AIR = material("air")


def field(signal: np.ndarray, kev: float = 20.0) -> Primary:
    """Photons of one energy; signal (nv, nu) in keV/mm2 per mAs."""
    return Primary(signal, kev * signal, 1e-7 * signal, signal)


def flat(shape: tuple[int, int] = (192, 192)) -> Primary:
    """4000 photons of 20 keV per mm2 and mAs."""
    return field(np.full(shape, 8e4))


def shots(primary: Primary, steps: tuple, count: int) -> list:
    return [
        expose(primary, None, mas=10.0, pixel_mm=PIXEL, rng=generator(7, n), steps=steps)
        for n in range(count)
    ]


def chi2(measured: Curve, expected: np.ndarray) -> float:
    """Mean square deviation in standard errors; one, with a spread of sqrt(2/n) for n values."""
    return float(np.mean(((measured.value - expected) / measured.error) ** 2))


STEPS = {
    "none": (),
    "quanta": (QuantumNoise(),),
    "quanta, gaussian": (QuantumNoise(), Blur("gaussian", 6.0)),
    "quanta, lorentzian, electronic": (ElectronicNoise(120.0), Blur("lorentzian", 4.3), QuantumNoise()),
}


@pytest.mark.parametrize("name", [name for name in STEPS if name != "none"])
def test_noise_power_is_that_of_quanta_through_the_blur_and_of_electronics(name):
    """NPS = N q^2 A T(f)^2 + sigma^2 A for N photons of q in a pixel of area A, in whatever order."""
    steps = STEPS[name]
    found = shots(flat(), steps, 6)
    power = noise_power([s.image for s in found], found[0].mean, pixel_mm=PIXEL)
    # squares without a taper leak from low to high frequencies, above its error only next to the limit
    below = power.f < 0.85 / (2 * PIXEL)
    power = Curve(power.f[below], power.value[below], power.error[below])
    N, A = 4000 * 10 * PIXEL**2, PIXEL**2
    T = next((e.transfer(power.f) for e in steps if isinstance(e, Blur)), 1.0)
    sigma = next((e.kev for e in steps if isinstance(e, ElectronicNoise)), 0.0)
    n = len(power.f)
    # rings are wide: T^2 varies within one by less than its errors of 2 percent
    assert chi2(power, N * 20**2 * A * T**2 + sigma**2 * A) < 1 + 5 * np.sqrt(2 / n)
    assert np.mean([s.image.var() for s in found]) == pytest.approx(np.mean(found[0].noise ** 2), rel=0.02)


def test_gains_of_a_detectors_own_pixels_average_out_over_a_larger_pixel():
    own = structure_of("selenium", 0.01, 0.085, seed=1)
    assert own.share == pytest.approx(0.01 * detector_row("selenium")["own_pixel_mm"] / 0.085)
    assert structure_of("selenium", 0.01, 0.85, seed=1).share == pytest.approx(own.share / 10)


def test_structure_is_the_same_in_every_image_and_quanta_are_not():
    """Half the variance of a difference is quanta alone; the gains of pixels go with it."""
    steps = (QuantumNoise(), Structure(0.05, seed=3))
    a, b = (s.image for s in shots(flat(), steps, 2))
    N = 4000 * 10 * PIXEL**2
    assert np.var(a - b) / 2 == pytest.approx(N * 20**2 * (1 + 0.05**2), rel=4 * np.sqrt(2 / a.size))
    expected = N * 20**2 + (0.05 * N * 20) ** 2
    assert np.var((a + b) / 2) == pytest.approx(expected - N * 20**2 / 2, rel=4 * np.sqrt(2 / a.size))


def edge(slope: float, shape: tuple[int, int]) -> Primary:
    """Half the photons beyond x = middle + slope y, exactly averaged over each pixel in x."""
    x = np.arange(shape[1]) - (shape[1] - 1) / 2 - slope * (np.arange(shape[0])[:, None] - (shape[0] - 1) / 2)
    rows = np.linspace(-0.5, 0.5, 33)[:-1] + 1 / 64
    share = np.mean([np.clip(x - slope * r + 0.5, 0, 1) for r in rows], axis=0)
    return field(8e6 * (1 - 0.5 * share))


@pytest.mark.parametrize("blur", [None, Blur("gaussian", 6.0), Blur("lorentzian", 4.3)])
def test_the_transfer_of_an_edge_is_the_pixels_times_the_blur(blur):
    """Within 3.5 standard errors, and 0.005 for the finite profile, where a lorentzian has not died out."""
    steps = (QuantumNoise(),) if blur is None else (QuantumNoise(), blur)
    images = [s.image for s in shots(edge(0.05, (160, 128)), steps, 8)]
    found = edge_transfer(images, slope=0.05, pixel_mm=PIXEL)
    expected = np.sinc(found.f * PIXEL) * (1.0 if blur is None else blur.transfer(found.f))
    assert np.all(np.abs(found.value - expected) < 3.5 * found.error + 0.005)
    assert found.error.max() < 0.02


WITH_ALL = (QuantumNoise(), Blur("lorentzian", 4.3), Structure(0.05, seed=3), ElectronicNoise(60.0))


@pytest.mark.parametrize("steps", [*STEPS.values(), WITH_ALL])
def test_mean_and_variance_of_a_weighted_sum_are_those_of_many_images(steps):
    """Within four standard errors, of 800 images: sigma/sqrt(n) and sigma^2 sqrt(2/n)."""
    rng, shape, n = generator(5), (24, 32), 800
    body, w = field(8e4 * (1 + rng.random(shape))), rng.standard_normal(shape)
    sums = np.array([np.sum(w * s.image) for s in shots(body, steps, n)])
    mean, variance = template_sum(w, body, None, mas=10.0, pixel_mm=PIXEL, steps=steps)
    assert abs(sums.mean() - mean) <= 4 * np.sqrt(variance / n) + 1e-9 * abs(mean)
    assert abs(sums.var(ddof=1) - variance) <= 4 * variance * np.sqrt(2 / n) + 1e-12 * mean**2


@pytest.mark.parametrize("mean", [0.0, 0.3, 4.0, 29.9, 30.0, 200.0, 1e4])
def test_numbers_at_the_quantiles_of_a_normal_are_poisson(mean):
    """Mean, variance and third moment are all lambda, within four standard errors.

    The expansion leaves 0.34 % of the third moment at 30, by Gauss-Hermite quadrature, and less above.
    """
    z = generator(6, str(mean)).standard_normal(400_000)
    n = poisson_at(z, np.full(z.shape, mean))
    root, off = np.sqrt(len(z)), n - mean
    assert abs(off.mean()) <= 4 * np.sqrt(mean) / root
    assert abs(np.mean(off**2) - mean) <= 4 * np.sqrt(mean + 2 * mean**2) / root
    if mean < 1e3:
        third = np.sqrt(np.var(off**3)) / root
        assert abs(np.mean(off**3) - mean) <= 4 * third + 0.0035 * mean


def test_images_of_one_stream_differ_by_what_their_bodies_do():
    """3e-4 more photons in a mean m add 3e-4 (m + z m^(1/2) / 2), to second order in m^(-1/2)."""
    few, more = (
        expose(field(np.full((64, 64), s)), None, mas=1.0, pixel_mm=PIXEL, rng=generator(7))
        for s in (8e4, 8e4 * (1 + 3e-4))
    )
    np.testing.assert_allclose(more.image - few.image, 3e-4 * (few.image + few.mean) / 2, rtol=0.05)
    without, with_it = (
        expose(flat((64, 64)), None, mas=1.0, pixel_mm=PIXEL, rng=generator(7), steps=e)
        for e in ((QuantumNoise(),), (QuantumNoise(), ElectronicNoise(1e-3)))
    )
    np.testing.assert_allclose(with_it.image, without.image, atol=1e-2)


@pytest.mark.parametrize("name", list(STEPS))
def test_the_mean_of_images_is_the_mean_and_without_noise_they_are_it(name):
    found = shots(flat((64, 64)), STEPS[name], 2)
    np.testing.assert_allclose(found[0].mean, 8e4 * 10 * PIXEL**2, rtol=1e-9)
    if name == "none":
        np.testing.assert_array_equal(found[0].image, found[0].mean)
        assert not found[0].noise.any()


def test_a_grid_lowers_scatter_more_than_primary():
    """Selectivity: scatter to primary falls by Ts/Tp; the Bucky factor of primary alone is 1/Tp."""
    grid, ones = grid_of("siemens_prototype"), np.ones((8, 8))
    scatter = Scatter(4e4 * ones, 7e5 * ones)
    bare, through = (
        expose(flat((8, 8)), scatter, mas=1.0, pixel_mm=1.0, rng=generator(1), steps=e) for e in ((), (grid,))
    )
    np.testing.assert_allclose(bare.mean, 12e4)
    np.testing.assert_allclose(through.mean, 0.73 * 8e4 + 0.13 * 4e4)


def test_a_focal_spot_blurs_by_its_size_times_magnification_less_one():
    """The variance of a point's image is (fwhm (M - 1))^2 / (8 ln 2), for a spot much wider than a pixel."""
    point = np.zeros((81, 81))
    point[40, 40] = 1e6
    spot = FocalSpot(0.3, 2.0)
    (image,) = (s.mean for s in shots(field(point), (spot,), 1))
    x = PIXEL * (np.arange(81) - 40)
    assert image.sum() == pytest.approx(1e6 * 10 * PIXEL**2)
    assert image.sum(axis=0) @ x**2 / image.sum() == pytest.approx(0.09 / (8 * np.log(2)), rel=0.02)
    in_contact, without = (shots(field(point), e, 1)[0].mean for e in ((FocalSpot(0.3, 1.0),), ()))
    np.testing.assert_array_equal(in_contact, without)


def test_the_heel_takes_from_the_anodes_side_and_leaves_the_chest_wall():
    d = Detector(np.array([0.0, 0.5, 0.0]), np.array([1.0, 0, 0]), np.array([0, 1.0, 0]), (200, 3), 1.0)
    geometry = Geometry(np.array([0.0, 0.0, 650.0]), d)
    factor = heel(geometry, ("W", "Rh", 0.05, 28.0)).factor
    assert factor.shape == (200, 3)
    assert factor[0, 0] == pytest.approx(1.0, abs=0.002)
    assert np.all(np.diff(factor[:, 0]) < 0)
    assert 0.6 < factor[-1, 0] < 0.95
    with pytest.raises(XrayError, match="make chest_angle_deg larger"):
        heel(geometry, ("W", "Rh", 0.05, 28.0), chest_angle_deg=15.0)
    image = expose(
        field(np.ones((200, 3))), None, mas=1.0, pixel_mm=1.0, rng=generator(1), steps=(Heel(factor),)
    )
    np.testing.assert_allclose(image.mean, factor)


def test_a_thick_layer_absorbs_every_photon_and_below_the_edge_all_energy():
    thick, E = Response(material("selenium"), 4.0, AIR), np.array([8.0, 12.0])
    first, second = thick.moments(E)
    np.testing.assert_allclose(first, E, rtol=1e-6)
    np.testing.assert_allclose(second, E**2, rtol=1e-6)


def test_fluorescence_escapes_above_the_edge_and_adds_noise():
    """Swank factor <q>^2/(eta <q^2>) below one; of a deep layer one side lets out less than half."""
    deep = Response(material("selenium"), 4.0, AIR)
    E = np.array([13.0, 20.0, 30.0])
    first, second = deep.moments(E)
    escape = (E - first) / 11.4  # mean energy of the lines
    assert np.all((escape > 0) & (escape < 0.5 * 0.8616 * 0.6019))
    assert np.all(np.diff(escape) < 0)
    assert np.all(first**2 / second < 1)


def test_the_layers_of_the_table_have_the_free_paths_of_their_source():
    """VICTRE: 0.04027 mm in selenium, 19.616 mm in polystyrene at 19 keV; other tables: within 1 percent."""
    E = np.array([19.0])
    mu = {name: linear_attenuation(material(name), E)[0] for name in ("selenium", "polystyrene")}
    assert 1 / mu["selenium"] == pytest.approx(0.04027, rel=0.01)
    assert 1 / mu["polystyrene"] == pytest.approx(19.616, rel=0.01)
    assert response_of("selenium").absorption(E)[0] == pytest.approx(
        np.exp(-1 / 19.616) * (1 - np.exp(-0.2 / 0.04027)), rel=0.01
    )


def test_the_blur_of_caesium_iodide_is_that_measured():
    """Whole transfer of pixels of 0.1 mm: 0.73, 0.42, 0.28 at 2, 4, 5/mm; one parameter fits to 0.03."""
    blur = blur_of("caesium_iodide")
    f = np.array([2.0, 4.0, 5.0])
    np.testing.assert_allclose(blur.transfer(f) * np.sinc(0.1 * f), [0.73, 0.42, 0.28], atol=0.03)


def test_scatter_leaves_in_a_detector_what_photons_of_its_mean_energy_leave():
    layer, ones = Response(material("water"), 3.0, AIR), np.ones((2, 2))
    left = Scatter(20.0 * ones, 400.0 * ones).left_in(layer)
    first, second = layer.moments(np.array([20.0]))
    np.testing.assert_allclose(left.signal, first[0])
    np.testing.assert_allclose(left.signal_squared, second[0])


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: FocalSpot(-0.3, 1.5), "usual are 0.1 to 0.4"),
        (lambda: Grid(0.7, 0.0), "grid passes shares"),
        (lambda: grid_of("none"), "siemens_prototype"),
        (lambda: Blur("box", 5.0), "gaussian or lorentzian"),
        (lambda: response_of("film"), "choose one of: selenium"),
        (lambda: Response(material("selenium"), 200.0, AIR), "give mm"),
        (lambda: Response(material("selenium"), 0.2, AIR, swank=0.0), "swank"),
        (lambda: noise_power([np.ones((8, 8))], np.ones((8, 8)), pixel_mm=0.1), "make side smaller"),
        (lambda: edge_transfer([np.ones((8, 8))], slope=0.1, pixel_mm=0.1), "two images or more"),
    ],
)
def test_impossible_steps_are_rejected(make, word):
    with pytest.raises(XrayError, match=word):
        make()


def test_electronic_noise_of_a_larger_pixel_is_that_of_its_parts():
    """Four independent pixels have twice the noise of one; 5200 electrons of 50 eV are 260 keV."""
    one, four = (electronic_noise_of("selenium", size).kev for size in (0.085, 0.17))
    assert one == pytest.approx(260.0)
    assert four == pytest.approx(2 * one)


def test_electronic_noise_that_is_not_known_is_rejected():
    with pytest.raises(XrayError, match="not known; leave this step out"):
        electronic_noise_of("caesium_iodide", 0.1)
