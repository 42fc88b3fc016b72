"""Tomosynthesis: projector and backprojector are transposes, and slices show what was there."""

from dataclasses import replace

import numpy as np
import pytest

from mammosim.core.errors import XrayError
from mammosim.core.rng import generator
from mammosim.core.volume import Grid, Image, grid_around
from mammosim.xray.attenuation import material
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.laminography import seen_flat, view_of
from mammosim.xray.measured import point_spread_widths
from mammosim.xray.phantom import Phantom
from mammosim.xray.projector import path_lengths
from mammosim.xray.reconstruction import filtered_backprojection, line_integrals, sart
from mammosim.xray.systems import system_named
from mammosim.xray.views import tomosynthesis_geometries

X, Y, Z = np.eye(3)
BEAD = np.array([3.0, -20.0, 17.0])
LOW, HIGH = np.array([-30.0, -45.0, 0.0]), np.array([30.0, 0.0, 40.0])


def bead_phantom() -> Phantom:
    """A ball of radius 1 mm at BEAD in air, in a box that says where the breast is."""
    grid = grid_around(LOW, HIGH, 0.5)
    index = np.zeros(grid.shape, np.uint8)
    index[np.linalg.norm(grid.centres() - BEAD, axis=1).reshape(grid.shape) < 1.0] = 1
    return Phantom(grid, index, (material("air"), material("calcium_oxalate")))


def views_of(name: str, arc_deg: float | None = None) -> tuple[Geometry, ...]:
    """Views of a system of a block of the size of the bead's box."""
    of = system_named(name)
    of = of if arc_deg is None else replace(of, arc_deg=arc_deg, views=9)
    block = Phantom(
        grid_around(LOW, HIGH, 5.0), np.ones((8, 9, 12), np.uint8), (material("air"), material("water"))
    )
    return tomosynthesis_geometries(block, of, chest_wall_y_mm=0.0, pixel_mm=0.5)


def lengths_in(phantom: Phantom, geometries: tuple[Geometry, ...]) -> list[np.ndarray]:
    """Line integrals of one in the body, by the exact projector."""
    return [path_lengths(phantom, g)[..., 1:].sum(-1) for g in geometries]


GRID = grid_around(LOW - 5, HIGH + np.array([5.0, 5.0, 0.0]), (1.0, 1.0, 1.0))
GRID = Grid((40, *GRID.shape[1:]), GRID.spacing, GRID.origin + np.array([0, 0, 5.0]))


@pytest.mark.parametrize("n", [0, 4, 8])
def test_projector_and_backprojector_are_transposes(n):
    """<A V, p> = <V, A^T p>: sums of 40 float32 are rounded by less than 40 x 6e-8 = 2e-6."""
    view = view_of(GRID, views_of("ge")[n])
    rng = generator(1, n)
    V, p = (rng.random(shape).astype(np.float32) for shape in (GRID.shape, view.way.shape))
    forward, back = (np.vdot(a.astype(float), b) for a, b in ((view.project(V), p), (view.transpose(p), V)))
    assert forward == pytest.approx(back, rel=2e-6)


def test_the_sums_of_rows_and_voxels_are_those_of_ones():
    """To 2e-6 of float32, of 40 slices."""
    view = view_of(GRID, views_of("ge")[0])
    ones = np.ones(GRID.shape, np.float32)
    np.testing.assert_allclose(view.project(ones) / view.way, view.rows, atol=40 * 2e-6)
    of_voxels = view.of_y[:, :, None] * view.of_x[:, None, :]
    np.testing.assert_allclose(
        view.transpose((1 / view.way).astype(np.float32)), of_voxels, rtol=2e-5, atol=1e-5
    )


def test_slices_that_are_linear_in_space_are_projected_exactly():
    """Inside, the sum of a linear function over slices is their number times its value half way."""
    view, geometry = view_of(GRID, views_of("ge")[2]), views_of("ge")[2]
    slope = np.array([0.01, 0.02, 0.0])
    p = view.project((2.0 + GRID.centres() @ slope).reshape(GRID.shape).astype(np.float32))
    d = geometry.detector
    rows, columns = np.indices(d.shape)
    end = d.origin + d.pixel_mm * (columns[..., None] * d.u + rows[..., None] * d.v)
    half_way = geometry.source + (geometry.source[2] - 20.0) / geometry.source_height_mm * (
        end - geometry.source
    )
    exact = 40 * view.way * (2.0 + half_way @ slope)
    inside = view.rows > 40 - 1e-9
    assert inside.sum() > 1000
    np.testing.assert_allclose(p[inside], exact[inside], rtol=2e-6)


def test_a_slab_that_fills_the_slices_is_recovered():
    """SART finds the one value that explains all views, where no ray comes by that hardly enters."""
    geometries = views_of("ge")
    views = [view_of(GRID, g) for g in geometries]
    integrals = [v.project(np.full(GRID.shape, 0.05, np.float32)) for v in views]
    found = sart(integrals, geometries, GRID, iterations=2, relaxation=1.0)
    grazed = np.sum([v.transpose((v.rows < 1e-3).astype(np.float32)) for v in views], axis=0)
    seen = np.all([v.of_y[:, :, None] * v.of_x[:, None, :] > 0 for v in views], axis=0)
    assert np.mean(seen & (grazed == 0)) > 0.5
    np.testing.assert_allclose(found.image.values[seen & (grazed == 0)], 0.05, rtol=1e-5)


def test_the_residual_of_sart_falls_with_every_iteration():
    geometries = views_of("ge")
    residuals = sart(lengths_in(bead_phantom(), geometries), geometries, GRID, iterations=5).residuals
    assert np.all(np.diff(residuals) < 0), residuals


@pytest.mark.parametrize("name", ["siemens", "hologic"])
@pytest.mark.parametrize("method", [sart, filtered_backprojection])
def test_a_bead_appears_in_its_slice_and_place(name, method):
    """Within half a voxel and half a slice, for a still and for a turning detector."""
    geometries = views_of(name)
    found = method(lengths_in(bead_phantom(), geometries), geometries, GRID).image
    weights = np.clip(found.values - 0.5 * found.values.max(), 0, None)
    centre = (weights.ravel() @ GRID.centres()) / weights.sum()
    np.testing.assert_allclose(centre[:2], BEAD[:2], atol=0.5)
    assert centre[2] == pytest.approx(BEAD[2], abs=1.0 if name == "hologic" else 0.5)


def test_a_wider_arc_sees_depth_better():
    """The backprojections of a ball of diameter d part at depths of about d/arc to both sides."""
    widths = []
    for arc in (12.0, 24.0, 48.0):
        geometries = views_of("ge", arc)
        found = filtered_backprojection(lengths_in(bead_phantom(), geometries), geometries, GRID).image
        widths.append(point_spread_widths(found, BEAD, radius_mm=2.0).z_mm)
    ratios = np.array(widths[:-1]) / widths[1:]
    assert np.all((ratios > 1.4) & (ratios < 2.6)), widths


def test_a_pattern_that_the_arc_sees_is_recovered_by_filtered_backprojection():
    """cos(2 pi f x) times a Gaussian in z has frequencies f_z < f_x tan(arc/2), but for 0.1 percent.

    The Hann window leaves cos^2(pi f D) for pixels of D = 1 mm, and linear reading between voxels, and again
    between pixels, sinc^2(f D) on average and from cos^2(pi f D/2) to one, 2.5 percent, in single places.
    """
    f, width = 0.1, 9.0
    detector = Detector(np.array([149.5, -1.5, -60.0]), -X, -Y, (8, 300), 1.0)
    angles = np.radians(np.linspace(-30, 30, 31))
    geometries = [Geometry(np.array([1e5 * np.tan(a), -5.0, 1e5]), detector) for a in angles]
    grid = Grid((100, 8, 160), np.array([1.0, 1.0, 1.0]), np.array([-79.5, -8.5, -49.5]))
    x, _, z = grid.centres().T.reshape(3, *grid.shape)
    pattern = np.cos(2 * np.pi * f * x) * np.exp(-(z**2) / (2 * width**2))
    integrals = [view_of(grid, g).project(pattern.astype(np.float32)) for g in geometries]
    found = filtered_backprojection(integrals, geometries, grid).image.values
    middle = np.s_[45:55, 4, 60:100]
    amplitude = np.vdot(found[middle], pattern[middle]) / np.vdot(pattern[middle], pattern[middle])
    assert amplitude == pytest.approx(np.cos(np.pi * f) ** 2 * np.sinc(f) ** 4, rel=0.025)


def test_a_turned_detector_sees_what_a_flat_one_would_have_seen():
    """Chords of a ball of 24 mm of voxels, whose staircase alone differs from ray to ray by a voxel."""
    turned = views_of("hologic")[0]
    grid = grid_around(LOW, HIGH, 0.5)
    ball = (np.linalg.norm(grid.centres() - [0, -20, 20], axis=1) < 12).reshape(grid.shape)
    phantom = Phantom(grid, ball.astype(np.uint8), (material("air"), material("water")))
    seen, flat = seen_flat(path_lengths(phantom, turned)[..., 1], turned)
    np.testing.assert_allclose(flat.detector.normal, Z, atol=1e-12)
    exact = path_lengths(phantom, flat)[..., 1]
    inside = exact > 10
    assert np.abs(seen - exact)[inside].mean() < 0.5
    assert np.abs((seen - exact)[inside].mean()) < 0.02


def test_the_width_of_a_gaussian_is_two_root_two_ln_two_sigma():
    grid = grid_around(np.full(3, -20.0), np.full(3, 20.0), 0.5)
    r = grid.centres().reshape(*grid.shape, 3)
    values = np.exp(-0.5 * np.sum((r / [1.0, 2.0, 3.0]) ** 2, axis=-1)).astype(np.float32)
    found = point_spread_widths(Image(grid, values), np.zeros(3), radius_mm=1.0)
    half = 2 * np.sqrt(2 * np.log(2))
    # linear reading at half height errs by h^2/8 times the curvature over the slope, below 0.02 mm here;
    # the voxel nearest to the top is h/2 away in each direction and lowers it a little
    np.testing.assert_allclose([found.x_mm, found.y_mm, found.z_mm], half * np.array([1, 2, 3]), rtol=0.04)


def test_impossible_reconstructions_are_rejected():
    geometries = views_of("ge")
    images = [np.zeros(g.detector.shape) for g in geometries]
    with pytest.raises(XrayError, match="one for each"):
        sart(images[:3], geometries, GRID)
    with pytest.raises(XrayError, match="relaxation"):
        sart(images, geometries, GRID, relaxation=2.5)
    with pytest.raises(XrayError, match="finite"):
        sart([np.full(i.shape, np.nan) for i in images], geometries, GRID)
    with pytest.raises(XrayError, match="two views"):
        filtered_backprojection(images[:1], geometries[:1], GRID)
    with pytest.raises(XrayError, match="between the detector"):
        sart(images, geometries, Grid(GRID.shape, GRID.spacing, GRID.origin - 100))
    with pytest.raises(XrayError, match="raise mAs"):
        line_integrals(np.zeros((2, 2)), np.ones((2, 2)))
    with pytest.raises(XrayError, match="seen_flat"):
        view_of(GRID, views_of("hologic")[0])
