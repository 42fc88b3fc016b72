from dataclasses import replace

import numpy as np
import pytest
from conftest import front, wall
from skimage.measure import perimeter
from skimage.morphology import convex_hull_image

from mammosim.figures.bodies import (
    balls_solid,
    boundary_triangles,
    box_solid,
    coloured_skin,
    cut_solids,
    section,
    skin_solid,
    tissue_rgb,
)
from mammosim.figures.render import Camera, Solid, render
from mammosim.figures.slices import extent_of, slice_of
from mammosim.figures.surfaces import outline, pieces

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


def block(torso):
    """The torso straightened: 300 by 40 by 190 mm."""
    x, y, z = torso.mesh.points.T
    depth = (y - front(x, z, 52.0)) / (wall(x) - front(x, z, 52.0))
    return torso.mesh.moved_to(np.stack([x, 40 * depth, z], axis=1))


@pytest.mark.parametrize("x", [-149.0, 0.0, 12.3, 75.0, 149.0])
def test_a_section_lies_in_its_plane_faces_the_viewer_and_has_the_area_of_the_body(torso, x):
    points, triangles, cells = section(block(torso), x)
    np.testing.assert_allclose(points[:, 0], x, atol=1e-9)
    p = points[triangles]
    area = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])[:, 0] / 2
    assert (area >= 0).all()
    assert area.sum() == pytest.approx(40 * 190)
    ends = block(torso).points[torso.mesh.cells[cells]][:, :, 0]
    assert np.all((ends.min(axis=1) <= x) & (ends.max(axis=1) >= x)), "of the cell that is cut there"


def test_a_section_between_layers_is_cut_also_where_nodes_lie_in_the_plane(torso):
    points, triangles, _ = section(block(torso), float(torso.mesh.points[0, 0] + 300 / 16 * 3))
    p = points[triangles]
    area = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum() / 2
    assert area == pytest.approx(40 * 190)


def test_a_cut_shows_nothing_beyond_it_and_the_true_colours_on_it(torso):
    seen = Camera.at(90, 0)
    rgb = tissue_rgb(torso.mesh.tissue)
    picture = render(cut_solids(block(torso), 75.0, rgb), seen, columns=120)
    shown = picture.rgba[picture.rgba[..., 3] == 1][:, :3]
    same = (np.abs(shown[:, None] - np.unique(rgb, axis=0)[None]).max(axis=2) < 1e-3).any(axis=1)
    assert same.mean() > 0.8, "but for its outline, the picture is the section, in the colours of the legend"
    outside, _ = cut_solids(torso.mesh, 75.0, rgb)
    oblique = render((outside,), Camera.at(0, 0), columns=100, extent=(-160, 160, -100, 100))
    covered = np.flatnonzero((oblique.rgba[..., 3] > 0.5).any(axis=0))
    assert -160 + (covered.max() + 1) * 3.2 == pytest.approx(75, abs=3.2)


def torn(torso):
    """The same body, of whose skin every other face along the rim counts as held."""
    skin = torso.mesh.boundaries["skin"]
    x, _, z = torso.mesh.points[skin[:, :3]].mean(axis=1).T
    rim = (np.abs(z) > 78) | (np.abs(x) > 134)
    lost = rim & (np.arange(len(skin)) % 2 == 0)
    held = np.vstack([torso.mesh.boundaries["posterior"], skin[lost]])
    return replace(torso.mesh, boundaries={"skin": skin[~lost], "posterior": held})


def roughness(picture) -> float:
    """Length of the outline over that of the convex hull."""
    body = np.pad(picture.rgba[..., 3] > 0.5, 2)
    return float(perimeter(body) / perimeter(convex_hull_image(body)))


def test_the_skin_has_a_smooth_rim_though_its_faces_end_in_teeth(torso):
    mesh = torn(torso)
    raw = Solid.of(mesh.points, boundary_triangles(mesh.boundaries["skin"]), "#888888")
    assert roughness(render((raw,), FRONT, columns=300)) > 1.3
    assert roughness(render((skin_solid(mesh),), FRONT, columns=300)) < 1.08
    whole = render((skin_solid(torso.mesh),), FRONT, columns=300, extent=(-160, 160, -100, 100))
    covered = (whole.rgba[..., 3] > 0.5).mean() * 320 * 200
    assert covered > 0.6 * 300 * 190, "and most of it is there, but for an element along the rim"


def test_colours_of_the_skin_stay_with_their_faces(torso):
    skin = torso.mesh.boundaries["skin"]
    left = torso.mesh.points[skin[:, :3]].mean(axis=1)[:, 0] > 0
    rgb = np.where(left[:, None], (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    picture = render((coloured_skin(torso.mesh, rgb),), FRONT, columns=100, extent=(-160, 160, -100, 100))
    r, _, b = picture.rgba[picture.rgba.shape[0] // 2, [30, 70], :3].T
    assert r[0] > 3 * b[0]
    assert b[1] > 3 * r[1]


def test_pieces_of_an_outline_are_joined_and_scraps_are_left_out():
    square = np.array([[0.0, 0, 0], [50, 0, 0], [50, 50, 0], [0, 50, 0]])
    loop = np.stack([square, np.roll(square, -1, axis=0)], axis=1)
    scrap = np.array([[[90.0, 0, 0], [95, 0, 0]], [[100, 0, 0], [95, 0, 0]]])
    line = np.array([[[0.0, 80, 0], [20, 80, 0]], [[40, 80, 0], [20, 80, 0]]])
    found = pieces(np.vstack([loop[[2, 0]], scrap, loop[[1, 3]][:, ::-1], line]))
    assert sorted(len(each) for each in found) == [3, 5]
    (closed,) = [each for each in found if len(each) == 5]
    np.testing.assert_array_equal(closed[0], closed[-1])
    (open_one,) = [each for each in found if len(each) == 3]
    assert sorted(open_one[:, 0]) == list(open_one[:, 0]) or sorted(-open_one[:, 0]) == list(-open_one[:, 0])


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
