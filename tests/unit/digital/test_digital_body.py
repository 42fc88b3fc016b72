"""The loaded body: points are carried back to the stress-free reference where the anatomy is known."""

import numpy as np
import pytest
from scipy import ndimage

from mammosim.core.labels import Label
from mammosim.core.mesh import TetMesh
from mammosim.core.rigid import RigidTransform, rotation
from mammosim.core.volume import grid_around
from mammosim.digital.body import AtRest, Loaded, skin_map
from mammosim.digital.loading import truth_mesh

MOVED = RigidTransform(rotation(np.array([2.0, -1.0, 3.0])), np.array([3.0, -2.0, 5.0]))


@pytest.fixture(scope="module")
def mesh(anatomies) -> TetMesh:
    return truth_mesh(anatomies["small"], breast_mm=14.0, chest_mm=20.0)


@pytest.fixture(scope="module")
def grid():
    return grid_around(np.array([-160.0, -110.0, -108.0]), np.array([160.0, 72.0, 108.0]), 4.0)


def sagged(mesh: TetMesh, anatomy) -> np.ndarray:
    """A made-up smooth displacement of up to 15 mm that vanishes on the chest and near the cuts."""
    free = np.maximum(anatomy.rib_distance(mesh.points) - 8, 0) / 50
    edge = np.clip(-anatomy.region_field(mesh.points) / 40 - 0.5, 0, 1)
    free[mesh.boundary_nodes("posterior")] = 0
    return mesh.points + (free * edge)[:, None] * np.array([0.0, -15.0, -10.0])


def test_an_unloaded_body_looks_as_at_rest(anatomies, mesh, grid):
    anatomy = anatomies["small"]
    rest = AtRest(anatomy, MOVED).materials(grid)
    loaded = Loaded(anatomy, MOVED, mesh, mesh.points).materials(grid)
    # Both ask the same anatomy at the same points, up to rounding where a boundary passes through a point.
    assert (rest != loaded).mean() < 1e-5


def test_moved_tissue_leaves_air_behind_and_no_holes(anatomies, mesh, grid):
    anatomy = anatomies["small"]
    body = Loaded(anatomy, MOVED, mesh, sagged(mesh, anatomy))
    air = np.pad(body.materials(grid) == Label.AIR, ((0, 0), (1, 0), (1, 1)), constant_values=True)
    pieces, n = ndimage.label(air)
    assert n == 1, f"air in {n} pieces of {np.bincount(pieces.ravel())[1:]} voxels"


def test_tissue_is_found_where_the_mesh_carried_it(anatomies, mesh):
    anatomy = anatomies["small"]
    x = sagged(mesh, anatomy)
    around = grid_around(np.array([40.0, -100.0, -40.0]), np.array([110.0, -40.0, 40.0]), 2.0)
    body = Loaded(anatomy, RigidTransform(np.eye(3), np.zeros(3)), mesh, x)
    gland = around.centres()[body.materials(around).ravel() == Label.GLANDULAR]
    rest = AtRest(anatomy, body.moved)
    at_rest = around.centres()[rest.materials(around).ravel() == Label.GLANDULAR]
    shift = gland.mean(axis=0) - at_rest.mean(axis=0)
    # Gland lies 20 to 40 mm before the rib cage: it moves by (20 to 40 - 8) / 50 of (0, -15, -10).
    assert -10 < shift[1] < -3
    assert -7 < shift[2] < -2


def test_fiducials_ride_on_the_skin(anatomies, mesh):
    anatomy = anatomies["small"]
    rest = AtRest(anatomy, MOVED).fiducials()
    still = Loaded(anatomy, MOVED, mesh, mesh.points).fiducials()
    assert rest.names == still.names
    np.testing.assert_allclose(still.points, rest.points, atol=1e-9)
    normals = Loaded(anatomy, MOVED, mesh, mesh.points).normals()
    # Flat facets of 7 mm on a body of radius 35 mm or more turn by up to half their angle, 3.5 / 35 rad; but
    # within an element of a cut, 20 mm, they may bevel its rim, by chance of the mesh.
    cosines = np.einsum("ij,ij->i", normals, AtRest(anatomy, MOVED).normals())[:10]
    away = anatomy.region_field(MOVED.inverse()(rest.points[:10])) < -20.0
    assert away.sum() == 7
    assert (cosines[away] > np.cos(0.2)).all()


def test_the_skin_map_is_exact_for_a_rigid_motion_and_its_own_inverse(mesh):
    turned = RigidTransform(rotation(np.array([20.0, 10.0, -15.0])), np.array([5.0, 6.0, 7.0]))
    above = skin_map(mesh, turned(mesh.points))
    X = above.C[::7] + np.array([0.3, -0.2, 0.1])
    pushed, _ = above.pushed(X)
    np.testing.assert_allclose(pushed, turned(X), atol=1e-9)
    near, pulled = above.pulled(pushed, 5.0)
    assert near.all()
    np.testing.assert_allclose(pulled, X, atol=1e-9)


def test_the_skin_map_keeps_volume(mesh):
    stretched = skin_map(mesh, mesh.points * np.array([1.2, 0.9, 1.1]))
    np.testing.assert_allclose(np.linalg.det(stretched.A), 1.0, atol=1e-9)


def test_far_points_are_not_carried_by_the_skin(mesh):
    near, pulled = skin_map(mesh, mesh.points).pulled(np.array([[0.0, -500.0, 0.0]]), 8.0)
    assert not near.any()
    assert pulled.shape == (0, 3)


def test_the_mesh_of_the_truth_has_the_volumes_of_the_anatomy(anatomies, mesh):
    anatomy = anatomies["small"]
    spaced = grid_around(np.array([-165.0, -110.0, -102.0]), np.array([165.0, 42.0, 102.0]), 3.0)
    points = spaced.centres()
    volume = (anatomy.soft_tissue_field(points) < 0).sum() * spaced.voxel_volume
    edges = mesh.points[mesh.cells[:, 1:4]] - mesh.points[mesh.cells[:, :1]]
    # Flat facets of 20 mm on a shell 16.5 mm thick: chords of both faces nearly cancel, edges are rounded.
    assert np.linalg.det(edges).sum() / 6 == pytest.approx(volume, rel=0.03)


def test_skin_meets_air_and_all_other_faces_are_held(anatomies, mesh):
    anatomy = anatomies["small"]
    skin = mesh.points[mesh.boundaries["skin"]].mean(axis=1)
    # Chords of 20 mm facets on a radius of 100 mm: 20^2 / (8 * 100) = 0.5 mm; the nipple's tip is not meshed.
    assert np.quantile(np.abs(anatomy.outer_field(skin)), 0.95) < 1.0
    assert (anatomy.rib_distance(skin) > anatomy.patient.chest.muscle_mm).all()
    # Together they close the body: the area vectors of a closed surface sum to zero.
    corners = np.concatenate([mesh.points[faces[:, :3]] for faces in mesh.boundaries.values()])
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    np.testing.assert_allclose(normals.sum(axis=0), 0, atol=1e-6 * np.abs(normals).sum())
