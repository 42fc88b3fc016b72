"""Tomosynthesis of a small breast: where a lesion shows, and what scatter does to it."""

from dataclasses import replace

import numpy as np
import pytest

from mammosim.core.errors import XrayError
from mammosim.core.labels import Label
from mammosim.core.rng import generator
from mammosim.core.volume import Grid, Image, LabelMap, grid_around
from mammosim.study.mammogram import xray_phantom
from mammosim.study.tomosynthesis import Scan, lesion_contrast, slices_grid, views
from mammosim.xray.detector import Scatter
from mammosim.xray.projector import primary
from mammosim.xray.reconstruction import Slices, filtered_backprojection, sart
from mammosim.xray.spectrum import monoenergetic
from mammosim.xray.systems import system_named

SCAN = Scan(system_named("ge"), monoenergetic(20.0, fluence=1e5), None, mas=50.0, pixel_mm=1.0)


@pytest.fixture(scope="module")
def breast() -> LabelMap:
    """A half cylinder of fat, 40 mm thick, with a lesion of 10 mm at 12 mm above the support."""
    grid = grid_around(np.array([-40.0, -40, 0]), np.array([40.0, 0, 40]), 2.0)
    p = grid.centres().reshape(*grid.shape, 3)
    values = np.where(np.hypot(p[..., 0], p[..., 1]) < 36, Label.ADIPOSE, Label.AIR)
    values[np.linalg.norm(p - [4, -16, 12], axis=-1) < 5] = Label.LESION
    return LabelMap(grid, values.astype(np.uint8))


def grid_of(breast: LabelMap) -> Grid:
    return slices_grid(breast, chest_y_mm=0.0, voxel_mm=1.0, slice_mm=2.0)


def shifted(slices: Slices, millimetres: float) -> Slices:
    """The same slices, said to be elsewhere in depth."""
    grid = slices.image.grid
    moved = replace(grid, origin=grid.origin + np.array([0, 0, millimetres]))
    return Slices(replace(slices.image, grid=moved))


@pytest.mark.parametrize("method", [sart, filtered_backprojection])
def test_a_lesion_shows_best_in_its_own_slice(breast, method):
    """14 mm away, more than its diameter, the shadows of the outer views have parted from its place."""
    taken = views(breast, replace(SCAN, effects=()), chest_y_mm=0.0, rng=generator(1))
    found = method(taken.integrals, taken.geometries, grid_of(breast))
    contrasts = [lesion_contrast(shifted(found, mm), breast) for mm in (-14.0, 0.0, 10.0)]
    below, own, above = (c.signal_mean - c.background_mean for c in contrasts)
    assert own > 1.2 * max(below, above)


def test_noise_of_views_falls_with_the_root_of_mas(breast):
    """The variance of a line integral is one over the photons of a pixel: a quarter at four times the mAs."""
    exact = views(breast, replace(SCAN, effects=()), chest_y_mm=0.0, rng=generator(1))
    spread = []
    for mas in (50.0, 200.0):
        taken = views(breast, replace(SCAN, mas=mas), chest_y_mm=0.0, rng=generator(2))
        spread.append(np.var(np.array(taken.integrals) - np.array(exact.integrals)))
    # some 4e5 pixels: the variances are known to sqrt(2/4e5) = 0.2 percent
    assert spread[0] / spread[1] == pytest.approx(4.0, rel=0.02)


def test_scatter_as_strong_as_the_primary_takes_ln_2_off_every_line_integral(breast):
    quiet = replace(SCAN, effects=())
    plain = views(breast, quiet, chest_y_mm=0.0, rng=generator(1))
    images = [primary(xray_phantom(breast), g, SCAN.spectrum) for g in plain.geometries]
    scatter = [Scatter(image.signal, image.signal_squared) for image in images]
    more = views(breast, quiet, chest_y_mm=0.0, rng=generator(1), scatter=scatter)
    np.testing.assert_allclose(np.array(plain.integrals) - np.array(more.integrals), np.log(2), atol=1e-5)


def test_what_cannot_be_scanned_is_refused(breast):
    with pytest.raises(XrayError, match="give it for each"):
        views(breast, SCAN, chest_y_mm=0.0, rng=generator(1), scatter=[])
    healthy = LabelMap(breast.grid, np.minimum(breast.values, Label.ADIPOSE).astype(np.uint8))
    grid = grid_of(breast)
    empty = Slices(Image(grid, np.zeros(grid.shape, np.float32)))
    with pytest.raises(XrayError, match="no lesion"):
        lesion_contrast(empty, healthy)
    with pytest.raises(XrayError, match="not among"):
        lesion_contrast(shifted(empty, 100.0), breast)
