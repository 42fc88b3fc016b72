"""Distances between surfaces are exact on flat triangles and nearly so on curved faces."""

from dataclasses import replace

import numpy as np
import pytest

from mammosim.core.errors import MeshError
from mammosim.core.mesh import EDGES, TetMesh
from mammosim.meshing.boundary import boundary_faces
from mammosim.meshing.distance import (
    NearestOnTriangles,
    distance_opposite,
    distance_to_boundary,
    distance_to_rim,
    rim,
    surface_distance,
)
from mammosim.meshing.shapes import box

CORNERS = np.array([[0.0, 0, 0], [10, 0, 0], [0, 10, 0], [0, 0, 10]])


@pytest.fixture
def mesh() -> TetMesh:
    points = np.vstack([CORNERS, CORNERS[np.array(EDGES)].mean(axis=1)])
    cells = np.arange(10)[None]
    return TetMesh(points, cells, np.ones(1, dtype=np.uint8), {"skin": boundary_faces(cells)})


def test_the_nearest_point_is_on_the_face_the_edge_or_the_corner() -> None:
    nearest, which = NearestOnTriangles(CORNERS[None, :3])(
        np.array([[2.0, 3, 5], [4, -7, 1], [-3, -4, 0], [9, 9, 0]])
    )
    np.testing.assert_allclose(nearest, [[2, 3, 0], [4, 0, 0], [0, 0, 0], [5, 5, 0]], atol=1e-12)
    assert (which == 0).all()


def test_the_nearest_of_many_triangles_agrees_with_trying_all() -> None:
    rng = np.random.default_rng(2)
    corners = rng.normal(size=(300, 1, 3)) * 20 + rng.normal(size=(300, 3, 3)) * 5
    points = rng.normal(size=(100, 3)) * 30
    nearest, which = NearestOnTriangles(corners)(points)
    every = np.stack([NearestOnTriangles(corners[[t]])(points)[0] for t in range(len(corners))])
    distance = np.linalg.norm(every - points, axis=2)
    np.testing.assert_allclose(np.linalg.norm(nearest - points, axis=1), distance.min(axis=0), atol=1e-12)
    np.testing.assert_array_equal(which, distance.argmin(axis=0))


def test_a_mesh_is_at_distance_zero_from_itself(mesh: TetMesh) -> None:
    np.testing.assert_allclose(surface_distance(mesh, mesh), 0, atol=1e-12)


def test_a_shift_beyond_a_flat_face_is_the_distance(mesh: TetMesh) -> None:
    below = mesh.moved_to(mesh.points - [0, 0, 25])
    assert surface_distance(mesh, below).min() == pytest.approx(15.0)


def test_curved_faces_are_followed(mesh: TetMesh) -> None:
    points = mesh.points.copy()
    points[4, 2] -= 1.0  # the middle of the edge 0-1 sags by 1 mm
    # Four straight pieces along the edge: at s = 1/8 the parabola 4 s (1 - s) is 1/16 mm from its chord.
    on_curve = np.array([[10 * s, 0.0, -4 * s * (1 - s)] for s in (0.125, 0.25, 0.5, 0.625)])
    assert distance_to_boundary(on_curve, mesh.moved_to(points)).max() < 1 / 16


def test_a_missing_boundary_is_named(mesh: TetMesh) -> None:
    with pytest.raises(MeshError, match="no boundary 'skin'; it has: none"):
        surface_distance(mesh, replace(mesh, boundaries={}))


def slab(half_mm: float, top_mm: float = 0.0) -> TetMesh:
    """A flat slab about the origin, 2 half_mm wide along x and y; only its upper face is skin."""
    block = box((4, 4, 1), (2 * half_mm, 2 * half_mm, 10.0))
    points = block.points + [-half_mm, -half_mm, top_mm - 10.0]
    upper = np.all(points[block.boundaries["skin"]][..., 2] == top_mm, axis=1)
    return replace(block, points=points, boundaries={"skin": block.boundaries["skin"][upper]})


def test_only_skin_opposite_the_other_skin_has_a_distance_to_it() -> None:
    wide, narrow = slab(40.0), slab(25.0, top_mm=3.0)
    opposite = distance_opposite(wide, narrow)
    inside = np.abs(wide.points[wide.boundary_nodes("skin"), :2]).max(axis=1) < 25.0
    np.testing.assert_array_equal(np.isfinite(opposite), inside)
    np.testing.assert_allclose(opposite[inside], 3.0, atol=1e-12)
    # The narrow one has the wide one opposite it everywhere, its own rim included.
    np.testing.assert_allclose(distance_opposite(narrow, wide), 3.0, atol=1e-12)


def test_a_closed_skin_has_no_rim(mesh: TetMesh) -> None:
    assert len(rim(mesh.boundaries["skin"])) == 0
    assert np.isinf(distance_to_rim(mesh)).all()
    np.testing.assert_allclose(distance_opposite(mesh, mesh), 0, atol=1e-12)


def test_the_rim_of_a_flat_skin_is_its_edge() -> None:
    flat = slab(40.0)
    at = np.abs(flat.points[flat.boundary_nodes("skin"), :2]).max(axis=1)
    assert len(rim(flat.boundaries["skin"])) == 16  # four elements along each of four sides
    np.testing.assert_allclose(distance_to_rim(flat), 40.0 - at, atol=1e-9)
