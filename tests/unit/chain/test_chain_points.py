import numpy as np
import pytest

from mammosim.chain.points import MaterialPoints
from mammosim.core.errors import MeshError
from mammosim.core.rigid import rotation


def test_points_of_the_skin_follow_an_affine_motion_of_the_mesh(block):
    mesh = block()
    points = np.array([[4.0, 0.0, 11.3], [30.0, 7.0, 22.0], [12.0, 18.0, 0.0]])  # on three faces of the cube
    F = np.array([[1.2, 0.1, 0.0], [0.0, 0.9, 0.2], [0.1, 0.0, 1.1]])
    held = MaterialPoints.on(mesh, points)
    # Shape functions reproduce linear fields exactly: rounding is all that is left.
    np.testing.assert_allclose(held.carry(mesh.points @ F.T + 5), points @ F.T + 5, atol=1e-9)
    np.testing.assert_allclose(held.offset_mm, 0, atol=1e-9)


def test_points_follow_a_quadratic_motion_of_the_mesh(block):
    mesh = block()
    points = np.array([[4.0, 0.0, 11.3], [17.0, 0.0, 3.0]])

    def bent(X):
        return X + np.stack(
            [0 * X[:, 0], 1e-2 * X[:, 0] ** 2 + 5e-3 * X[:, 0] * X[:, 2], 0 * X[:, 2]], axis=1
        )

    # Quadratic fields are in the span of the shape functions.
    np.testing.assert_allclose(
        MaterialPoints.on(mesh, points).carry(bent(mesh.points)), bent(points), atol=1e-9
    )


def test_a_point_off_the_skin_is_held_by_the_nearest_point_of_the_skin(block):
    mesh = block()
    held = MaterialPoints.on(
        mesh, np.array([[10.0, -3.0, 10.0], [33.0, -4.0, 15.0]])
    )  # over a face, over an edge
    np.testing.assert_allclose(held.carry(mesh.points), [[10, 0, 10], [30, 0, 15]], atol=1e-9)
    np.testing.assert_allclose(held.offset_mm, [3, 5], atol=1e-9)


def test_no_point_of_the_surface_is_nearer_than_the_one_found(block):
    mesh = block()
    rng = np.random.default_rng(5)
    points = rng.uniform(-10, 40, (20, 3))
    points = points[points[:, 1] < 25]
    offset = MaterialPoints.on(mesh, points).offset_mm
    inside = np.all((points > 0) & (points < 30), axis=1)
    box = np.linalg.norm(points - np.clip(points, 0, 30), axis=1)
    wall = np.stack([points[:, 0], 30 - points[:, 0], points[:, 1], points[:, 2], 30 - points[:, 2]]).min(
        axis=0
    )
    np.testing.assert_allclose(offset, np.where(inside, wall, box), atol=1e-9)


def test_balls_above_the_skin_stay_as_high_above_it_when_the_body_turns_and_stretches(block):
    mesh = block()
    balls = np.array([[4.0, -3.5, 11.3], [33.5, 7.0, 22.0], [12.0, 18.0, -2.0]])  # over three faces
    held = MaterialPoints.on(mesh, balls)
    np.testing.assert_allclose(held.normals(mesh.points), [[0, -1, 0], [1, 0, 0], [0, 0, -1]], atol=1e-12)
    turn = rotation(np.array([20.0, -35.0, 50.0]))
    turned = held.carry_above(balls, mesh.points, mesh.points @ turn.T + 4)
    np.testing.assert_allclose(turned, balls @ turn.T + 4, atol=1e-9)
    stretched = held.carry_above(balls, mesh.points, mesh.points * [1.3, 0.8, 1.1])
    # Faces of the block stay where they face; only the places on them, and of them, are stretched.
    np.testing.assert_allclose(stretched, [[5.2, -3.5, 12.43], [42.5, 5.6, 24.2], [15.6, 14.4, -2.0]])


def test_normals_follow_a_face_that_bends(block):
    mesh = block()
    c = 1e-2
    held = MaterialPoints.on(mesh, np.array([[12.0, 0.0, 11.3]]))
    bent = mesh.points + np.stack(
        [0 * mesh.points[:, 0], c * mesh.points[:, 0] ** 2, 0 * mesh.points[:, 0]], 1
    )
    slope = 2 * c * 12.0  # of y = c x^2
    expected = np.array([[slope, -1.0, 0.0]]) / np.hypot(slope, 1)
    np.testing.assert_allclose(held.normals(bent), expected, atol=1e-9)


def test_points_are_held_by_the_boundary_that_is_named(block):
    held = MaterialPoints.on(block(), np.array([[15.0, -3.0, 15.0]]), boundary="posterior")
    np.testing.assert_allclose(held.offset_mm, 33.0)  # of the face at y = 30 mm


def test_a_mesh_without_skin_is_rejected(block):
    with pytest.raises(MeshError, match="no boundary 'areola'"):
        MaterialPoints.on(block(), np.zeros((1, 3)), boundary="areola")
