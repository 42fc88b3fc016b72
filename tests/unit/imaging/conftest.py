"""A small analytic chest: thorax with texture, muscle, fat, two breasts with gland, skin and markers."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
import pytest

from mammosim.core.fiducials import Fiducials
from mammosim.core.labels import Label
from mammosim.core.rigid import IDENTITY, RigidTransform
from mammosim.core.volume import Grid, Image, LabelMap, grid_around

BRIGHTNESS = np.array([0.0, 1000, 450, 350, 280, 0, 2500])
CHEST_XZ = np.array([[0.0, 75], [-65, 70], [12, 20], [80, -75]])
BREAST_XZ = np.array([[-70.0, -30], [-45, -20], [70, -30], [95, -20]])
SKIN_MM, FAT_MM, MUSCLE_MM, MARKER_RADIUS_MM = 3.0, 6.0, 8.0, 3.5


def _rib(points: np.ndarray) -> np.ndarray:
    """Distance (n,) mm in front of a rib cage of semi-axes 120 and 90 mm, to first order."""
    x, y = points[:, 0], points[:, 1] - 60
    r = np.sqrt((x / 120) ** 2 + (y / 90) ** 2)
    return (r - 1) * r / np.maximum(np.hypot(x / 120**2, y / 90**2), 1e-9)


def _depth(points: np.ndarray) -> np.ndarray:
    """Depth (n,) mm under the outer face of the skin: of the torso or of a breast, a ball of 50 mm."""
    torso = SKIN_MM + FAT_MM + MUSCLE_MM - _rib(points)
    breasts = [50 - np.linalg.norm(points - [x, -15, 0], axis=1) for x in (-65.0, 65.0)]
    return np.maximum(torso, np.maximum(*breasts))


def _labels(points: np.ndarray, balls: np.ndarray) -> np.ndarray:
    rib, depth = _rib(points), _depth(points)
    labels = np.full(len(points), Label.AIR, np.uint8)
    labels[depth > 0] = Label.ADIPOSE
    for x in (-65.0, 65.0):
        labels[np.linalg.norm(points - [x, -35, 4], axis=1) < 20] = Label.GLANDULAR
    labels[(depth > 0) & (rib < MUSCLE_MM)] = Label.MUSCLE
    labels[(depth > 0) & (rib < 0)] = Label.THORAX
    labels[(depth > 0) & (depth < SKIN_MM)] = Label.SKIN
    for ball in balls:
        near = np.flatnonzero(np.abs(points[:, 2] - ball[2]) < MARKER_RADIUS_MM)
        near = near[np.linalg.norm(points[near] - ball, axis=1) < MARKER_RADIUS_MM]
        labels[near[labels[near] == Label.AIR]] = Label.MARKER
    return labels


def _balls(xz: np.ndarray) -> np.ndarray:
    """Centres (n, 3) of balls that touch the skin in front of (x, z), found by bisection along y."""
    y = np.linspace(-90, 0, 9001)
    depth = np.array([_depth(np.column_stack([np.full_like(y, x), y, np.full_like(y, z)])) for x, z in xz])
    return np.column_stack([xz[:, 0], y[(depth > -MARKER_RADIUS_MM).argmax(axis=1)], xz[:, 1]])


@dataclass(frozen=True)
class Phantom:
    """One image of the chest, its labels, and its marker centres (n, 3), all in the scanner frame."""

    image: Image
    labels: LabelMap
    chest: np.ndarray
    breast: np.ndarray
    motion: RigidTransform

    def listed(self) -> Fiducials:
        """The breast markers and nipples somebody clicked."""
        nipples = self.motion(np.array([[65.0, -65, 0], [-65, -65, 0]]))
        names = (*(f"breast_{k + 1}" for k in range(len(self.breast))), "nipple_left", "nipple_right")
        kinds = ("breast",) * len(self.breast) + ("nipple",) * 2
        return Fiducials(names, kinds, np.vstack([self.breast, nipples]))

    def strokes(self, per_tissue: int = 60) -> pd.DataFrame:
        """Points somebody painted: the same number in every tissue."""
        rng = np.random.default_rng(3)
        rows = []
        for label in list(Label)[:6]:
            voxels = np.argwhere(self.labels.values == label)
            points = self.labels.grid.points(voxels[rng.choice(len(voxels), per_tissue)].astype(float))
            rows.append(pd.DataFrame(points, columns=["x_mm", "y_mm", "z_mm"]).assign(tissue=label.tissue))
        return pd.concat(rows, ignore_index=True)


def make_phantom(
    spacing: float | tuple[float, float, float],
    motion: RigidTransform = IDENTITY,
    *,
    low: tuple[float, float, float] = (-164, -100, -90),
    high: tuple[float, float, float] = (164, 70, 90),
    noise: float = 20.0,
    seed: int = 1,
    brightness: np.ndarray = BRIGHTNESS,
) -> Phantom:
    """Render with 2 x 2 x 2 points per voxel and Rician noise; scanner = motion(body)."""
    grid = grid_around(np.array(low, float), np.array(high, float), np.array(spacing, float))
    chest, breast = _balls(CHEST_XZ), _balls(BREAST_XZ)
    balls = np.vstack([chest, breast])
    fine = Grid(tuple(2 * n for n in grid.shape), grid.spacing / 2, grid.origin - grid.spacing / 4)
    points = motion.inverse()(fine.centres())
    labels = _labels(points, balls)
    values = brightness[labels].astype(float)
    thorax = labels == Label.THORAX
    waves = np.sin(points[thorax] / [17, 13, 11]) + np.cos(points[thorax] / [29, 31, 23])
    values[thorax] = 300 + 250 * np.clip(np.prod(waves, axis=1), -1, 1)
    values = values.reshape(*np.array([grid.shape, (2, 2, 2)]).T.ravel()).mean(axis=(1, 3, 5))
    a, b = np.random.default_rng(seed).normal(scale=noise, size=(2, *grid.shape))
    truth = _labels(motion.inverse()(grid.centres()), balls).reshape(grid.shape)
    image = Image(grid, np.hypot(values + a, b).astype(np.float32))
    return Phantom(image, LabelMap(grid, truth), motion(chest), motion(breast), motion)


@pytest.fixture(scope="session")
def chest() -> Phantom:
    """The chest at 4 mm, not moved."""
    return make_phantom(4.0)


@pytest.fixture(scope="session")
def render():
    """The maker of other images of it."""
    return make_phantom
