"""Rigid registration of two positions without markers: the rib cage alone, and how sure that is.

The chests are laid over each other by their skins, then by the correlation of all shifts (imaging.alignment);
from the best starts images inside the rib cage are correlated (imaging.registration), and last the parts of
the rib cage each by itself, which tell how sure that is (imaging.certainty). What is not sure is rejected.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from mammosim.core.errors import ImageError
from mammosim.core.rigid import RigidTransform
from mammosim.core.volume import Image, LabelMap
from mammosim.imaging.alignment import Chest, Start, chest_of, evened, orthonormal, starts
from mammosim.imaging.certainty import PartsOfChest, parts_of_chest
from mammosim.imaging.outline import body_mask, coarsened
from mammosim.imaging.registration import (
    DEFAULT,
    Registration,
    Settings,
    correlation,
    refine,
    resample,
    rib_cage,
)

COARSE = Settings(voxel_mm=4.0, smoothing_mm=(4.0,), iterations=60, samples=20_000)
STARTS = 3
# Steps of less than this in the middle of the rib cage end the last ones: no registration is that sure.
LAST_MM, LAST_STEPS = 0.01, 10
# ASSUME: below this correlation inside the rib cage two images do not show the same chest. Digital volunteers
# whose chests differ in nothing but the lungs' vessels reach 0.84 with each other, and 0.99 with themselves.
LEAST_CORRELATION = 0.9
# ASSUME: a registration that may be off by more than this at the chest wall is of no use for the breasts.
LARGEST_ERROR_MM = 10.0
NEXT = "check that both images show one woman's chest, or list chest_1 to chest_4 in both"


@dataclass(frozen=True)
class Pair:
    """Two images to be compared at any motion, the body (nz, ny, nx) in each, inside: the fixed rib cage."""

    fixed: Image
    moving: Image
    bodies: tuple[np.ndarray, np.ndarray]
    inside: np.ndarray

    @classmethod
    def of(cls, fixed: Image, moving: Image) -> "Pair":
        """Raises ImageError when no body or rib cage is in an image."""
        bodies = body_mask(fixed), body_mask(moving)
        return cls(fixed, moving, bodies, rib_cage(fixed).values == 1)

    def parts(self, motion: RigidTransform) -> PartsOfChest:
        """What the parts of the rib cage say at a motion, images evened over what is in both.

        Raises ImageError when too little of the rib cage is in both, or it does not fix a motion.
        """
        grid, body = self.fixed.grid, Image(self.moving.grid, self.bodies[1].astype(np.float32))
        both = self.bodies[0] & (resample(body, motion, grid).values > 0.5)
        still, moved = (evened(image, both) for image in (self.fixed, resample(self.moving, motion, grid)))
        return parts_of_chest(still, moved, self.inside & both)

    def last_steps(self, motion: RigidTransform) -> tuple[RigidTransform, PartsOfChest, int]:
        """The motion of highest correlation near another one, what the parts say there, and the steps."""
        parts, taken = self.parts(motion), 0
        while taken < LAST_STEPS and np.linalg.norm(parts.theta[:3]) >= LAST_MM:
            motion, taken = orthonormal(parts.step.after(motion)), taken + 1
            parts = self.parts(motion)
        return motion, parts, taken

    @property
    def front(self) -> np.ndarray:
        """Corners (8, 3) mm of the fixed rib cage in view: there an error of a turn is largest."""
        voxels = np.argwhere(self.inside)
        low, high = voxels.min(axis=0), voxels.max(axis=0)
        corners = np.stack(np.meshgrid(*zip(low, high), indexing="ij"), axis=-1).reshape(-1, 3)
        return self.fixed.grid.points(corners.astype(float))


def register_unmarked(fixed: Image, moving: Image, *, settings: Settings = DEFAULT) -> Registration:
    """Register `moving` on `fixed` by what their rib cages show.

    The table has the steps 'surface' and 'image', and no marker residuals.
    Raises ImageError when no rib cage is in one of them, or they do not match for sure.
    """
    start, iterations = _best_start(*(coarse_chest(image) for image in (fixed, moving)))
    pair = Pair.of(coarsened(fixed, settings.voxel_mm), coarsened(moving, settings.voxel_mm))
    before = pair.parts(start)
    motion, after, steps = pair.last_steps(start)
    sure = [parts.certainty for parts in (before, after)]
    error_mm = [float(each.at(pair.front).max()) for each in sure]
    _require_sure(after.correlation, error_mm[1])
    table = pd.DataFrame(
        {
            "step": ["surface", "image"],
            "marker_residual_mm": np.nan,
            "marker_residual_max_mm": np.nan,
            "correlation": [before.correlation, after.correlation],
            "iterations": [iterations, steps],
            "used": [False, True],
            "method": "rib cage",
            "error_95_mm": error_mm,
            "error_95_deg": [each.turn_deg for each in sure],
        }
    )
    return Registration(start, motion, table)


def coarse_chest(image: Image) -> Chest:
    """A chest as it is aligned."""
    image = coarsened(image, COARSE.voxel_mm)
    return chest_of(image, rib_cage(image).values == 1)


def _best_start(fixed: Chest, moving: Chest) -> tuple[RigidTransform, int]:
    """The best of a few starts once each is moved to the highest correlation near it, and its iterations."""
    inside = LabelMap(fixed.image.grid, fixed.inside.astype(np.uint8))
    images, best = (fixed.image, moving.image), Start(RigidTransform(np.eye(3), np.zeros(3)), -1.0)
    done = 0
    for start in starts(fixed, moving)[:STARTS]:
        motion, iterations = refine(images, inside, start.motion, COARSE)
        r = correlation(*images, inside, motion)
        if r > best.correlation:
            best, done = Start(motion, r), iterations
    if best.correlation < 0:
        raise ImageError(f"the chests of the two images overlap too little at any shift; {NEXT}")
    return best.motion, done


def _require_sure(r: float, error_mm: float) -> None:
    """Raise ImageError unless a registration can be believed."""
    if not (r >= LEAST_CORRELATION and error_mm <= LARGEST_ERROR_MM):
        raise ImageError(
            f"the rib cages of the two images do not match: at best their brightness correlates by {r:.2f} "
            f"(at least {LEAST_CORRELATION:g}), and the chest wall may be {error_mm:.1f} mm off (at most "
            f"{LARGEST_ERROR_MM:g}); {NEXT}"
        )
