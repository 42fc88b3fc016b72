"""A virtual patient's stress-free body as functions of the point, to be sampled at any resolution."""

from dataclasses import dataclass
from functools import reduce

import numpy as np

from mammosim.core.labels import Label
from mammosim.core.rng import generator
from mammosim.core.volume import grid_around
from mammosim.digital.gland import GlandField, fitted, gland_field
from mammosim.digital.patient import VirtualPatient
from mammosim.digital.shape import (
    NIPPLE_BLEND_MM,
    Mound,
    blend,
    chest_distance,
    mounds,
    random_waves,
    skin_layers_mm,
    waves,
)

# ASSUME: skin thickness varies by region as clipped random waves of 60-150 mm, not with any measured map.
SKIN_WAVES = 24
SKIN_WAVE_MM = (60.0, 150.0)
CALIBRATION_MM = (
    2.0  # spacing of the points on which the gland fraction is set; 0.1 % of a breast's volume each 100
)


@dataclass(frozen=True)
class Anatomy:
    """Fields of one volunteer; every method takes points (n, 3) in the stress-free body frame, LPS, mm."""

    patient: VirtualPatient
    mounds: tuple[Mound, Mound]
    skin_waves: tuple[np.ndarray, np.ndarray]
    glands: tuple[GlandField, ...] = ()

    def rib_distance(self, points: np.ndarray) -> np.ndarray:
        """Signed distance (n,) to the rib cage, mm; negative in the thorax."""
        return chest_distance(self.patient, points, layers_mm=0.0)

    def outer_field(self, points: np.ndarray) -> np.ndarray:
        """Signed distance (n,) to the outer face of the skin, mm, to first order; negative inside."""
        body = chest_distance(self.patient, points, layers_mm=skin_layers_mm(self.patient))
        for mound in self.mounds:
            body = blend(body, mound.distance(points), self.patient.breast.fold_mm)
        return reduce(
            lambda a, mound: blend(a, mound.nipple_distance(points), NIPPLE_BLEND_MM), self.mounds, body
        )

    def region_field(self, points: np.ndarray) -> np.ndarray:
        """Signed distance (n,) to the box y < region_back, |z| < region_half_height, mm; negative inside."""
        chest = self.patient.chest
        return np.maximum(
            points[:, 1] - chest.region_back_mm, np.abs(points[:, 2]) - chest.region_half_height_mm
        )

    def soft_tissue_field(self, points: np.ndarray) -> np.ndarray:
        """Signed field (n,), mm, negative in the tissue that moves: in the region, from rib cage to skin."""
        layers = np.maximum(self.outer_field(points), -self.rib_distance(points))
        return np.maximum(layers, self.region_field(points))

    def skin_thickness(self, points: np.ndarray) -> np.ndarray:
        """Thickness (n,) of the skin near points, mm."""
        skin = self.patient.skin
        return skin.mean_mm + skin.variation_mm * np.clip(waves(points, *self.skin_waves), -1, 1)

    def labels_at(self, points: np.ndarray) -> np.ndarray:
        """Label (n,) uint8 of each point: air, skin, adipose, glandular, muscle or thorax."""
        labels = np.full(len(points), Label.AIR, np.uint8)
        depth = -self.outer_field(points)
        body = np.flatnonzero(depth >= 0)
        labels[body] = self.labels_inside(points[body], depth[body])
        return labels

    def labels_inside(self, points: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """Label (n,) uint8 of points known to lie in the body, depth (n,) mm under the skin's outer face."""
        rib = self.rib_distance(points)
        muscle = rib - self.patient.chest.muscle_mm
        labels = np.full(len(points), Label.ADIPOSE, np.uint8)
        for mound, gland in zip(self.mounds, self.glands):
            breast = np.flatnonzero((mound.distance(points) < 0) & (muscle > 0))
            possible = gland.possible(
                points[breast], depth[breast] - self.patient.skin.mean_mm, muscle[breast]
            )
            near = breast[possible]
            labels[near[gland(points[near])]] = Label.GLANDULAR
        labels[muscle < 0] = Label.MUSCLE
        labels[rib < 0] = Label.THORAX
        shallow = np.flatnonzero(depth < self.patient.skin.mean_mm + self.patient.skin.variation_mm)
        labels[shallow[depth[shallow] < self.skin_thickness(points[shallow])]] = Label.SKIN
        return labels

    def breast_points(self, mound: Mound, spacing_mm: float) -> np.ndarray:
        """Points (n, 3) of a regular grid in one breast: skin to muscle, inside its ellipsoid."""
        reach = mound.radii.max() + self.patient.breast.nipple_mm
        grid = grid_around(mound.centre - reach, mound.centre + reach, spacing_mm)
        points = grid.centres()
        points = points[mound.distance(points) < 0]
        before = self.rib_distance(points) > self.patient.chest.muscle_mm
        return points[before & (self.outer_field(points) < 0)]

    def in_front(self, mound: Mound, points: np.ndarray) -> np.ndarray:
        """Whether points (n, 3) lie in the nipple's half of the way from muscle to nipple."""
        behind = self.patient.chest.fat_mm + self.patient.skin.mean_mm
        return mound.local(points)[:, 2] > (mound.radii[2] - behind) / 2


def make_anatomy(patient: VirtualPatient) -> Anatomy:
    """The anatomy of a virtual patient. Raises ConfigurationError where her gland does not fit."""
    skin_waves = random_waves(generator(patient.seed, "skin"), SKIN_WAVES, *SKIN_WAVE_MM)
    body = Anatomy(patient, mounds(patient), skin_waves)
    return Anatomy(patient, body.mounds, skin_waves, tuple(_gland(body, mound) for mound in body.mounds))


def _gland(body: Anatomy, mound: Mound) -> GlandField:
    # ASSUME: gland fraction and its share in the nipple's half are set in the stress-free shape, per breast.
    patient = body.patient
    points = body.breast_points(mound, CALIBRATION_MM)
    field = gland_field(patient.gland, mound, patient.seed)
    depth = -body.outer_field(points) - patient.skin.mean_mm
    possible = field.possible(points, depth, body.rib_distance(points) - patient.chest.muscle_mm)
    front = body.in_front(mound, points)
    return fitted(field, patient.gland, points, possible, lambda held: front[held].mean())
