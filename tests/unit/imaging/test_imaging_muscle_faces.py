"""The chest wall: where the muscle begins and ends, bright or dark, to a fraction of a coarse voxel."""

import numpy as np
import pytest

from mammosim.core.volume import Grid
from mammosim.imaging.chest_wall import (
    Rays,
    Seen,
    chest_wall,
    depth_under_skin,
    layer_contrast,
    sign_of_muscle,
    thorax_axis,
)
from mammosim.imaging.joint_level import joint_level
from mammosim.imaging.muscle_faces import muscle_faces

# A torso of elliptic sections: half axes of skin, front and back of the muscle; y of the axis, all in mm.
SKIN, FRONT, BACK, AXIS_Y = (170.0, 150.0), (144.0, 124.0), (136.0, 116.0), 170.0
H = 4.0
LUNG, FAT = 0.3, 1.0


def _torso(muscle: float, cut_mm: float) -> tuple[Grid, np.ndarray, np.ndarray]:
    """Grid, brightness relative to fat and body of a torso that the image cuts so far behind its front."""
    shape = (10, round((20.0 + cut_mm) / H), 90)
    grid = Grid(shape, np.full(3, H), np.zeros(3), np.eye(3))
    fine = (np.indices((shape[1] * 4, shape[2] * 4)) + 0.5) / 4
    y, x = fine[0] * H - AXIS_Y, fine[1] * H - shape[2] * H / 2
    inside = [np.hypot(x / a, y / b) < 1 for a, b in (SKIN, FRONT, BACK)]
    value = np.where(inside[2], LUNG, np.where(inside[1], muscle, np.where(inside[0], FAT, 0.0)))
    means = [v.reshape(shape[1], 4, shape[2], 4).mean(axis=(1, 3)) for v in (value, inside[0])]
    relative, body = (np.broadcast_to(m, shape).astype(np.float32) for m in means)
    return grid, relative, body > 0.5


def _radius(rays: Rays, axes: tuple[float, float]) -> np.ndarray:
    """Radius (angle,) mm from the rays' axis to an ellipse round the torso's."""
    shift = (rays.axis.y + 0.5) * H - AXIS_Y
    r = np.arange(10.0, 200.0, 0.1)
    x, y = np.sin(rays.angles)[:, None] * r, shift - np.cos(rays.angles)[:, None] * r
    return r[(np.hypot(x / axes[0], y / axes[1]) < 1).sum(axis=1) - 1]


@pytest.mark.parametrize("layer_mm", [3.0, 4.0])
def test_the_contrast_of_two_layers_is_largest_where_they_meet(layer_mm) -> None:
    """For layers of an odd and of an even number of samples."""
    along = np.where(np.arange(40) < 20, 1.0, 3.0)
    along[20] = 2.0
    contrast = layer_contrast(along, 1.0, layer_mm)
    at = np.flatnonzero(np.isclose(contrast, contrast.min()))
    assert at.mean() == 20


@pytest.mark.parametrize(("muscle", "sign"), [(1.5, 1.0), (0.5, -1.0)])
@pytest.mark.parametrize("cut_mm", [90.0, 150.0])
def test_muscle_brighter_and_darker_than_fat_is_told_and_found(muscle, sign, cut_mm) -> None:
    """Also where the image is cut close behind the lungs' front: its border is no edge."""
    grid, relative, body = _torso(muscle, cut_mm)
    depth = depth_under_skin(body, grid.spacing)
    rays = Rays.of(grid, thorax_axis(body, grid.spacing))
    seen = Seen.of(rays, relative, depth)
    assert sign_of_muscle(seen) == sign
    front, back = muscle_faces(rays, relative, depth, chest_wall(seen, sign), sign)
    ahead = np.abs(rays.angles) < np.radians(20)
    # A quarter of a voxel: a face inside a voxel is read from what fills it.
    # Half a voxel: faces lie anywhere in voxels, muscle is two voxels thick, and what is bright is cut off.
    for found, axes in ((front, FRONT), (back, BACK)):
        assert np.abs(found - _radius(rays, axes))[2:-2, ahead].mean() < H / 2


def test_the_brightness_of_fat_is_not_that_of_gland_in_a_dense_breast() -> None:
    """Nine tenths of what is deeper than 10 mm are gland, 1.8 times as bright, under a coil's field."""
    n, h = 36, 3.0
    k = np.indices((n, n, n)) * h
    depth = np.minimum(k, (n - 1) * h - k).min(axis=0) + h / 2
    rng = np.random.default_rng(3)
    gland = (depth > 10) & (rng.random(depth.shape) < 0.9)
    field = 200 * np.exp(-k[1] / 150)
    I = field * np.where(gland, 1.8, 1.0) * (1 + 0.05 * rng.normal(size=depth.shape))
    grid = Grid((n, n, n), np.full(3, h), np.zeros(3), np.eye(3))
    level = joint_level(I.astype(np.float32), np.ones(I.shape, bool), depth, grid, 1)
    # Half way from fat to gland is 1.4: gland and fat are told apart while the level is within 0.2 of it.
    assert np.abs(level / field - 1)[depth > 10].max() < 0.2
