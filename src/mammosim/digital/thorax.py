"""Inside the rib cage: what registration holds on to. Rigid, in the body frame, LPS, mm."""

import numpy as np

from mammosim.core.rng import generator
from mammosim.digital.anatomy import Anatomy
from mammosim.digital.shape import ellipsoid_distance, random_waves, waves

# Materials of the image beyond core.labels.Label, as voxel codes; all of them are Label.THORAX.
ORGANS = {
    "thoracic_muscle": 16,
    "heart": 17,
    "lung": 18,
    "vessel": 19,
    "liver": 20,
    "marrow": 21,
    "cortex": 22,
    "thoracic_fat": 23,
}

# ASSUME: the thorax is made of ellipsoids (heart, liver, stomach, aorta), slanted ribs and a sternum.
WALL_MM = 13.0
RIB_PITCH_MM, RIB_WIDTH_MM, RIB_SLOPE = 25.0, 12.0, 0.35
STERNUM_HALF_WIDTH_MM, STERNUM_LOW_MM = 17.0, -55.0
HEART = (np.array([22.0, 12.0, -12.0]), np.array([52.0, 36.0, 50.0]))
LIVER = (np.array([-50.0, 55.0, -118.0]), np.array([82.0, 78.0, 85.0]))
STOMACH = (np.array([60.0, 45.0, -128.0]), np.array([48.0, 45.0, 70.0]))
AORTA = (np.array([14.0, 62.0, 0.0]), np.array([12.0, 12.0, np.inf]))
MEDIASTINUM = (np.array([6.0, 5.0, 0.0]), np.array([22.0, 60.0, np.inf]))
# Drawn in this order, each over the ones before.
INNER_ORGANS = (
    ("thoracic_fat", MEDIASTINUM),
    ("heart", HEART),
    ("thoracic_muscle", STOMACH),
    ("liver", LIVER),
    ("heart", AORTA),
)
VESSEL_WAVES, VESSEL_MM = 24, (10.0, 40.0)
VESSEL_LEVEL = 1.3  # standard deviations of the random waves above which the lung shows a vessel


def organs_at(anatomy: Anatomy, points: np.ndarray) -> np.ndarray:
    """Organ code (n,) uint8 of points (n, 3) inside the rib cage."""
    organs = np.full(len(points), ORGANS["lung"], np.uint8)
    for name, (centre, semi_axes) in INNER_ORGANS:
        organs[ellipsoid_distance(points, centre, np.eye(3), semi_axes) < 0] = ORGANS[name]
    rib = anatomy.rib_distance(points)
    wall = np.flatnonzero(rib > -WALL_MM)
    organs[wall] = _wall(points[wall], -rib[wall])
    lung = np.flatnonzero(organs == ORGANS["lung"])
    vessels = random_waves(generator(anatomy.patient.seed, "lung"), VESSEL_WAVES, *VESSEL_MM)
    organs[lung[waves(points[lung], *vessels) > VESSEL_LEVEL]] = ORGANS["vessel"]
    return organs


def _wall(points: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """Codes of the chest wall, depth (n,) mm behind its face: bone with a 1.5 mm cortex between muscle."""
    x, y, z = points.T
    across = np.abs((z - RIB_SLOPE * y) % RIB_PITCH_MM - RIB_PITCH_MM / 2) - RIB_WIDTH_MM / 2
    rib = np.maximum(across, np.abs(depth - WALL_MM / 2) - WALL_MM / 3)
    sternum = np.maximum(np.abs(x) - STERNUM_HALF_WIDTH_MM, STERNUM_LOW_MM - z)
    bone = np.where(
        y < 0, np.minimum(rib, np.maximum(sternum, np.abs(depth - WALL_MM / 2) - WALL_MM / 2.5)), rib
    )
    organs = np.full(len(points), ORGANS["thoracic_muscle"], np.uint8)
    organs[bone < 0] = ORGANS["cortex"]
    organs[bone < -1.5] = ORGANS["marrow"]
    return organs
