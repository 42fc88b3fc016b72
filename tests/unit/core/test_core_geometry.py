"""Grids, rigid motions and meshes agree with themselves."""

import numpy as np
import pytest

from mammosim.core.labels import Label
from mammosim.core.mesh import EDGES, FACES, SUBTETRAHEDRA, TetMesh
from mammosim.core.rigid import IDENTITY, RigidTransform, rotation
from mammosim.core.volume import Grid, Image, LabelMap, grid_around


@pytest.fixture
def oblique() -> Grid:
    return Grid((4, 5, 6), np.array([0.5, 1.0, 2.0]), np.array([-3.0, 7.0, 1.0]), rotation([10, -20, 30]))


def test_index_and_point_are_inverse(oblique):
    indices = np.random.default_rng(1).uniform(0, 3, (20, 3))
    np.testing.assert_allclose(oblique.indices(oblique.points(indices)), indices, atol=1e-12)


def test_centres_follow_array_order(oblique):
    k, j, i = 2, 3, 4
    n = np.ravel_multi_index((k, j, i), oblique.shape)
    expected = oblique.origin + oblique.direction @ (np.array([i, j, k]) * oblique.spacing)
    np.testing.assert_allclose(oblique.centres()[n], expected)


def test_a_grid_around_a_box_covers_it():
    grid = grid_around(np.array([-1.0, 0.0, 2.0]), np.array([4.0, 3.0, 9.5]), 2.0)
    assert grid.shape == (4, 2, 3)
    np.testing.assert_allclose(grid.origin - grid.spacing / 2, [-1, 0, 2])


def test_values_must_fit_their_grid(oblique):
    with pytest.raises(ValueError, match="do not fit the grid"):
        Image(oblique, np.zeros((4, 5, 5), np.float32))


def test_labels_are_whole_numbers(oblique):
    with pytest.raises(ValueError, match="must be integers"):
        LabelMap(oblique, np.zeros(oblique.shape))


def test_a_motion_and_its_inverse_cancel():
    motion = RigidTransform(rotation([3, -2, 5]), np.array([4.0, -1.0, 2.0]))
    points = np.random.default_rng(2).normal(size=(10, 3))
    np.testing.assert_allclose(motion.inverse()(motion(points)), points, atol=1e-12)
    np.testing.assert_allclose(motion.after(motion.inverse()).R, IDENTITY.R, atol=1e-12)


def test_the_angle_of_a_rotation_about_one_axis_is_that_angle():
    assert RigidTransform(rotation([0, 0, 7.0]), np.zeros(3)).angle_deg == pytest.approx(7.0)


def test_a_reflection_is_no_rigid_motion():
    with pytest.raises(ValueError, match="not a rotation"):
        RigidTransform(np.diag([1.0, 1.0, -1.0]), np.zeros(3))


@pytest.fixture
def tetrahedron() -> np.ndarray:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    return np.vstack([vertices, [(vertices[a] + vertices[b]) / 2 for a, b in EDGES]])


def test_eight_subtetrahedra_fill_the_quadratic_one(tetrahedron):
    volumes = [np.linalg.det(tetrahedron[list(t)][1:] - tetrahedron[t[0]]) / 6 for t in SUBTETRAHEDRA]
    np.testing.assert_allclose(volumes, np.full(8, 1 / 48))


def test_faces_point_outward_with_their_own_mid_edge_nodes(tetrahedron):
    for face in FACES:
        a, b, c, ab, bc, ca = tetrahedron[list(face)]
        assert np.cross(b - a, c - a) @ (a - tetrahedron[:4].mean(axis=0)) > 0
        np.testing.assert_allclose([ab, bc, ca], [(a + b) / 2, (b + c) / 2, (c + a) / 2])


def test_a_linear_tetrahedron_is_rejected(tetrahedron):
    with pytest.raises(ValueError, match="quadratic tetrahedra"):
        TetMesh(tetrahedron, np.array([[0, 1, 2, 3]]), np.array([1]))


def shares_of(**given: float) -> np.ndarray:
    """Shares (n_label,) of one cell, by tissue."""
    return np.array([given.get(label.tissue, 0.0) for label in Label])


def test_a_cell_without_shares_is_wholly_of_its_tissue(tetrahedron):
    mesh = TetMesh(tetrahedron, np.arange(10)[None], np.array([Label.GLANDULAR]))
    assert mesh.composition.tolist() == [shares_of(glandular=1).tolist()]


@pytest.mark.parametrize(
    ("shares", "words"),
    [
        ([0.0, 0.5, 0.5], rf"shares \(1, 3\) must be \(n_cell, n_label\) = \(1, {len(Label)}\)"),
        (shares_of(adipose=0.5, glandular=0.6), "sum to 1"),
        (shares_of(adipose=-0.5, glandular=1.5), "positive or zero"),
        (shares_of(adipose=0.7, glandular=0.3), "tissue must be the label of the largest share"),
    ],
)
def test_shares_that_cannot_be_are_rejected(tetrahedron, shares, words):
    with pytest.raises(ValueError, match=words):
        TetMesh(tetrahedron, np.arange(10)[None], np.array([Label.GLANDULAR]), shares=np.array([shares]))
