"""Simple bodies have the volume, the boundaries and the layers that they are asked for."""

from collections import Counter

import numpy as np
import pytest

from mammosim.core.errors import MeshError
from mammosim.core.labels import Label
from mammosim.core.mesh import EDGES, FACES
from mammosim.meshing.boundary import boundary_faces
from mammosim.meshing.quality import quality, require_sound
from mammosim.meshing.shapes import ball_part, box, with_layer
from mammosim.meshing.tetrahedra import quadratic

R = 60.0


@pytest.fixture(scope="module")
def half_ball():
    return ball_part(R, 15.0)


def area(points, faces):
    """Of the straight triangles."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


def volume(mesh, tissue=None):
    rows = quality(mesh)["volume_mm3"].to_numpy()
    return rows.sum() if tissue is None else rows[mesh.tissue == int(tissue)].sum()


def test_a_box_has_its_volume_and_its_two_boundaries():
    mesh = box((2, 3, 4), (10.0, 20.0, 30.0), posterior_axis=1)
    require_sound(mesh)
    assert volume(mesh) == pytest.approx(6000.0)
    assert area(mesh.points, mesh.boundaries["posterior"]) == pytest.approx(300.0)
    assert area(mesh.points, mesh.boundaries["skin"]) == pytest.approx(2200.0 - 300.0)


@pytest.mark.parametrize(("octant", "part"), [(False, 1 / 2), (True, 1 / 8)])
def test_a_part_of_a_ball_has_its_volume(octant, part):
    mesh = ball_part(R, 15.0, octant=octant)
    require_sound(mesh)
    # Arcs of 15 mm as parabolas miss the circle by less than (15 / 60)^4 / 128 of the radius.
    assert volume(mesh) == pytest.approx(part * 4 / 3 * np.pi * R**3, rel=1e-3)


def test_the_same_ball_is_the_same_mesh(half_ball):
    again = ball_part(R, 15.0)
    assert np.array_equal(again.points, half_ball.points)
    assert np.array_equal(again.cells, half_ball.cells)


@pytest.mark.parametrize("thickness", [2.0, 0.1])
def test_a_layer_has_the_volume_between_the_boundary_and_its_image(half_ball, thickness):
    layered = with_layer(half_ball, half_ball.points * (1 + thickness / R))
    shell = volume(half_ball) * ((1 + thickness / R) ** 3 - 1)
    # Uprights and diagonals have their middle half way in radius, where a homothety has it in volume.
    assert volume(layered, Label.SKIN) == pytest.approx(shell, rel=1e-3)
    assert volume(layered, Label.ADIPOSE) == pytest.approx(volume(half_ball))


def test_a_layer_leaves_no_gap_and_names_its_boundaries(half_ball):
    layered = with_layer(half_ball, half_ball.points * (1 + 2.0 / R))
    require_sound(layered)
    radii = np.linalg.norm(layered.points, axis=1)
    assert radii[layered.boundary_nodes("skin")] == pytest.approx(R + 2.0)
    assert radii[layered.boundary_nodes("fascia")] == pytest.approx(R)
    held = layered.boundary_nodes("posterior")
    assert layered.points[held, 2] == pytest.approx(0.0, abs=1e-9)
    named = len(layered.boundaries["skin"]) + len(layered.boundaries["posterior"])
    assert len(boundary_faces(layered.cells)) == named


def test_a_layer_inside_the_body_is_rejected_with_the_number_of_elements(half_ball):
    n = 3 * len(half_ball.boundaries["skin"])
    with pytest.raises(MeshError, match=rf"of {n} elements of the layer are inverted"):
        with_layer(half_ball, half_ball.points * 0.9)


def test_elements_larger_than_the_ball_are_rejected():
    with pytest.raises(MeshError, match=r"edge_mm 70 is outside \(0, radius_mm = 60\]"):
        ball_part(R, 70.0)


def test_the_outside_is_what_one_cell_has_in_the_order_of_cells_and_faces(caplog):
    """Against a count of all faces; the normals point outward, and nothing is logged about the layout."""
    mesh = box((6, 6, 6), (6.0, 5.0, 4.0))
    faces = mesh.cells[:, FACES].reshape(-1, 6)
    count = Counter(tuple(sorted(face)) for face in faces[:, :3].tolist())
    outside = [face for face in faces.tolist() if count[tuple(sorted(face[:3]))] == 1]
    assert boundary_faces(mesh.cells).tolist() == outside
    assert not caplog.records


def test_edges_are_numbered_by_their_sorted_vertices():
    points, cells = quadratic(np.arange(15.0).reshape(5, 3) ** 1.5, np.array([[4, 1, 2, 0], [3, 2, 1, 4]]))
    edges = sorted({tuple(sorted((cell[a], cell[b]))) for cell in cells.tolist() for a, b in EDGES})
    for cell in cells.tolist():
        assert cell[4:] == [5 + edges.index(tuple(sorted((cell[a], cell[b])))) for a, b in EDGES]
    assert np.array_equal(points[5:], [(points[a] + points[b]) / 2 for a, b in edges])
