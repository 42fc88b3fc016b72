import numpy as np
import pytest

from mammosim.core.errors import MeshError
from mammosim.study.points import MaterialPoints


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


def test_a_mesh_without_skin_is_refused(block):
    with pytest.raises(MeshError, match="no boundary 'areola'"):
        MaterialPoints.on(block(), np.zeros((1, 3)), boundary="areola")
