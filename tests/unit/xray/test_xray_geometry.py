"""Phantom and geometry: where things are, and what is rejected."""

import numpy as np
import pytest

from mammosim.core.errors import XrayError
from mammosim.core.labels import Label
from mammosim.core.volume import Grid, LabelMap, grid_around
from mammosim.xray.attenuation import material
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.phantom import Phantom, phantom_of_labels
from mammosim.xray.views import mammography_geometry

X, Y, Z = np.eye(3)
AIR_AND_WATER = (material("air"), material("water"))


def block(low=(-40.0, -60.0, 0.0), high=(40.0, 0.0, 50.0), step=5.0) -> Phantom:
    grid = grid_around(np.array(low), np.array(high), step)
    return Phantom(grid, np.ones(grid.shape, np.uint8), AIR_AND_WATER)


def test_a_point_on_the_detector_projects_to_itself_and_others_are_magnified():
    detector = Detector(np.array([0.5, 0.5, 0.0]), X, Y, (100, 200), 1.0)
    geometry = Geometry(np.array([100.0, 0.0, 600.0]), detector)
    points = np.array([[30.0, 20.0, 0.0], [110.0, 10.0, 300.0]])
    np.testing.assert_allclose(geometry.project(points), [[30.0, 20.0], [120.0, 20.0]])


def test_solid_angle_of_a_far_detector_is_area_over_square_distance():
    detector = Detector(np.zeros(3), X, Y, (10, 10), 1.0)
    geometry = Geometry(np.array([4.5, 4.5, 1e4]), detector)
    assert geometry.solid_angle() == pytest.approx(100 / 1e8, rel=1e-5)


def test_solid_angle_of_a_cube_face_is_a_sixth_of_the_sphere():
    detector = Detector(np.array([-0.5, -0.5, 0.0]), X, Y, (2, 2), 1.0)
    assert Geometry(np.array([0, 0, 1.0]), detector).solid_angle() == pytest.approx(4 * np.pi / 6, rel=1e-12)


def test_binning_keeps_the_detector_in_place():
    fine = Detector(np.array([1.0, 2.0, 3.0]), X, Y, (60, 80), 0.5)
    coarse = fine.binned(5.0)
    assert coarse.shape == (6, 8)
    np.testing.assert_allclose(coarse.corner, fine.corner)
    assert coarse.size_mm == fine.size_mm
    with pytest.raises(XrayError, match="do not divide"):
        fine.binned(3.5)


def test_impossible_detectors_and_sources_are_rejected():
    with pytest.raises(XrayError, match="orthonormal"):
        Detector(np.zeros(3), X, X + Y, (2, 2), 1.0)
    with pytest.raises(XrayError, match="positive size"):
        Detector(np.zeros(3), X, Y, (2, 2), -1.0)
    with pytest.raises(XrayError, match="behind"):
        Geometry(np.array([0, 0, -600.0]), Detector(np.zeros(3), X, Y, (2, 2), 1.0))


def test_mammography_source_stands_over_the_chest_wall_edge():
    geometry = mammography_geometry(block(), chest_wall_y_mm=0.0)
    np.testing.assert_allclose(geometry.source, [0.0, 0.0, -15.0 + 650.0])
    np.testing.assert_allclose(geometry.project(np.array([[0.0, 0.0, 0.0]])), [[150.0, 0.0]], atol=1e-9)
    assert geometry.source_height_mm == pytest.approx(650.0)


def test_a_breast_that_leaves_the_field_is_rejected():
    with pytest.raises(XrayError, match=r"enlarge xray\.field_mm"):
        mammography_geometry(block(), chest_wall_y_mm=0.0, field_mm=(50.0, 300.0))
    with pytest.raises(XrayError, match=r"enlarge xray\.field_mm"):
        mammography_geometry(block(), chest_wall_y_mm=0.0, field_mm=(240.0, 80.0))
    with pytest.raises(XrayError, match="no tissue"):
        mammography_geometry(block(), chest_wall_y_mm=-100.0)


def test_impossible_phantoms_are_rejected():
    grid = grid_around(np.zeros(3), np.full(3, 4.0), 1.0)
    ones = np.ones(grid.shape, np.uint8)
    with pytest.raises(XrayError, match="empty"):
        Phantom(grid, 0 * ones, AIR_AND_WATER)
    with pytest.raises(XrayError, match="index 2"):
        Phantom(grid, 2 * ones, AIR_AND_WATER)
    with pytest.raises(XrayError, match="uint8"):
        Phantom(grid, np.full(grid.shape, np.nan), AIR_AND_WATER)
    with pytest.raises(XrayError, match="does not fit"):
        Phantom(grid, ones[:2], AIR_AND_WATER)
    turned = Grid(grid.shape, grid.spacing, grid.origin, np.array([[0, -1.0, 0], [1, 0, 0], [0, 0, 1]]))
    with pytest.raises(XrayError, match="follow the axes"):
        Phantom(turned, ones, AIR_AND_WATER)


def test_labels_become_a_phantom_of_the_same_indices():
    grid = grid_around(np.zeros(3), np.full(3, 20.0), 10.0)
    labels = LabelMap(grid, np.full(grid.shape, Label.GLANDULAR, np.uint8))
    phantom = phantom_of_labels(labels, {Label.AIR: material("air"), Label.GLANDULAR: material("glandular")})
    assert phantom.materials[Label.GLANDULAR].name == "glandular"
    assert phantom.mass_g(Label.GLANDULAR) == pytest.approx(8.0 * 1.04)
    with pytest.raises(XrayError, match="no material for glandular"):
        phantom_of_labels(labels, {Label.AIR: material("air")})
