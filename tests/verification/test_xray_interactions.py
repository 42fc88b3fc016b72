"""Single interactions and free paths against closed forms and the cross-sections they come from."""

import numpy as np
import pytest
from numba import njit
from scipy.integrate import quad

from mammosim.xray.attenuation import linear_attenuation, material
from mammosim.xray.interactions import (
    ELECTRON_REST_KEV,
    HC_KEV_ANGSTROM,
    coherent,
    incoherent,
    matter,
    turned,
)
from mammosim.xray.random_stream import random_stream, uniform

ELECTRON_RADIUS_MM = 2.8179403205e-12  # CODATA 2022
AVOGADRO = 6.02214076e23
N = 200_000


@njit
def sampled_incoherent(energy, S, x_step, n, seed):
    state, cos, scattered = random_stream(seed, 0), np.empty(n), np.empty(n)
    for i in range(n):
        scattered[i], cos[i] = incoherent(energy, 0, S, x_step, state)
    return scattered, cos


@njit
def sampled_coherent(energy, area, x_step, n, seed):
    state, cos = random_stream(seed, 0), np.empty(n)
    for i in range(n):
        cos[i] = coherent(energy, 0, area, x_step, state)
    return cos


@njit
def sampled_turn(dx, dy, dz, cos, n, seed):
    state, turns = random_stream(seed, 0), np.empty((n, 3))
    for i in range(n):
        turns[i] = turned(dx, dy, dz, cos, state)
    return turns


@njit
def sampled_uniform(n, seed, block):
    state, u = random_stream(seed, block), np.empty(n)
    for i in range(n):
        u[i] = uniform(state)
    return u


def klein_nishina(cos: float, energy: float) -> float:
    """k^2 (k + 1/k - sin^2)."""
    k = 1 / (1 + energy / ELECTRON_REST_KEV * (1 - cos))
    return k**2 * (k + 1 / k - (1 - cos**2))


def klein_nishina_total(energy: float) -> float:
    """Closed form of the integral of k^2 (k + 1/k - sin^2) over cos, from -1 to 1."""
    a = energy / ELECTRON_REST_KEV
    log = np.log(1 + 2 * a)
    first = (1 + a) / a**2 * (2 * (1 + a) / (1 + 2 * a) - log / a)
    return 2 * (first + log / (2 * a) - (1 + 3 * a) / (1 + 2 * a) ** 2)


def require_chi_square(sample: np.ndarray, density, bins: int = 20) -> None:
    """Counts in even bins of cos follow a density: chi-square of 19 is below 43.8 with probability 0.999."""
    edges = np.linspace(-1, 1, bins + 1)
    middle = (np.linspace(-1, 1, 100 * bins + 1)[1:] + np.linspace(-1, 1, 100 * bins + 1)[:-1]) / 2
    p = np.array([density(c) for c in middle]).reshape(bins, 100).sum(axis=1)
    expected = p / p.sum() * sample.size
    counts, _ = np.histogram(sample, edges)
    assert np.sum((counts - expected) ** 2 / expected) < 43.8


@pytest.mark.parametrize("energy", [10.0, 20.0, 40.0])
def test_klein_nishina_total_is_its_closed_form(energy):
    total = quad(klein_nishina, -1, 1, args=(energy,))[0]
    assert total == pytest.approx(klein_nishina_total(energy), rel=1e-8)


def test_free_electrons_scatter_by_klein_nishina():
    S = np.ones((1, 1024))  # every electron free at every momentum
    E, (scattered, cos) = 30.0, sampled_incoherent(30.0, S, 40.0 / HC_KEV_ANGSTROM / 1023, N, 1)
    require_chi_square(cos, lambda c: klein_nishina(c, E))
    np.testing.assert_allclose(scattered, E / (1 + E / ELECTRON_REST_KEV * (1 - cos)), rtol=1e-12)


@pytest.mark.parametrize("energy", [10.0, 16.8, 30.0])
@pytest.mark.parametrize("name", ["adipose", "glandular"])
def test_bound_electrons_scatter_by_the_scattering_function(name, energy):
    tables = matter((material(name),), 40.0)
    _, cos = sampled_incoherent(energy, tables.S, tables.x_step, N, 2)
    x = tables.x_step * np.arange(tables.S.shape[1])

    def density(c: float) -> float:
        return klein_nishina(c, energy) * np.interp(momentum(energy, c), x, tables.S[0])

    require_chi_square(cos, density)


@pytest.mark.parametrize("energy", [10.0, 16.8, 30.0])
@pytest.mark.parametrize("name", ["adipose", "glandular"])
def test_atoms_scatter_coherently_by_the_form_factor(name, energy):
    tables = matter((material(name),), 40.0)
    cos = sampled_coherent(energy, tables.area, tables.x_step, N, 3)
    x2 = (tables.x_step * np.arange(tables.area.shape[1])) ** 2
    F2 = np.diff(tables.area[0]) / np.diff(x2)

    def density(c: float) -> float:
        return (1 + c**2) * np.interp(momentum(energy, c) ** 2, (x2[1:] + x2[:-1]) / 2, F2)

    require_chi_square(cos, density)


@pytest.mark.parametrize("name", ["adipose", "glandular", "water", "pmma", "air"])
@pytest.mark.parametrize("energy", [15.0, 20.0, 30.0])
def test_scattering_tables_integrate_to_the_cross_sections(name, energy):
    """mu/rho = pi r_e^2 N_A int f(cos) dcos, within 1 percent: both are evaluations of the same theory."""
    found = material(name)
    tables = matter((found,), 40.0)
    x = tables.x_step * np.arange(tables.S.shape[1])
    F2 = np.diff(tables.area[0]) / np.diff(x**2)
    cos = np.linspace(-1, 1, 4001)
    middle = (x[1:] + x[:-1]) / 2
    scattered = klein_nishina(cos, energy) * np.interp(momentum(energy, cos), x, tables.S[0])
    whole = (1 + cos**2) * np.interp(momentum(energy, cos), middle, F2)
    per_mm = np.pi * ELECTRON_RADIUS_MM**2 * AVOGADRO * found.density_g_cm3 / 1e3
    E = np.array([energy])
    for values, process in ((scattered, "incoherent"), (whole, "coherent")):
        mu = linear_attenuation(found, E, process=process)[0]
        assert per_mm * np.trapezoid(values, cos) == pytest.approx(mu, rel=0.01)


def test_turning_keeps_length_and_angle_and_takes_every_azimuth():
    d, cos = np.array([0.48, -0.6, 0.64]), 0.3
    turns = sampled_turn(*d, cos, N, 4)
    np.testing.assert_allclose(np.linalg.norm(turns, axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(turns @ d, cos, rtol=1e-11)
    # the part across d has mean 0 with standard error sin/sqrt(2 n) per axis in its plane
    across = turns - cos * d
    assert np.linalg.norm(across.mean(axis=0)) < 4 * np.sqrt((1 - cos**2) / N)


@pytest.mark.parametrize("dz", [1.0, -1.0])
def test_turning_is_exact_along_the_axis(dz):
    np.testing.assert_allclose(sampled_turn(0.0, 0.0, dz, 0.2, 100, 5)[:, 2], 0.2 * dz, rtol=1e-12)


def test_streams_are_even_and_their_blocks_independent():
    u, v = sampled_uniform(N, 7, 0), sampled_uniform(N, 7, 1)
    assert u.min() >= 0
    assert u.max() < 1
    counts, _ = np.histogram(u, 20, (0, 1))
    assert np.sum((counts - N / 20) ** 2 / (N / 20)) < 43.8
    assert abs(np.corrcoef(u, v)[0, 1]) < 4 / np.sqrt(N)
    assert abs(np.corrcoef(u[1:], u[:-1])[0, 1]) < 4 / np.sqrt(N)
    assert not np.array_equal(u, sampled_uniform(N, 8, 0))


def momentum(energy, cos):
    """x = E/(hc) sin(theta/2)."""
    return energy / HC_KEV_ANGSTROM * np.sqrt((1 - cos) / 2)
