"""The primary image: Beer-Lambert along exact rays."""

import numpy as np
import pytest

from mammosim.core.rng import generator
from mammosim.core.volume import grid_around
from mammosim.xray.attenuation import linear_attenuation, material
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.phantom import Phantom
from mammosim.xray.projector import aligned_rows, path_lengths, primary
from mammosim.xray.response import Response
from mammosim.xray.rows import passed
from mammosim.xray.siddon import lengths_to
from mammosim.xray.spectrum import Spectrum, monoenergetic

X, Y, Z = np.eye(3)
SOURCE = np.array([10.0, -20.0, 600.0])
GEOMETRY = Geometry(SOURCE, Detector(np.array([-60.0, -60.0, 0.0]), X, Y, (13, 13), 10.0))
BEAM = Spectrum(np.array([15.0, 20.0, 25.0]), np.array([1e5, 2e5, 1e5]), 600.0)
AIR, WATER, ADIPOSE = material("air"), material("water"), material("adipose")


def slabs() -> Phantom:
    """20 mm of water below 30 mm of adipose tissue, wider than the field."""
    grid = grid_around(np.array([-100.0, -100.0, 10.0]), np.array([100.0, 100.0, 60.0]), (10.0, 10.0, 5.0))
    index = np.ones(grid.shape, np.uint8)
    index[4:] = 2
    return Phantom(grid, index, (AIR, WATER, ADIPOSE))


def pixel_rays(geometry: Geometry) -> tuple[np.ndarray, np.ndarray]:
    """Distance from the source (nv, nu) and cosine to the normal (nv, nu) of each pixel's centre."""
    d = geometry.detector
    rows, columns = np.indices(d.shape)
    r = geometry.source - (d.origin + d.pixel_mm * (columns[..., None] * d.u + rows[..., None] * d.v))
    distance = np.linalg.norm(r, axis=-1)
    return distance, r @ d.normal / distance


def test_lengths_in_a_slab_are_thickness_over_cosine():
    r, cos = pixel_rays(GEOMETRY)
    L = path_lengths(slabs(), GEOMETRY)
    np.testing.assert_allclose(L[..., 1], 20.0 / cos, rtol=1e-12)
    np.testing.assert_allclose(L[..., 2], 30.0 / cos, rtol=1e-12)
    np.testing.assert_allclose(L.sum(axis=-1), r, rtol=1e-12)


def test_primary_behind_slabs_is_beer_lambert_with_inverse_square_and_obliquity():
    r, cos = pixel_rays(GEOMETRY)
    I = np.zeros_like(r)
    for E, N in zip(BEAM.energies_kev, BEAM.fluence):
        mu_air, mu_water, mu_adipose = (
            linear_attenuation(m, np.array([E]))[0] for m in (AIR, WATER, ADIPOSE)
        )
        depth = (mu_water * 20 + mu_adipose * 30) / cos + mu_air * (r - 50 / cos)
        I += N * E * np.exp(-depth) * (600.0 / r) ** 2 * cos
    np.testing.assert_allclose(primary(slabs(), GEOMETRY, BEAM).signal, I, rtol=1e-10)


def test_unobstructed_image_is_air_only():
    r, cos = pixel_rays(GEOMETRY)
    beam = monoenergetic(20.0, distance_mm=600.0)
    mu_air = linear_attenuation(AIR, np.array([20.0]))[0]
    expected = 20.0 * np.exp(-mu_air * r) * (600.0 / r) ** 2 * cos
    np.testing.assert_allclose(primary(slabs(), GEOMETRY, beam).unobstructed, expected, rtol=1e-10)


def test_rays_along_voxel_faces_and_axes_lose_no_length():
    detector = Detector(np.array([0.0, 0.0, -5.0]), X, Y, (1, 1), 1.0)
    for source in ([0.0, 0.0, 500.0], [0.0, 50.0, 45.0]):
        L = path_lengths(slabs(), Geometry(np.array(source), detector))
        assert L.sum() == pytest.approx(np.linalg.norm(np.array(source) - [0, 0, -5.0]), rel=1e-12)


def test_a_ray_that_misses_the_phantom_sees_air():
    away = Geometry(np.array([500.0, 0, 600.0]), Detector(np.array([500.0, 0, 0]), X, Y, (1, 1), 1.0))
    assert path_lengths(slabs(), away)[0, 0].tolist() == [pytest.approx(600.0), 0.0, 0.0]


def test_a_response_takes_its_share_of_each_energy():
    """One energy, no fluorescence: the signal falls by the absorbed share eta, and so does its square."""
    layer = Response(WATER, 3.0, AIR)
    beam = monoenergetic(20.0, distance_mm=600.0)
    whole, part = (primary(slabs(), GEOMETRY, beam, response=r) for r in (None, layer))
    eta = layer.absorption(np.array([20.0]))[0]
    assert 0.05 < eta < 0.5
    np.testing.assert_allclose(part.signal, eta * whole.signal, rtol=1e-12)
    np.testing.assert_allclose(part.signal_squared, eta * whole.signal_squared, rtol=1e-12)


def test_supersampling_converges_to_the_mean_over_the_pixel():
    # behind a sharp edge, n rays per axis err by less than 1/n of the step in transmission
    detector = Detector(np.array([103.0, 0.0, 0.0]), X, Y, (1, 1), 12.0)
    geometry = Geometry(np.array([100.0, 0.0, 1e6]), detector)
    beam = monoenergetic(20.0, distance_mm=1e6)
    edge = primary(slabs(), geometry, beam, supersampling=40)
    full = primary(slabs(), Geometry(np.array([0, 0, 1e6]), Detector(np.zeros(3), X, Y, (1, 1), 1.0)), beam)
    T = full.signal[0, 0] / full.unobstructed[0, 0]
    assert edge.signal[0, 0] / edge.unobstructed[0, 0] == pytest.approx(0.25 * T + 0.75, abs=1 / 40)


def ray_by_ray(phantom: Phantom, geometry: Geometry) -> np.ndarray:
    """Lengths (nv, nu, n_material) by Siddon's stepping from voxel to voxel."""
    d = geometry.detector
    rows, columns = np.indices(d.shape)
    targets = d.origin + d.pixel_mm * (columns[..., None] * d.u + rows[..., None] * d.v)
    rays = (geometry.source, targets.reshape(-1, 3), len(phantom.materials))
    return lengths_to(phantom.index, phantom.low, phantom.grid.spacing, *rays).reshape(*d.shape, -1)


def turned(u: np.ndarray, v: np.ndarray, source: np.ndarray) -> Geometry:
    """A detector of 30 x 40 pixels below the origin, seen from the source."""
    centre = -0.1 * source
    return Geometry(source, Detector(centre - 29 * u - 22 * v, u, v, (30, 40), 1.5))


TILT = np.array([0.0, np.cos(0.3), np.sin(0.3)])


@pytest.mark.parametrize(
    "geometry",
    [
        turned(X, Y, np.array([13.0, -7.0, 300.0])),
        turned(-X, -Y, np.array([0.0, 0.0, 300.0])),
        turned(Y, -X, np.array([-40.0, 3.0, 250.0])),
        turned(X, TILT, np.array([5.0, -90.0, 280.0])),
        turned(TILT, -X, np.array([5.0, -90.0, 280.0])),
        turned(Y, Z, np.array([300.0, 11.0, 2.0])),
        turned(X, Y, np.array([1.0, 2.0, 14.0])),
    ],
    ids=["plain", "backwards", "columns", "tilted", "tilted columns", "sideways", "source in the grid"],
)
def test_rows_traced_together_have_the_lengths_of_single_rays(geometry):
    """To rounding: 1e-10 of a ray, after some 100 sums of numbers of order one."""
    grid = grid_around(np.array([-16.0, -20.0, -12.0]), np.array([16.0, 20.0, 18.0]), (2.0, 1.0, 1.5))
    index = generator(5, "voxels").integers(0, 4, grid.shape).astype(np.uint8)
    phantom = Phantom(grid, index, (AIR, WATER, ADIPOSE, material("skin")))
    assert aligned_rows(geometry) is not None
    L = path_lengths(phantom, geometry)
    np.testing.assert_allclose(L, ray_by_ray(phantom, geometry), atol=1e-10 * L.sum(-1).max())


def test_an_arbitrarily_turned_detector_is_traced_ray_by_ray():
    u = np.array([np.cos(0.2), np.sin(0.2), 0.0])
    geometry = turned(u, np.cross(Z, u), np.array([0.0, 0.0, 300.0]))
    assert aligned_rows(geometry) is None
    cos = pixel_rays(geometry)[1]
    grid = grid_around(np.array([-100.0, -100, 0]), np.array([100.0, 100, 20]), 5.0)
    slab = Phantom(grid, np.ones(grid.shape, np.uint8), (AIR, WATER))
    np.testing.assert_allclose(path_lengths(slab, geometry)[..., 1], 20 / cos, rtol=1e-12)
    E = np.array([20.0])
    mu_air, mu = (linear_attenuation(m, E)[0] for m in (AIR, WATER))
    image = primary(slab, geometry, monoenergetic(20.0))
    np.testing.assert_allclose(
        image.signal / image.unobstructed, np.exp((mu_air - mu) * 20 / cos), rtol=1e-10
    )


def test_the_exponential_is_exact_to_rounding():
    """Relative error below 1e-15 (1 + x): the argument alone is rounded by half a unit in the last place."""
    x = np.concatenate([np.linspace(0, 50, 4001), [1e-12, 300.0, 689.0]])
    into = np.zeros((1, x.size))
    passed(x[None], np.ones((1, 1)), np.ones((1, 1)), into, np.zeros((2, x.size)))
    assert np.all(np.abs(into[0] / np.exp(-x) - 1) < 1e-15 * (1 + x))
