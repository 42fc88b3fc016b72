"""Surfaces and meshes approach the shape they describe at the order of their elements."""

import numpy as np
import pytest

from mammosim.core.labels import DEFORMABLE, Label
from mammosim.core.mesh import TetMesh
from mammosim.core.rng import generator
from mammosim.core.volume import LabelMap, grid_around
from mammosim.meshing.body import ElementSize, crop_body, mesh_body
from mammosim.meshing.distance import distance_to_boundary
from mammosim.meshing.quality import quality
from mammosim.meshing.raster import rasterise
from mammosim.meshing.remesh import remeshed
from mammosim.meshing.surface import Surface, surface_of_field
from mammosim.meshing.tetrahedra import mesh_surface

RADIUS = 40.0
BALL = 4 / 3 * np.pi * RADIUS**3


def _ball(spacing: float) -> Surface:
    grid = grid_around(np.full(3, -RADIUS - 5), np.full(3, RADIUS + 5), spacing)
    return surface_of_field((np.linalg.norm(grid.centres(), axis=1) - RADIUS).reshape(grid.shape), grid)


def test_marching_cubes_err_by_the_square_of_the_voxel() -> None:
    coarse, fine = (abs(_ball(h).volume() / BALL - 1) for h in (4.0, 2.0))
    assert np.log2(coarse / fine) == pytest.approx(2, abs=0.25)


def test_remeshed_triangles_follow_the_surface_with_the_square_of_their_edge() -> None:
    ball = _ball(2.0)
    error = []
    for h in (16.0, 8.0):
        corners = remeshed(ball, lambda points, h=h: np.full(len(points), h)).corners()
        radius = np.linalg.norm(np.concatenate([corners.mean(axis=1), *np.moveaxis(corners, 1, 0)]), axis=1)
        error.append(np.sqrt(np.mean((radius - RADIUS) ** 2)))
    assert np.log2(error[0] / error[1]) == pytest.approx(2, abs=0.4)


def test_voxels_of_a_deformed_mesh_have_its_volume() -> None:
    mesh = mesh_surface(_ball(2.5), size=12.0)
    X = mesh.points
    deformed = mesh.moved_to(X + 5 * np.sin(X[:, [1, 2, 0]] / 15))
    grid = grid_around(deformed.points.min(axis=0) - 2, deformed.points.max(axis=0) + 2, 1.0)
    voxels = np.count_nonzero(rasterise(deformed, grid).inside) * grid.voxel_volume
    # Each of the N = 4 pi R^2 surface voxels is in or out by chance: a standard error of sqrt(N / 12).
    standard_error = np.sqrt(4 * np.pi * RADIUS**2 / 12)
    # The four-point rule is exact for det dx/dxi to second degree; the third adds to the tolerance.
    volume = quality(deformed)["volume_mm3"].sum()
    assert abs(voxels - volume) < 4 * standard_error + 1e-3 * volume


def _torso(spacing: float, noise_mm: float, seed: int) -> LabelMap:
    """A rib cage with 8 mm of muscle, 8 mm of fat and two breasts, its borders displaced by smooth noise."""
    rng = generator(seed, "torso")
    grid = grid_around(np.array([-190.0, -130, -110]), np.array([190.0, 70, 110]), spacing)
    x, y, z = grid.centres().T
    ring = np.sqrt((x / 140) ** 2 + ((y - 60) / 100) ** 2)
    chest = (ring - 1) * 110 + noise_mm * _waves(rng, grid.centres())
    breasts = [np.sqrt((x - side * 75) ** 2 + (y + 30) ** 2 + z**2) - 50 for side in (-1, 1)]
    outer = np.minimum(chest - 16, np.min(breasts, axis=0)) + noise_mm * _waves(rng, grid.centres())
    values = np.where(outer < 0, Label.ADIPOSE, Label.AIR)
    values[(np.min(breasts, axis=0) < -25) & (chest > 10)] = Label.GLANDULAR
    values[chest < 8] = Label.MUSCLE
    values[chest < 0] = Label.THORAX
    return LabelMap(grid, values.astype(np.uint8).reshape(grid.shape))


def _waves(rng: np.random.Generator, points: np.ndarray) -> np.ndarray:
    """A sum (n,) of twenty plane waves of unit variance, wavelengths of 15 to 40 mm."""
    k = rng.normal(size=(20, 3))
    k *= 2 * np.pi / rng.uniform(15, 40, size=(20, 1)) / np.linalg.norm(k, axis=1, keepdims=True)
    return np.cos(points @ k.T + rng.uniform(0, 2 * np.pi, 20)).sum(axis=1) * np.sqrt(2 / 20)


@pytest.mark.parametrize(
    ("spacing", "noise_mm", "size"),
    [(3.0, 0.0, (12, 16)), (4.0, 0.7, (10, 14)), (4.0, 1.5, (16, 20)), (6.0, 0.7, (16, 20))],
)
def test_any_chest_meshes_at_once_and_soundly(
    spacing: float, noise_mm: float, size: tuple[float, float], caplog: pytest.LogCaptureFixture
) -> None:
    labels = _torso(spacing, noise_mm, seed=int(spacing + 10 * noise_mm))
    labels = crop_body(labels, posterior_limit_mm=35.0, height_limits_mm=(-90.0, 95.0))
    mesh = mesh_body(labels, size=ElementSize(*size))
    table = quality(mesh)
    assert not caplog.records  # a warning would tell of a second attempt
    assert table["mean_ratio"].min() > 0.15
    voxels = np.isin(labels.values, DEFORMABLE).sum() * labels.grid.voxel_volume
    # Elements h of the chest wall cut off the two corners of a rim by triangles of legs h / 2 at most, which
    # makes h^2 / 4; the rim runs along both ends of the cage, 440 mm each, and two sides, 185 mm each.
    lost = size[1] ** 2 / 4 * 2 * (440 + 185)
    assert -lost < table["volume_mm3"].sum() - voxels < 0.01 * voxels
    assert _skin_error(mesh, labels) < spacing


def _skin_error(mesh: TetMesh, labels: LabelMap) -> float:
    """Median distance in mm from the frontmost tissue voxels to the mesh's skin: half a voxel is perfect."""
    front = np.isin(labels.values, DEFORMABLE)
    front[:, 1:] &= labels.values[:, :-1] == Label.AIR
    front[:, 0] = False
    points = labels.grid.points(np.argwhere(front).astype(float))
    inner = points[(np.abs(points[:, 2]) < 60) & (points[:, 1] < 0)]
    return float(np.median(distance_to_boundary(inner, mesh)))
