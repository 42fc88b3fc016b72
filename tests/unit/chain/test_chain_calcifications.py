"""Balls finer than a pixel take out of a beam what their volume does."""

import numpy as np
import pytest

from mammosim.chain.calcifications import (
    Cluster,
    Place,
    beam_behind,
    cluster_detectability,
    patch_behind,
    with_cluster,
)
from mammosim.chain.image_chain import Acquisition, Equipment, Tube
from mammosim.chain.mammogram import View
from mammosim.core.errors import XrayError
from mammosim.core.rng import generator
from mammosim.core.volume import grid_around
from mammosim.xray.attenuation import linear_attenuation, material
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.phantom import Phantom
from mammosim.xray.projector import primary
from mammosim.xray.spectrum import Spectrum, monoenergetic

PIXEL = 0.1
EQUIPMENT = Equipment(Tube("W", "Rh", 50.0, 28.0), "selenium", 0.3, "siemens_prototype", 0.5)
BEAM = Spectrum(np.array([16.0, 22.0]), np.array([3e5, 2e5]), 650.0)


@pytest.fixture(scope="module")
def slab() -> Phantom:
    """40 mm of gland over an area of 60 by 60 mm."""
    grid = grid_around(np.array([-30.0, -30.0, 20.0]), np.array([30.0, 30.0, 60.0]), 5.0)
    index = np.ones(grid.shape, np.uint8)
    return Phantom(grid, index, (material("air"), material("glandular")))


@pytest.fixture(scope="module")
def view() -> Geometry:
    """A source 650 mm over the middle of a detector."""
    u, v = np.eye(3)[0], np.eye(3)[1]
    return Geometry(np.array([0.0, 0.0, 650.0]), Detector(np.array([-20.0, -20.0, 0.0]), u, v, (41, 41), 1.0))


PLACE = Place(np.array([3.0, -4.0, 40.0]), material("glandular"), material("calcium_oxalate"))


def patch_of(view, effects):
    """The patch as an image with these effects."""
    whole = View(Acquisition(view, 40.0, EQUIPMENT), BEAM, effects)
    return whole.on(patch_behind(PLACE, view, pixels=40, pixel_mm=PIXEL))


def images(slab, view, cluster, spectrum=BEAM, pixels=40):
    patch = patch_behind(PLACE, view, pixels=pixels, pixel_mm=PIXEL)
    without = primary(slab, patch, spectrum)
    beam = beam_behind(slab, PLACE, view, spectrum, None)
    return with_cluster(without, cluster, PLACE, patch=patch, beam=beam), without


def test_a_patch_lies_around_the_shadow_of_its_place(view):
    patch = patch_behind(PLACE, view, pixels=40, pixel_mm=PIXEL)
    np.testing.assert_allclose(patch.project(PLACE.point[None])[0], [2.0, 2.0])
    assert patch.detector.normal @ view.detector.normal == pytest.approx(1.0)


def test_what_thin_balls_take_from_the_beam_is_their_volume(slab, view):
    """d_mu t is small for a ball of 0.02 mm: the relative loss, summed over the plane, is d_mu V each."""
    cluster = Cluster(np.array([[0.01, 0.02], [0.6, -0.5], [-0.7, 0.4]]), 0.4)
    at = monoenergetic(22.0, distance_mm=650.0)
    seen, without = images(slab, view, cluster, at)
    d_mu = linear_attenuation(PLACE.balls, at.energies_kev) - linear_attenuation(
        PLACE.tissue, at.energies_kev
    )
    nearer = 610.0 / 650.0
    taken = -np.log(seen.signal / without.signal).sum() * (PIXEL * nearer) ** 2
    V = 3 * np.pi / 6 * 0.4**3
    # averaging transmission in a pixel in place of chords loses less than half of (d_mu t)^2, 0.2^2 at most
    assert taken == pytest.approx(d_mu[0] * V, rel=0.03)


def test_the_middle_of_a_ball_passes_what_its_diameter_lets_pass(slab, view):
    """A ball of 1 mm covers whole pixels: those in its middle see almost its diameter."""
    at = monoenergetic(22.0, distance_mm=650.0)
    seen, without = images(slab, view, Cluster(np.zeros((1, 2)), 1.0), at)
    d_mu = linear_attenuation(PLACE.balls, at.energies_kev) - linear_attenuation(
        PLACE.tissue, at.energies_kev
    )
    least = (seen.signal / without.signal).min()
    # pixels next to the middle lie within 0.14 mm of it, where the chord is 0.96 mm or more
    assert np.exp(-d_mu[0] * 1.0) < least < np.exp(-d_mu[0] * 0.96)


def test_clusters_are_seen_better_at_four_times_the_exposure(slab, view):
    cluster = Cluster.sampled(5, width_mm=2.0, diameter_mm=0.3, rng=generator(1, "balls"))
    pair = images(slab, view, cluster)
    patch = patch_of(view, ("quantum_noise",))
    found = [
        cluster_detectability(pair, patch, mas=mas, count=60, rng=generator(2, str(mas)))
        for mas in (1.0, 4.0)
    ]
    (d_one, one, cnr_one), (d_four, four, cnr_four) = found
    assert d_four == pytest.approx(2 * d_one, rel=1e-6)
    assert cnr_four == pytest.approx(2 * cnr_one, rel=1e-6)
    assert one.low < d_one < one.high
    # of an ideal sum of pixels: d'^2 = sum (dI / sigma)^2, twice as large; the intervals hold 95 %
    assert one.low < one.d < one.high
    assert 2 * one.low < four.high
    assert four.low < 2 * one.high


@pytest.mark.parametrize("noise", [("quantum_noise",), ("quantum_noise", "blur", "electronic_noise")])
def test_what_all_images_would_tell_lies_where_many_images_say(slab, view, noise):
    """The interval of 2 x 800 images holds 99.9 % and is 4 % wide to each side."""
    pair = images(slab, view, Cluster.sampled(5, width_mm=2.0, diameter_mm=0.3, rng=generator(1, "balls")))
    patch = patch_of(view, noise)
    d, told, _ = cluster_detectability(pair, patch, mas=1.0, count=800, rng=generator(4, *noise))
    reach = 3.29 / 1.96
    assert told.d - reach * (told.d - told.low) < d < told.d + reach * (told.high - told.d)
    assert (told.high - told.low) / told.d < 0.08


def test_what_is_no_microcalcification_is_rejected():
    with pytest.raises(XrayError, match=r"a cluster has some, of 0\.1 to 1 mm"):
        Cluster(np.zeros((2, 2)), 5.0)
    with pytest.raises(XrayError, match="a cluster has some"):
        Cluster(np.zeros((0, 2)), 0.3)


def test_without_noise_nothing_can_be_said(slab, view):
    pair = images(slab, view, Cluster(np.zeros((1, 2)), 0.3))
    with pytest.raises(XrayError, match="add quantum_noise"):
        cluster_detectability(pair, patch_of(view, ()), mas=1.0, count=3, rng=generator(1))
