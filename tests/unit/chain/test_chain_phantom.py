from types import SimpleNamespace

import numpy as np
import pytest
from small_breast import small_chain

from mammosim.chain.phantom import (
    Lesion,
    conservation_table,
    field_box,
    field_grid,
    material_volume,
    skin_depth,
    voxel_breast,
    with_lesion,
)
from mammosim.core.errors import MeshError
from mammosim.core.labels import Label
from mammosim.core.rigid import RigidTransform, rotation
from mammosim.core.volume import LabelMap, grid_around

EVERYWHERE = (np.full(3, -np.inf), np.full(3, np.inf))
DENSITY = {Label.ADIPOSE: 0.95, Label.GLANDULAR: 1.02}


def squeezed(mesh):
    """Half as high along z, wider along x and y so that the volume falls by 2 %."""
    s = np.sqrt(0.98 / 0.5)
    return mesh.moved_to(mesh.points * [s, s, 0.5]), np.array([s, s, 0.5])


@pytest.fixture
def segmented():
    """Fat, and gland where x < 12 mm, in voxels of 1 mm."""
    grid = grid_around(np.full(3, -4.0), np.full(3, 34.0), 1.0)
    p = grid.centres().reshape(*grid.shape, 3)
    inside = np.all((p > 0) & (p < 30), axis=-1)
    values = np.where(inside, np.where(p[..., 0] < 12, Label.GLANDULAR, Label.ADIPOSE), Label.AIR)
    return LabelMap(grid, values.astype(np.uint8))


def test_material_points_sum_to_the_volume_of_each_shape(block):
    mesh = block()
    deformed, s = squeezed(mesh)
    body = material_volume(deformed, mesh.points)
    assert body.dV.sum() == pytest.approx(30.0**3, rel=1e-12)
    assert body.dv.sum() == pytest.approx(30.0**3 * s.prod(), rel=1e-12)


def test_material_points_integrate_the_volume_of_curved_elements(block):
    mesh = block()
    X = mesh.points
    bent = X + np.stack([2e-3 * X[:, 1] ** 2, 0 * X[:, 0], 1e-3 * X[:, 0] * X[:, 1]], axis=1)
    body = material_volume(mesh.moved_to(bent), X)
    # dx/dX is [[1, ay, 0], [0, 1, 0], [by, bx, 1]], of determinant 1 everywhere.
    np.testing.assert_allclose(body.dv.sum(), 30.0**3, rtol=1e-10)


def test_voxels_take_the_tissue_that_was_measured_where_they_came_from(block, segmented):
    mesh = block()
    deformed, s = squeezed(mesh)
    grid = field_grid(deformed, *EVERYWHERE, voxel_mm=1.0)
    phantom = voxel_breast(deformed, mesh.points, segmented, grid=grid, skin_mm=0.0)
    p = grid.centres().reshape(*grid.shape, 3) / s
    clear = np.all((p > 1) & (p < 29), axis=-1) & (np.abs(p[..., 0] - 12) > 1)
    expected = np.where(p[..., 0] < 12, Label.GLANDULAR, Label.ADIPOSE)
    np.testing.assert_array_equal(phantom.values[clear], expected[clear])


def test_the_phantom_has_air_around_it_and_is_cut_where_the_field_ends(block, segmented):
    mesh = block()
    high = np.array([np.inf, 20.0, np.inf])
    grid = field_grid(mesh, np.full(3, -np.inf), high, voxel_mm=1.0)
    values = voxel_breast(mesh, mesh.points, segmented, grid=grid, skin_mm=1.5).values
    assert not values[0].any()
    assert not values[-1].any()
    assert not values[:, 0].any()
    assert values[2:-2, -1, 2:-2].all()  # tissue up to the edge of the field
    assert (values[4:-4, -1, 4:-4] != Label.SKIN).all()  # and no skin on the cut


def test_skin_is_the_outermost_layer_of_the_asked_thickness_but_not_on_the_held_side(block, segmented):
    mesh = block()
    grid = field_grid(mesh, *EVERYWHERE, voxel_mm=0.5)
    values = voxel_breast(mesh, mesh.points, segmented, grid=grid, skin_mm=1.5).values
    y = grid.origin[1] + grid.spacing[1] * np.arange(grid.shape[1])
    column = values[grid.shape[0] // 2, :, grid.shape[2] // 2]
    np.testing.assert_array_equal(column == Label.SKIN, (y > 0) & (y < 1.5))


def test_skin_lies_along_the_plates_even_where_the_contact_lets_it_in_a_little(block, segmented):
    mesh = block()  # from 0 to 30 mm along z
    low, high = field_box("left", midline_mm=-5.0, chest_wall_mm=15.0, bottom_mm=0.2, top_mm=29.8)
    grid = field_grid(mesh, low, high, voxel_mm=0.5)
    values = voxel_breast(mesh, mesh.points, segmented, grid=grid, skin_mm=1.5).values
    z = grid.origin[2] + grid.spacing[2] * np.arange(grid.shape[0])
    column = values[:, grid.shape[1] // 2, grid.shape[2] // 2]
    np.testing.assert_array_equal(column == Label.SKIN, ((z > 0) & (z < 1.5)) | ((z > 28.5) & (z < 30)))


def test_skin_depth_is_the_distance_to_the_skin_to_half_a_voxel(block):
    mesh = block()
    grid = field_grid(mesh, *EVERYWHERE, voxel_mm=1.0)
    p = grid.centres().reshape(*grid.shape, 3)
    inside = np.all((p > 0) & (p < 30), axis=-1)
    depth = skin_depth(mesh, inside, grid)[inside]
    x, y, z = p[inside].T
    exact = np.min([x, 30 - x, y, z, 30 - z], axis=0)
    assert np.abs(depth - exact).max() <= 0.5 + 1e-9


def test_volume_and_mass_are_conserved_from_the_measured_shape_to_the_voxels(block, segmented):
    mesh = block()
    deformed, _ = squeezed(mesh)
    grid = field_grid(deformed, *EVERYWHERE, voxel_mm=0.5)
    phantom = voxel_breast(deformed, mesh.points, segmented, grid=grid, skin_mm=0.0)
    table = conservation_table(deformed, mesh.points, segmented, phantom, density_g_cm3=DENSITY)
    change = table.set_index(["quantity", "tissue", "step"]).relative_change
    # The deformation takes 2 % of every volume. The sample points see the border of the gland to a hundredth.
    assert change["volume_mm3", "all", "deformation"] == pytest.approx(-0.02, abs=1e-9)
    assert change["volume_mm3", "glandular", "deformation"] == pytest.approx(-0.02, abs=1e-9)
    # A surface of 0.5 mm voxels is off by at most half a voxel on each side of 15 mm.
    assert abs(change["volume_mm3", "all", "voxels"]) < 0.02
    mass = table[(table.quantity == "mass_g") & (table.tissue == "all")].iloc[0]
    assert mass.before == pytest.approx(30**2 * (12 * 1.02 + 18 * 0.95) / 1e3, rel=0.01)
    assert mass.relative_change == pytest.approx(-0.02, abs=0.02)


def test_only_the_part_inside_the_field_is_accounted_for(block, segmented):
    mesh = block()
    low, high = np.full(3, -np.inf), np.array([15.0, np.inf, np.inf])
    grid = field_grid(mesh, low, high, voxel_mm=0.5)
    phantom = voxel_breast(mesh, mesh.points, segmented, grid=grid, skin_mm=0.0)
    row = conservation_table(mesh, mesh.points, segmented, phantom, density_g_cm3=DENSITY).iloc[0]
    # Half of the cube; sample points are 3 mm apart, 30 of them across the cut.
    assert row.before == pytest.approx(30**3 / 2, rel=0.03)


def test_a_lesion_moves_with_the_tissue_and_keeps_its_volume_times_J(block, segmented):
    mesh = block()
    deformed, s = squeezed(mesh)
    grid = field_grid(deformed, *EVERYWHERE, voxel_mm=0.5)
    phantom = voxel_breast(deformed, mesh.points, segmented, grid=grid, skin_mm=1.0)
    lesion = Lesion(np.array([15.0, 12.0, 16.0]), 5.0)
    values = with_lesion(phantom, deformed, mesh.points, lesion).values
    where = grid.points(np.argwhere(values == Label.LESION).astype(float))
    np.testing.assert_allclose(where.mean(axis=0), lesion.centre * s, atol=0.05)
    # About 4000 voxels, 1500 of them on the surface, each in or out by a fair coin: 20 / 4000 is one sigma.
    assert len(where) * grid.voxel_volume == pytest.approx(lesion.volume_mm3 * s.prod(), rel=0.02)
    assert np.ptp(where[:, 2]) < np.ptp(where[:, 0]) / 2


def test_the_lesion_of_a_breast_lies_straight_behind_her_nipple_as_she_was_measured(block, repository):
    measured, motion = block(), RigidTransform(rotation(np.array([10.0, 20.0, -30.0])), np.full(3, 4.0))
    mesh = measured.moved_to(motion(measured.points))
    grid = field_grid(mesh, *EVERYWHERE, voxel_mm=1.0)
    given = {
        "breast": SimpleNamespace(nipple=np.array([14.0, 0.0, 16.0]), to_reference=motion),
        **{"mesh": mesh, "pressed": SimpleNamespace(mesh=mesh)},
        "healthy_phantom": LabelMap(grid, np.full(grid.shape, Label.ADIPOSE, np.uint8)),
    }
    chain = small_chain(repository).with_settings({"xray.lesion": {"diameter_mm": 8.0, "depth_mm": 12.0}})
    values = chain.given(given)["phantom"].values
    where = motion.inverse()(grid.points(np.argwhere(values == Label.LESION).astype(float)))
    np.testing.assert_allclose(where.mean(axis=0), [14.0, 12.0, 16.0], atol=0.2)
    assert np.linalg.norm(where - [14.0, 12.0, 16.0], axis=1).max() <= 4.0 + 1e-9


def test_a_lesion_outside_the_breast_is_rejected(block, segmented):
    mesh = block()
    grid = field_grid(mesh, *EVERYWHERE, voxel_mm=1.0)
    phantom = voxel_breast(mesh, mesh.points, segmented, grid=grid, skin_mm=1.0)
    with pytest.raises(MeshError, match="move it into the breast"):
        with_lesion(phantom, mesh, mesh.points, Lesion(np.array([90.0, 0, 0]), 4.0))


def test_a_field_without_tissue_is_rejected(block):
    with pytest.raises(MeshError, match="move the X-ray field"):
        field_grid(block(), np.full(3, 100.0), np.full(3, 200.0), voxel_mm=1.0)
