import numpy as np
import pytest

from mammosim.figures.render import Camera, Solid, render
from mammosim.figures.slices import extent_of, slice_of
from mammosim.figures.surfaces import balls_solid, boundary_triangles, box_solid, cut_solid, outline

FRONT = Camera.at(0, 0)


def test_in_front_of_the_patient_her_left_is_at_the_right_and_her_head_above():
    right, up, towards = FRONT.project(np.eye(3)).T
    np.testing.assert_allclose(right, [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(up, [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(towards, [0, -1, 0], atol=1e-12)


def test_what_is_nearer_hides_what_is_behind():
    square = np.array([[0, 1, 2], [0, 2, 3]])
    corners = np.array([[-20.0, 0, -20], [20, 0, -20], [20, 0, 20], [-20, 0, 20]])
    near, far = Solid.of(corners - [0, 10, 0], square, "#ff0000"), Solid.of(corners, square, "#0000ff")
    for order in ((near, far), (far, near)):
        picture = render(order, FRONT, columns=20)
        r, _, b, a = picture.rgba[picture.rgba.shape[0] // 2, 10]
        assert a == 1
        assert r > 3 * b


def test_a_ball_covers_the_area_of_its_disc():
    picture = render((balls_solid(np.zeros((1, 3)), "#888888", radius_mm=20.0),), FRONT, columns=200)
    pixel = (picture.extent[1] - picture.extent[0]) / 200
    # A polyhedron of 24 meridians covers 1 - (2 pi / 24)^2 / 6 of the disc at least.
    assert picture.rgba[..., 3].sum() * pixel**2 == pytest.approx(np.pi * 400, rel=0.03)


def test_a_see_through_plate_lets_the_tissue_behind_shine_through():
    ball = balls_solid(np.zeros((1, 3)), "#ff0000", radius_mm=10.0)
    plate = box_solid(np.array([0.0, -20, 0]), np.eye(3), np.array([20.0, 2, 20]))
    picture = render((ball, plate), FRONT, columns=60)
    middle, corner = picture.rgba[picture.rgba.shape[0] // 2, 30], picture.rgba[12, 12]
    assert middle[0] > 1.3 * middle[2]
    assert corner[3] == pytest.approx(0.3, abs=0.01)


def test_an_outline_lies_in_its_plane_and_on_the_skin(torso):
    mesh = torso.mesh
    segments = outline(mesh.points, boundary_triangles(mesh.boundaries["skin"]), 0, 40.0)
    np.testing.assert_allclose(segments[..., 0], 40.0, atol=1e-9)
    # The skin is one strip from below to above: its outline has two free ends.
    ends, count = np.unique(np.round(segments.reshape(-1, 3), 6), axis=0, return_counts=True)
    assert np.count_nonzero(count == 1) == 2
    assert np.ptp(ends[:, 2]) == pytest.approx(190)


def test_a_cut_shows_only_elements_on_its_side_and_closes_them(torso):
    mesh = torso.mesh
    kept = mesh.points[mesh.cells[:, :4]].mean(axis=1)[:, 0] < 75
    solid = cut_solid(mesh, kept)
    p = solid.points[solid.triangles]
    area = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]).sum(axis=0)
    # A closed surface has no net area; coordinates of 1e2 and 1e3 triangles leave rounding of 1e-10.
    np.testing.assert_allclose(area, 0, atol=1e-7)


def test_a_slice_is_the_one_nearest_to_the_asked_place(torso):
    image = torso.image
    k = 7
    z = image.grid.origin[2] + k * image.grid.spacing[2]
    np.testing.assert_array_equal(slice_of(image, "axial", z + 1.0), image.values[k])


def test_the_extent_of_a_slice_covers_whole_voxels(torso):
    grid = torso.image.grid
    left, right, low, high = extent_of(grid, "sagittal")
    assert right - left == pytest.approx(grid.shape[1] * grid.spacing[1])
    assert high - low == pytest.approx(grid.shape[0] * grid.spacing[2])
