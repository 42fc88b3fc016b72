"""A woman with two breasts of 60 mm on a slab of chest, scanned prone: coarse labels, and an image."""

import numpy as np

from mammosim.core.labels import Label
from mammosim.core.volume import Image, LabelMap, grid_around

BRIGHTNESS = np.zeros(len(Label), np.float32)
BRIGHTNESS[[Label.ADIPOSE, Label.GLANDULAR, Label.MUSCLE, Label.THORAX]] = 900.0, 450.0, 300.0, 200.0


def tiny_labels(step_mm: float = 5.0) -> LabelMap:
    """Half-ellipsoids of fat and gland at x = -70 and 70 mm; fat from y = 0, muscle from 8, ribs from 16."""
    grid = grid_around(np.array([-140.0, -80.0, -90.0]), np.array([140.0, 50.0, 90.0]), step_mm)
    x, y, z = np.moveaxis(grid.centres().reshape(*grid.shape, 3), -1, 0)
    r = np.sqrt(((np.abs(x) - 70) / 50) ** 2 + (y / 60) ** 2 + (z / 50) ** 2)
    values = np.where((y > 0) | (r < 1), np.uint8(Label.ADIPOSE), np.uint8(Label.AIR))
    values[(r < 0.6) & (y < 0)] = Label.GLANDULAR
    values[y > 8] = Label.MUSCLE
    values[y > 16] = Label.THORAX
    return LabelMap(grid, values)


def tiny_image(labels: LabelMap) -> Image:
    """Each tissue with its brightness, and noise."""
    noise = np.random.default_rng(1).normal(0, 5, (2, *labels.grid.shape))
    return Image(labels.grid, np.hypot(BRIGHTNESS[labels.values] + noise[0], noise[1]).astype(np.float32))
