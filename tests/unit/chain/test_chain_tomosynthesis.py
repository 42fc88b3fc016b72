"""Views over an arc and their slices: attenuation comes back, scatter is where it was simulated."""

import numpy as np
import pytest

from mammosim.chain.image_chain import Equipment, Tube
from mammosim.chain.mammogram import tissue_materials
from mammosim.chain.tomosynthesis import Arc, Masks, ScatterAt, between, lesion_alone, slices_grid
from mammosim.core.errors import XrayError
from mammosim.core.labels import Label
from mammosim.core.rng import generator
from mammosim.core.volume import Image, LabelMap, grid_around
from mammosim.xray.attenuation import linear_attenuation
from mammosim.xray.detector import Scatter
from mammosim.xray.geometry import Detector
from mammosim.xray.reconstruction import sart
from mammosim.xray.spectrum import monoenergetic
from mammosim.xray.systems import system_named

X, Y, _ = np.eye(3)
EQUIPMENT = Equipment(Tube("W", "Rh", 50.0, 28.0), "selenium", 0.3, "siemens_prototype", 0.5)
SPECTRUM = monoenergetic(20.0, fluence=1e6, distance_mm=650.0)


def breast(lesion_mm: float = 0.0) -> LabelMap:
    """A block of fat, 60 by 40 by 40 mm in front of y = 0, with a ball of lesion in its middle."""
    grid = grid_around(np.array([-30.0, -40.0, 0.0]), np.array([30.0, 0.0, 40.0]), 2.0)
    values = np.full(grid.shape, Label.ADIPOSE, np.uint8)
    r = np.linalg.norm(grid.centres().reshape(*grid.shape, 3) - [0, -20, 20], axis=-1)
    values[r < lesion_mm / 2] = Label.LESION
    return LabelMap(grid, values)


def arc(labels: LabelMap, effects: tuple[str, ...]) -> Arc:
    """Nine views over 25 degrees on pixels of 2 mm."""
    return Arc.of(
        labels, system_named("ge"), SPECTRUM, chest_y_mm=0.0, pixel_mm=2.0, equipment=EQUIPMENT, steps=effects
    )


def plane(detector: Detector, a: float, b: float, c: float) -> np.ndarray:
    """a + b x + c y over the pixel centres of a detector in the plane z = 0."""
    rows, columns = np.indices(detector.shape)
    points = detector.origin + detector.pixel_mm * (
        columns[..., None] * detector.u + rows[..., None] * detector.v
    )
    x, y = points[..., 0], points[..., 1]
    return a + b * x + c * y


def test_scatter_that_is_linear_over_the_detector_and_the_angle_is_carried_exactly():
    cells = Detector(np.array([2.5, 2.5, 0.0]), X, Y, (12, 16), 5.0)
    pixels = Detector(np.array([10.5, 10.5, 0.0]), X, Y, (30, 40), 1.0)
    known = [
        ScatterAt(angle, cells, Scatter(*[plane(cells, angle, 0.3, -0.1)] * 2))
        for angle in (-10.0, 0.0, 10.0)
    ]
    found = between(known, 4.0, pixels)
    np.testing.assert_allclose(found.signal, plane(pixels, 4.0, 0.3, -0.1), atol=1e-9)
    np.testing.assert_allclose(found.signal_squared, found.signal)
    # beyond the angles that are known, the nearest
    np.testing.assert_allclose(between(known, 40.0, pixels).signal, plane(pixels, 10.0, 0.3, -0.1), atol=1e-9)


def test_without_effects_the_integrals_are_attenuation_times_length():
    labels = breast()
    scan = arc(labels, ())
    middle = scan.integrals(labels, mas=9.0, scatter=(), rng=generator(1))[4]
    tissues, E = tissue_materials(), SPECTRUM.energies_kev
    d_mu = linear_attenuation(tissues[Label.ADIPOSE], E) - linear_attenuation(tissues[Label.AIR], E)
    # rays to the middle of the block cross its 40 mm at angles up to 3 degrees
    assert middle.max() == pytest.approx(40.0 * d_mu[0], rel=3e-3)


def test_scatter_lowers_what_is_measured():
    labels = breast(10.0)
    scan = arc(labels, ())
    coarse = Arc.of(
        labels, scan.system, SPECTRUM, chest_y_mm=0.0, pixel_mm=20.0, equipment=EQUIPMENT, steps=()
    )
    known = coarse.scattered(labels, 1, relative_error=0.2, seed=3)
    clean, hazy = (scan.integrals(labels, mas=9.0, scatter=s, rng=generator(1)) for s in ((), known))
    for a, b in zip(clean, hazy):
        behind = a > 0.5 * a.max()
        assert np.all(b[behind] < a[behind])


def test_a_lesion_stands_out_of_its_slice():
    labels = breast(12.0)
    scan = arc(labels, ("quantum_noise",))
    b = scan.integrals(labels, mas=100.0, scatter=(), rng=generator(2))
    grid = slices_grid(labels, voxel_mm=2.0, slice_mm=4.0)
    slices = sart(b, scan.geometries, grid, iterations=2).image
    masks = Masks.of(labels, grid)
    assert grid.points(np.array([[masks.slice, 0, 0]], float))[0, 2] == pytest.approx(20.0, abs=2.0)
    found = masks.row(slices)
    assert found["cnr"] > 3 + 3 * found["cnr_se"]


def test_what_a_lesion_adds_is_most_in_its_own_slice_and_nothing_where_there_is_none():
    labels = breast(12.0)
    scan, grid = arc(labels, ("quantum_noise",)), slices_grid(labels, voxel_mm=2.0, slice_mm=4.0)
    alone = lesion_alone(scan, labels, grid, sart)
    profile = Masks.of(labels, grid).profile(alone)
    assert profile.height_mm[profile.difference_per_mm.idxmax()] == pytest.approx(0.0, abs=4.0)
    assert not lesion_alone(scan, breast(), grid, sart).values.any()


def test_slices_of_a_breast_without_lesion_have_no_contrast_to_measure():
    labels = breast()
    with pytest.raises(XrayError, match="insert one before the views are taken"):
        Masks.of(labels, slices_grid(labels, voxel_mm=2.0, slice_mm=4.0))


def test_slices_cover_the_breast():
    labels = breast()
    grid = slices_grid(labels, voxel_mm=2.0, slice_mm=4.0)
    assert Image(grid, np.zeros(grid.shape, np.float32)).values.shape == (10, 20, 30)
