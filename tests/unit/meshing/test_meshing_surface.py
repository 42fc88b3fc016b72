"""Surfaces of fields and labels are closed, point outward, and lie where the field is zero."""

import numpy as np
import pytest

from mammosim.core.errors import MeshError
from mammosim.core.labels import Label
from mammosim.core.rigid import rotation
from mammosim.core.volume import Grid, LabelMap, grid_around
from mammosim.meshing.surface import Surface, surface_of_field, surface_of_labels

RADIUS = 30.0
BALL = 4 / 3 * np.pi * RADIUS**3


def _distance(
    grid: Grid, centre: tuple[float, float, float] = (0, 0, 0), radius: float = RADIUS
) -> np.ndarray:
    return (np.linalg.norm(grid.centres() - centre, axis=1) - radius).reshape(grid.shape)


def _grid(spacing: float, half: float = 40.0) -> Grid:
    return grid_around(np.full(3, -half), np.full(3, half), spacing)


def _ball(spacing: float) -> LabelMap:
    grid = _grid(spacing)
    return LabelMap(grid, np.where(_distance(grid) < 0, Label.ADIPOSE, Label.AIR).astype(np.uint8))


def test_vertices_lie_on_the_zero_of_the_field_in_patient_coordinates() -> None:
    straight = grid_around(np.full(3, -40.0), np.full(3, 40.0), [2.0, 3.0, 2.5])
    R = rotation(np.array([10.0, -20.0, 30.0]))
    centre = np.array([5.0, -100.0, 20.0])
    grid = Grid(straight.shape, straight.spacing, R @ straight.origin + centre, R)
    surface = surface_of_field(_distance(grid, tuple(centre)), grid)
    # Linear interpolation of a distance between voxels h apart errs by h^2 / (8 R) at most.
    assert np.abs(np.linalg.norm(surface.points - centre, axis=1) - RADIUS).max() < 3.0**2 / (8 * RADIUS)
    assert surface.volume() == pytest.approx(BALL, rel=0.01)


def test_a_body_cut_by_the_border_is_closed_at_the_outer_faces_of_the_voxels() -> None:
    grid = Grid((6, 5, 4), np.array([2.0, 3.0, 4.0]), np.array([1.0, 2.0, 3.0]))
    surface = surface_of_field(np.full(grid.shape, -1.0), grid)
    half = grid.spacing / 2
    np.testing.assert_allclose(surface.points.min(axis=0), grid.origin - half)
    np.testing.assert_allclose(surface.points.max(axis=0), grid.origin + grid.spacing * [3, 4, 5] + half)


def test_only_the_largest_piece_is_kept_and_its_cavities_are_filled() -> None:
    grid = _grid(2.0)
    ball = _distance(grid)
    other = _distance(grid, (35.0, 35.0, 35.0), 4.0)
    hole = -_distance(grid, (0.0, 0.0, 0.0), 8.0)
    alone = surface_of_field(ball, grid)
    surface = surface_of_field(np.maximum(np.minimum(ball, other), hole), grid)
    assert surface.volume() == pytest.approx(alone.volume(), rel=1e-3)


@pytest.mark.parametrize("spacing", [1.5, 2.0, 3.0])
def test_labels_of_a_ball_keep_its_volume_to_one_percent(spacing: float) -> None:
    labels = _ball(spacing)
    voxels = np.count_nonzero(labels.values) * labels.grid.voxel_volume
    # Linear interpolation across the voxels takes about h^2 / (2 R^2), 0.5 % at 3 mm.
    assert surface_of_labels(labels).volume() == pytest.approx(voxels, rel=0.01)


def test_tissue_that_meets_the_thorax_ends_there_with_a_sharp_rim() -> None:
    labels = _ball(2.0)
    y = labels.grid.centres()[:, 1].reshape(labels.grid.shape)
    values = np.where((y > 0) & (labels.values > 0), np.uint8(Label.THORAX), labels.values)
    surface = surface_of_labels(LabelMap(labels.grid, values))
    assert surface.points[:, 1].max() == pytest.approx(0.0, abs=0.1)
    # Within one voxel of the plane lies the rim: it reaches out to the ball's radius, less its bevel.
    rim = surface.points[surface.points[:, 1] > -2.0]
    assert np.hypot(rim[:, 0], rim[:, 2]).max() == pytest.approx(RADIUS, abs=1.0)
    assert surface.volume() == pytest.approx(BALL / 2, rel=0.02)


def test_nothing_inside_is_rejected() -> None:
    grid = _grid(10.0)
    with pytest.raises(MeshError, match="nowhere negative"):
        surface_of_field(np.ones(grid.shape), grid)
    with pytest.raises(MeshError, match="adipose"):
        surface_of_labels(LabelMap(grid, np.zeros(grid.shape, dtype=np.uint8)))


def test_an_open_surface_is_rejected() -> None:
    closed = surface_of_field(_distance(_grid(10.0)), _grid(10.0))
    with pytest.raises(MeshError, match="3 edges"):
        Surface(closed.points, closed.triangles[1:])
