"""Tetrahedra fill a surface at the asked size, the same each time."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from mammosim.core.errors import MeshError
from mammosim.core.mesh import EDGES, TetMesh
from mammosim.core.volume import grid_around
from mammosim.meshing.quality import quality, require_sound
from mammosim.meshing.remesh import remeshed
from mammosim.meshing.surface import Surface, surface_of_field
from mammosim.meshing.tetrahedra import mesh_surface

SEMI_AXES = np.array([50.0, 35.0, 30.0])


@pytest.fixture(scope="module")
def ellipsoid() -> Surface:
    grid = grid_around(-SEMI_AXES - 5, SEMI_AXES + 5, 2.5)
    field = (np.linalg.norm(grid.centres() / SEMI_AXES, axis=1) - 1) * SEMI_AXES.min()
    return surface_of_field(field.reshape(grid.shape), grid)


@pytest.fixture(scope="module")
def mesh(ellipsoid: Surface) -> TetMesh:
    return mesh_surface(ellipsoid, size=12.0)


def _edge_lengths(mesh: TetMesh) -> np.ndarray:
    a, b = np.array(EDGES).T
    return np.linalg.norm(mesh.points[mesh.cells[:, a]] - mesh.points[mesh.cells[:, b]], axis=2)


def test_the_mesh_is_sound_and_its_elements_are_well_shaped(mesh: TetMesh) -> None:
    require_sound(mesh)
    # Below a mean ratio of 0.2 the conditioning of an element suffers by more than an order of magnitude.
    assert quality(mesh)["mean_ratio"].min() > 0.2


def test_edges_have_the_asked_length(mesh: TetMesh) -> None:
    assert np.median(_edge_lengths(mesh)) == pytest.approx(12.0, rel=0.1)


def test_flat_triangles_keep_the_volume_within_a_percent(mesh: TetMesh, ellipsoid: Surface) -> None:
    # Inscribed triangles with edges of 12 mm would lose about 3 h^2 / (8 R^2), R from 30 to 50 mm: 4 %.
    assert quality(mesh)["volume_mm3"].sum() == pytest.approx(ellipsoid.volume(), rel=0.01)


def test_nodes_between_corners_lie_in_the_middle(mesh: TetMesh) -> None:
    middles = mesh.points[mesh.cells[:, np.array(EDGES)]].mean(axis=2)
    np.testing.assert_allclose(mesh.points[mesh.cells[:, 4:]], middles, atol=1e-12)


def test_the_size_may_vary_in_space(ellipsoid: Surface) -> None:
    corners = remeshed(ellipsoid, lambda points: np.where(points[:, 0] > 0, 7.0, 14.0)).corners()
    length = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    x = corners[:, :, 0].mean(axis=1)
    assert np.median(length[x > 15]) == pytest.approx(7.0, rel=0.1)
    assert np.median(length[x < -15]) == pytest.approx(14.0, rel=0.1)


def test_the_same_surface_gives_the_same_mesh_in_any_thread_without_a_word(
    ellipsoid: Surface, mesh: TetMesh, capfd: pytest.CaptureFixture[str]
) -> None:
    with ThreadPoolExecutor(1) as pool:
        again = pool.submit(mesh_surface, ellipsoid, size=12.0).result()
    np.testing.assert_array_equal(again.points, mesh.points)
    np.testing.assert_array_equal(again.cells, mesh.cells)
    assert capfd.readouterr() == ("", "")


def test_remeshed_triangles_are_nearly_equilateral(ellipsoid: Surface) -> None:
    corners = remeshed(ellipsoid, lambda points: np.full(len(points), 10.0)).corners()
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    shape = 4 * np.sqrt(3) * area / (edges**2).sum(axis=1)  # 1 for an equilateral triangle
    assert shape.min() > 0.5
    assert shape.mean() > 0.93


def test_a_size_that_is_not_positive_is_rejected(ellipsoid: Surface) -> None:
    with pytest.raises(MeshError, match="-1 mm must be positive"):
        mesh_surface(ellipsoid, size=-1.0)
