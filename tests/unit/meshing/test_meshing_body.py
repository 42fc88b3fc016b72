"""A body's mesh knows its tissues, what meets the air, and what is held."""

import numpy as np
import pytest

from mammosim.core.errors import MeshError
from mammosim.core.labels import DEFORMABLE, Label
from mammosim.core.mesh import EDGES, TetMesh
from mammosim.core.volume import LabelMap, grid_around
from mammosim.meshing.body import ElementSize, crop_body, mesh_body, shares_of_cells
from mammosim.meshing.boundary import boundary_faces
from mammosim.meshing.quality import quality

SIZE = ElementSize(breast_mm=12.0, chest_mm=16.0)
CROP = {"posterior_limit_mm": 20.0, "height_limits_mm": (-55.0, 60.0)}


@pytest.fixture(scope="module")
def labels() -> LabelMap:
    """A breast of 45 mm radius on a flat chest: fat behind y = -10, muscle behind 0, thorax behind 8."""
    grid = grid_around(np.array([-80.0, -70, -75]), np.array([80.0, 30, 75]), 4.0)
    x, y, z = grid.centres().T
    r = np.sqrt(x**2 + (y + 10) ** 2 + z**2)
    values = np.zeros(len(x), dtype=np.uint8)
    values[(r < 45) | (y > -12)] = Label.SKIN
    values[(r < 42) | (y > -10)] = Label.ADIPOSE
    values[(r < 28) & (y < -8)] = Label.GLANDULAR
    values[y > 0] = Label.MUSCLE
    values[y > 8] = Label.THORAX
    values[(np.hypot(x, z) < 5) & (r > 45) & (r < 50) & (y < -10)] = Label.MARKER
    return LabelMap(grid, values.reshape(grid.shape))


@pytest.fixture(scope="module")
def mesh(labels: LabelMap) -> TetMesh:
    return mesh_body(crop_body(labels, **CROP), size=SIZE)


def _centres_and_normals(mesh: TetMesh, name: str) -> tuple[np.ndarray, np.ndarray]:
    a, b, c = np.moveaxis(mesh.points[mesh.boundaries[name][:, :3]], 1, 0)
    return (a + b + c) / 3, np.cross(b - a, c - a) / 2


def test_skin_and_posterior_share_out_the_whole_boundary(mesh: TetMesh) -> None:
    named = np.concatenate([mesh.boundaries["skin"], mesh.boundaries["posterior"]])
    assert len(named) == len(boundary_faces(mesh.cells))
    normals = np.concatenate([_centres_and_normals(mesh, name)[1] for name in ("skin", "posterior")])
    # The vector area of a closed surface is zero.
    np.testing.assert_allclose(normals.sum(axis=0), 0, atol=1e-6)


def test_skin_points_to_the_front_and_what_is_held_lies_behind_it_or_at_the_cuts(mesh: TetMesh) -> None:
    centre, normal = _centres_and_normals(mesh, "skin")
    assert (centre[:, 1] < 4).all()
    assert (normal[:, 1] < 0).mean() > 0.9
    centre, _ = _centres_and_normals(mesh, "posterior")
    at_cut = (np.abs(centre[:, 0]) > 70) | (centre[:, 2] < -45) | (centre[:, 2] > 50)
    assert ((centre[:, 1] > -2) | at_cut).all()


def test_a_marker_stuck_on_the_skin_does_not_hold_it(mesh: TetMesh) -> None:
    centre, _ = _centres_and_normals(mesh, "posterior")
    assert (centre[:, 1] > -20).all()


def test_tissues_are_where_the_labels_have_them_and_skin_counts_as_adipose(mesh: TetMesh) -> None:
    assert set(np.unique(mesh.tissue)) == {Label.ADIPOSE, Label.GLANDULAR, Label.MUSCLE}
    x, y, z = mesh.points[mesh.cells[:, :4]].mean(axis=1).T
    r = np.sqrt(x**2 + (y + 10) ** 2 + z**2)
    assert (mesh.tissue[(r < 18) & (y < -20)] == Label.GLANDULAR).all()
    assert (mesh.tissue[r > 40] != Label.GLANDULAR).all()
    assert (mesh.tissue[y < -15] != Label.MUSCLE).all()


def test_tissue_volumes_agree_with_the_voxels(mesh: TetMesh, labels: LabelMap) -> None:
    # One label per element of 12 mm blurs a border by half an element; over a ball of 28 mm it averages out.
    volume = quality(mesh)["volume_mm3"].to_numpy()
    gland = (labels.values == Label.GLANDULAR).sum() * labels.grid.voxel_volume
    assert volume[mesh.tissue == Label.GLANDULAR].sum() == pytest.approx(gland, rel=0.15)
    cropped = np.isin(crop_body(labels, **CROP).values, DEFORMABLE).sum() * labels.grid.voxel_volume
    assert volume.sum() == pytest.approx(cropped, rel=0.05)


def test_shares_of_tissues_give_their_volumes_nearer_than_one_label_per_cell(
    mesh: TetMesh, labels: LabelMap
) -> None:
    volume = quality(mesh)["volume_mm3"].to_numpy()
    for label in (Label.GLANDULAR, Label.MUSCLE):
        there = (crop_body(labels, **CROP).values == label).sum() * labels.grid.voxel_volume
        # A cell has 1000 mm3 / 64 = 8 voxels or so: of a whole body their errors cancel.
        assert volume @ mesh.shares[:, label] == pytest.approx(there, rel=0.05)


def test_the_share_above_a_plane_through_a_tetrahedron_is_the_cube_of_its_height() -> None:
    L, h = 60.0, 24.0
    corners = np.array([[0.0, 0, 0], [L, 0, 0], [0, L, 0], [0, 0, L]])
    points = np.vstack([corners, corners[np.array(EDGES)].mean(axis=1)])
    cell = TetMesh(points, np.arange(10)[None], np.array([Label.ADIPOSE]))
    grid = grid_around(np.full(3, -2.0), np.full(3, L + 2), 1.0)
    z = grid.centres()[:, 2].reshape(grid.shape)
    values = np.where(z > h, Label.GLANDULAR, Label.MUSCLE).astype(np.uint8)
    shares = shares_of_cells(cell, LabelMap(grid, values))
    # Its height is known to half a voxel, and so is the plane's: (L - h + 1/2)^3 / (L - 1/2)^3 at most.
    assert shares[0, Label.GLANDULAR] == pytest.approx((1 - h / L) ** 3, rel=3 * (0.5 / (L - h) + 0.5 / L))
    assert shares[0, Label.MUSCLE] == 1 - shares[0, Label.GLANDULAR]


def test_the_nearest_voxel_decides_where_a_cell_has_none(labels: LabelMap) -> None:
    mesh = mesh_body(crop_body(labels, **CROP), size=SIZE)
    tiny = mesh.moved_to(
        np.array([0.0, -30, 0]) + 1e-3 * mesh.points
    )  # between voxel centres, deep in the gland
    assert (shares_of_cells(tiny, labels)[:, Label.GLANDULAR] == 1).all()


def test_the_crop_keeps_air_and_holds_the_cut(labels: LabelMap) -> None:
    cropped = crop_body(labels, **CROP)
    z = labels.grid.centres()[:, 2].reshape(labels.grid.shape)
    cut = (z < -55) | (z > 60)
    assert not np.isin(cropped.values[cut], DEFORMABLE).any()
    np.testing.assert_array_equal(cropped.values[~cut], labels.values[~cut])
    np.testing.assert_array_equal(cropped.values == Label.AIR, labels.values == Label.AIR)


def test_the_same_labels_give_the_same_mesh(mesh: TetMesh, labels: LabelMap) -> None:
    again = mesh_body(crop_body(labels, **CROP), size=SIZE)
    np.testing.assert_array_equal(again.points, mesh.points)
    np.testing.assert_array_equal(again.tissue, mesh.tissue)


def volume_of(labels: LabelMap) -> float:
    """Of the deformable voxels, mm3."""
    return float(np.isin(labels.values, DEFORMABLE).sum() * labels.grid.voxel_volume)


@pytest.mark.parametrize("edge_mm", [12.0, 20.0])
def test_a_mesh_has_the_volume_of_its_labels_however_coarse(labels: LabelMap, edge_mm: float) -> None:
    """The chest beside the breast is a slab of 20 mm, whose edges elements of 20 mm cut off."""
    cropped = crop_body(labels, **CROP)
    mesh = mesh_body(cropped, size=ElementSize(edge_mm, edge_mm))
    assert quality(mesh).volume_mm3.sum() == pytest.approx(volume_of(cropped), rel=1e-3)


def test_two_bodies_are_both_meshed_and_a_stray_is_not(labels: LabelMap) -> None:
    values = labels.values.copy()
    values[:, :, 19:21] = np.where(labels.values[:, :, 19:21] == Label.THORAX, Label.THORAX, Label.AIR)
    apart = LabelMap(labels.grid, values)
    stray = values.copy()
    stray[3:5, 2:4, 3:5] = Label.ADIPOSE
    size = ElementSize(20.0, 20.0)
    mesh = mesh_body(LabelMap(labels.grid, stray), size=size)
    assert quality(mesh).volume_mm3.sum() == pytest.approx(volume_of(apart), rel=1e-3)
    assert mesh.points[:, 0].min() < -70 < 70 < mesh.points[:, 0].max()
    np.testing.assert_array_equal(mesh.points, mesh_body(apart, size=size).points)


def test_finer_voxels_than_the_elements_need_make_the_same_body(labels: LabelMap, mesh: TetMesh) -> None:
    fine = grid_around(np.array([-80.0, -70, -75]), np.array([80.0, 30, 75]), 1.0)
    repeated = labels.values.repeat(4, axis=0).repeat(4, axis=1).repeat(4, axis=2)
    values = repeated[: fine.shape[0], : fine.shape[1], : fine.shape[2]]
    volume = quality(mesh_body(crop_body(LabelMap(fine, values), **CROP), size=SIZE))["volume_mm3"].sum()
    assert volume == pytest.approx(quality(mesh)["volume_mm3"].sum(), rel=0.05)


def test_sizes_in_centimetres_are_rejected() -> None:
    with pytest.raises(MeshError, match=r"breast_mm = 1.2 is outside \[2, 50\] mm"):
        ElementSize(breast_mm=1.2, chest_mm=1.6)
