"""Voxels know where in the mesh they lie, in every configuration."""

import numba
import numpy as np
import pytest

from mammosim.core.errors import MeshError
from mammosim.core.mesh import EDGES, TetMesh
from mammosim.core.rigid import rotation
from mammosim.core.volume import Grid, grid_around
from mammosim.meshing.quality import jacobians
from mammosim.meshing.raster import rasterise

CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
# Weights are stored in single precision: 6e-8 of coordinates up to 100 mm, times ten of them.
SINGLE_MM = 1e-4


def _with_middles(corners: np.ndarray) -> np.ndarray:
    return np.vstack([corners, corners[np.array(EDGES)].mean(axis=1)])


def _one_cell(points: np.ndarray) -> TetMesh:
    return TetMesh(points, np.arange(10)[None], np.ones(1, dtype=np.uint8))


def _cube(n: int = 3, length: float = 60.0) -> TetMesh:
    """n^3 cubes of six tetrahedra each, centred at the origin (Kuhn's division: one per permutation)."""
    corner = np.stack(np.meshgrid(*[np.arange(n)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    paths = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [1, 0, 2], [2, 1, 0]]
    cells = []
    for path in paths:
        steps = np.vstack([np.zeros(3, int), np.cumsum(np.eye(3, dtype=int)[path], axis=0)])
        even = np.linalg.det(steps[1:] - steps[0]) > 0
        cells.append(corner[:, None] + (steps if even else steps[[0, 2, 1, 3]]))
    vertices = np.concatenate(cells)
    edges = vertices[:, np.array(EDGES)].sum(axis=2)  # twice the middle
    keys, cells10 = np.unique(
        np.concatenate([2 * vertices, edges], axis=1).reshape(-1, 3), axis=0, return_inverse=True
    )
    points = keys / 2 * length / n - length / 2
    cells10 = cells10.reshape(-1, 10)
    return TetMesh(points, cells10, np.ones(len(cells10), dtype=np.uint8))


def _centres(grid: Grid, inside: np.ndarray) -> np.ndarray:
    return grid.centres()[inside.ravel()]


def test_every_voxel_of_a_cube_is_inside_once() -> None:
    raster = rasterise(_cube(), grid_around(np.full(3, -40.0), np.full(3, 40.0), 2.0))
    assert raster.inside.sum() == 30**3
    assert raster.cell[raster.inside].max() == 6 * 27 - 1


def test_centres_on_faces_and_edges_do_not_fall_between_elements() -> None:
    grid = Grid((61, 61, 61), np.ones(3), np.full(3, -30.0))  # centres on every face of the cubes
    assert rasterise(_cube(), grid).inside.all()


def test_weights_reproduce_the_voxel_centres_in_a_turned_grid() -> None:
    mesh = _cube()
    grid = Grid(
        (40, 30, 35), np.array([2.0, 2.5, 1.5]), np.array([-30.0, -25, -35]), rotation(np.array([5.0, 9, -7]))
    )
    raster = rasterise(mesh, grid)
    assert np.abs(raster.carry(mesh.points) - _centres(grid, raster.inside)).max() < SINGLE_MM
    np.testing.assert_allclose(raster.weights.sum(axis=1), 1, atol=1e-6)


def test_a_deformed_body_is_carried_back_to_its_reference() -> None:
    # A quadratic map is exact on straight quadratic elements; this one has the inverse X = x - c y^2.
    mesh, c = _cube(), 0.008
    x = mesh.points + c * mesh.points[:, [1]] ** 2 * [1, 0, 0]
    grid = grid_around(x.min(axis=0) - 2, x.max(axis=0) + 2, 1.5)
    raster = rasterise(mesh.moved_to(x), grid)
    centres = _centres(grid, raster.inside)
    reference = centres - c * centres[:, [1]] ** 2 * [1, 0, 0]
    assert np.abs(raster.carry(mesh.points) - reference).max() < SINGLE_MM
    clear = np.abs(grid.centres() - c * grid.centres()[:, [1]] ** 2 * [1, 0, 0]).max(axis=1) - 30
    np.testing.assert_array_equal(
        raster.inside.ravel()[np.abs(clear) > 1e-4], (clear < 0)[np.abs(clear) > 1e-4]
    )


def test_points_of_strongly_curved_elements_are_found() -> None:
    rng = np.random.default_rng(1)
    L = rng.dirichlet([0.7] * 4, 8)
    for _ in range(40):
        x = _with_middles(CORNERS)
        while True:
            bent = x + np.vstack([np.zeros((4, 3)), rng.normal(scale=0.12, size=(6, 3))])
            if jacobians(bent[None], rng.dirichlet([0.5] * 4, 2000)).min() > 0.05:
                break
        a, b = np.array(EDGES).T
        points = np.hstack([L * (2 * L - 1), 4 * L[:, a] * L[:, b]]) @ bent
        for point in points:
            assert rasterise(_one_cell(bent), Grid((1, 1, 1), np.ones(3), point)).inside.all()


def test_where_elements_overlap_the_lowest_number_has_the_voxel() -> None:
    points = _with_middles(CORNERS * 20)
    mesh = TetMesh(np.vstack([points, points]), np.arange(20).reshape(2, 10), np.ones(2, dtype=np.uint8))
    raster = rasterise(mesh, grid_around(np.zeros(3), np.full(3, 20.0), 1.0))
    assert set(np.unique(raster.cell)) == {-1, 0}


def test_the_number_of_threads_changes_nothing() -> None:
    grid = grid_around(np.full(3, -35.0), np.full(3, 35.0), 2.0)
    mesh = _cube()
    mesh = mesh.moved_to(mesh.points + 2 * np.sin(mesh.points[:, ::-1] / 7))
    threads = numba.get_num_threads()
    try:
        numba.set_num_threads(1)
        alone = rasterise(mesh, grid)
    finally:
        numba.set_num_threads(threads)
    together = rasterise(mesh, grid)
    np.testing.assert_array_equal(alone.cell, together.cell)
    np.testing.assert_array_equal(alone.weights, together.weights)


def test_scalars_and_vectors_are_carried_alike() -> None:
    mesh = _cube()
    raster = rasterise(mesh, grid_around(np.full(3, -30.0), np.full(3, 30.0), 6.0))
    field = mesh.points @ [1.0, 2.0, 3.0]
    assert raster.carry(field).shape == (raster.inside.sum(),)
    np.testing.assert_allclose(raster.carry(field), raster.carry(mesh.points) @ [1.0, 2.0, 3.0], atol=1e-3)


def test_a_flat_element_is_rejected() -> None:
    with pytest.raises(MeshError, match="1 elements are flat, the first is number 0"):
        rasterise(_one_cell(_with_middles(CORNERS * [1, 1, 0])), Grid((1, 1, 1), np.ones(3), np.zeros(3)))
