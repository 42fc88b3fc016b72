"""Front and back of the muscle to a fraction of a voxel, from a chest wall that is right to some millimetres.

The image is straightened along the wall: along each ray it is read at distances from the wall rather than
from the axis. There a face is the surface of least cost of the contrast of two thin layers, as the wall was
of two thick ones in a coarse image (graph search from coarse to fine: Li et al., IEEE Trans Pattern Anal Mach
Intell 28:119, 2006).
"""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from mammosim.imaging.chest_wall import CLIPPED, LEAST_MUSCLE_MM, SKIN_MM, Rays, layer_contrast, smoothed
from mammosim.imaging.depth_field import depth_field

# Distances from the wall, in mm; layers that are compared; Gaussian over slices and in them before that.
STEP_MM, LAYER_MM, SMOOTH_MM = 0.75, 3.0, (2.0, 0.75)
# ASSUME: the wall of the coarse image is within 6 mm of the front of the muscle.
FRONT_WITHIN_MM = 6.0
# ASSUME: the muscle is 4 to 20 mm thick, and about 12 mm where no darker layer is seen behind it.
MUSCLE_MM = 12.0
# Muscle nearer to its front than this is as that behind it: else the front is the sharpest edge of all.
OF_FRONT_MM = 2.5
PENALTY, WEIGHT, LARGEST = 0.1, 0.5, 3.0


@dataclass(frozen=True)
class Straightened:
    """Intensities relative to fat (nz, ny, nx), fat under the skin, to be read along rays round a wall."""

    rays: Rays
    relative: np.ndarray

    @classmethod
    def of(cls, rays: Rays, relative: np.ndarray, depth: np.ndarray) -> "Straightened":
        """Of an image (nz, ny, nx) relative to fat and its depth mm under the skin; skin counts as fat."""
        even = np.where(depth > SKIN_MM, np.clip(relative, *CLIPPED), 1).astype(np.float32)
        across, within = SMOOTH_MM
        return cls(rays, ndimage.gaussian_filter(even, [across, within, within] / rays.grid.spacing[::-1]))

    def along(self, wall: np.ndarray, distances: np.ndarray) -> np.ndarray:
        """Values (slice, angle, distance) at distances mm in front of a wall (slice, angle) mm."""
        return self.rays.read(self.relative, wall[..., None] + distances)


def muscle_faces(
    rays: Rays, relative: np.ndarray, depth: np.ndarray, wall: np.ndarray, sign: float
) -> tuple[np.ndarray, np.ndarray]:
    """Radius (slice, angle) mm of the front and the back of the muscle near a wall (slice, angle) mm.

    relative: image (nz, ny, nx) over the brightness of fat; depth: mm under the skin; sign: 1 where muscle is
    brighter than fat, -1 where it is darker. Ribs and lungs behind it are darker than it.
    """
    image = Straightened.of(rays, relative, depth)
    front = _front(image, wall, sign)
    return front, _back(image, front)


def _front(image: Straightened, wall: np.ndarray, sign: float) -> np.ndarray:
    reach = FRONT_WITHIN_MM + 2 * LAYER_MM
    distances = np.arange(-reach, reach + STEP_MM / 2, STEP_MM)
    contrast = sign * layer_contrast(image.along(wall, distances), STEP_MM, LAYER_MM)
    return wall + _face(contrast, distances, 0.0, FRONT_WITHIN_MM)


def _back(image: Straightened, front: np.ndarray) -> np.ndarray:
    deepest = 2 * MUSCLE_MM - LEAST_MUSCLE_MM
    distances = np.arange(-deepest - 2 * LAYER_MM, 2 * LAYER_MM, STEP_MM)
    along = image.along(front, distances)
    first = int(np.searchsorted(distances, -OF_FRONT_MM))
    along[..., first:] = along[..., first - 1 : first]
    contrast = -layer_contrast(along, STEP_MM, LAYER_MM)
    return front + _face(contrast, distances, -MUSCLE_MM, MUSCLE_MM - LEAST_MUSCLE_MM)


def _face(contrast: np.ndarray, distances: np.ndarray, expected: float, within: float) -> np.ndarray:
    """Distance (slice, angle) mm of the most contrast (slice, angle, distance), near an expected one."""
    away = (distances - expected) / within
    near = np.abs(away) <= 1
    c = contrast[..., near]
    cost = -np.clip(c / max(float(np.std(c)), 1e-6), -LARGEST, LARGEST) + WEIGHT * away[near] ** 2
    return smoothed(distances[near][depth_field(cost, penalty=PENALTY)])
