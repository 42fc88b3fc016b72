"""Tissue labels of an image without a person: outline, chest wall, brightness of fat, what differs from it.

Nothing is taken from the sequence: the layer under the skin says which brightness is fat, and muscle is the
layer at the chest wall. Gland is what differs from fat by more than half of what gland does.
"""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from mammosim.core.labels import Label
from mammosim.core.volume import Grid, Image
from mammosim.imaging.chest_wall import (
    Rays,
    Seen,
    chest_wall,
    depth_under_skin,
    expected_wall,
    sign_of_muscle,
    thorax_axis,
)
from mammosim.imaging.fat_level import SHELL_MM, FatLevel, fat_level
from mammosim.imaging.joint_level import joint_level
from mammosim.imaging.muscle_faces import muscle_faces
from mammosim.imaging.outline import SKIN_LEVEL, body_mask, coarsened, largest_part, spread_linearly
from mammosim.imaging.skin_glow import skin_glow, skin_is_bright

WALL_MM = 3.5  # voxels in which the chest wall is looked for, and the brightness of fat
# ASSUME: skin is the outermost 1.5 mm, at least a voxel in the two directions of the smallest voxels.
SKIN_MM = 1.5
# ASSUME: no gland is 3 mm under the outer face of the skin or 2 mm before the muscle; strands are 1 mm wide.
GLAND_DEPTH_MM, GLAND_BEFORE_MM, STRAND_MM = 3.0, 2.0, 1.0
# ASSUME: bright skin, and its glow, are 5 mm thick.
BRIGHT_SKIN_MM = 5.0
DEEP_MM = 8.0  # there bright or dark skin is out of reach
# ASSUME: where fat is darker than gland, and dark as noise where it is suppressed, intensities are averaged
# over a Gaussian of 0.8 mm, else of half the width of strands (docs/decisions/segmentation.md).
DARK_FAT_SMOOTHING_MM = 0.8
# ASSUME: gland differs from fat by a fifth of its brightness at least, and by two standard deviations of it.
LEAST_CONTRAST, SPREADS = 0.2, 2.0
LEAST_GLAND_MM3 = 30.0
# ASSUME: gland reaches no more than 45 mm behind the skin of the breastbone.
GLAND_BEHIND_MM = 45.0
# ASSUME: where gland is brighter than fat, skin begins at 30 % of the brightness nearby, and at half of it
# where skin is bright, too: there a blurred edge is, and what is darker before it is the skin's glow in air.
BESIDE_BRIGHT_LEVEL, BRIGHT_SKIN_LEVEL = 0.3, 0.5


@dataclass(frozen=True)
class Regions:
    """Body, muscle, thorax (nz, ny, nx) bool, depth mm under the skin; ahead: where gland may be."""

    body: np.ndarray
    muscle: np.ndarray
    thorax: np.ndarray
    depth: np.ndarray
    ahead: np.ndarray

    @property
    def breast(self) -> np.ndarray:
        """Skin, fat and gland, in one part."""
        return largest_part(self.body & ~self.muscle & ~self.thorax)


def unsupervised(image: Image, free: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Labels (nz, ny, nx) uint8 and probability of gland float32; free: bool, where no marker is.

    Raises SegmentationError where no body is at the midline.
    """
    coarse, level = coarsened(image, WALL_MM), SKIN_LEVEL
    seen, fat = _looked_at(coarse, level)
    muscle = sign_of_muscle(seen)
    sign = 1 if muscle > 0 else fat.sign
    if sign > 0:
        level = BESIDE_BRIGHT_LEVEL
        seen, fat = _looked_at(coarse, level, sign)
        if skin_is_bright(*_under_skin(coarse, level, seen.rays, fat)):
            level = BRIGHT_SKIN_LEVEL
            seen, fat = _looked_at(coarse, level, sign)
    wall = chest_wall(seen, muscle)
    body = largest_part(body_mask(image, skin_level=level) & free)
    depth, rays = depth_under_skin(body, image.grid.spacing), seen.rays.on(image.grid)
    relative = _from_zero(image.values) / spread_linearly(fat.level, image.grid, WALL_MM)
    front, back = muscle_faces(rays, relative, depth, wall, muscle)
    regions = _regions(rays, body, depth, front, back)
    p = _gland(image, regions, sign)
    return _labels(regions, p, image.grid.spacing), p


def _looked_at(coarse: Image, skin_level: float, sign: int = 0) -> tuple[Seen, FatLevel]:
    """Edges along rays through the body, and the brightness of fat to which they are relative."""
    body = body_mask(coarse, skin_level=skin_level)
    rays = Rays.of(coarse.grid, thorax_axis(body, coarse.grid.spacing))
    depth = depth_under_skin(body, coarse.grid.spacing)
    fat = _fat(coarse, body, depth, rays, sign)
    return Seen.of(rays, _from_zero(coarse.values) / fat.level, depth), fat


def _under_skin(coarse: Image, level: float, rays: Rays, fat: FatLevel) -> tuple[np.ndarray, np.ndarray]:
    """Brightness (n,) relative to fat, and depth mm under the skin, in front of the breastbone."""
    body = body_mask(coarse, skin_level=level)
    depth = depth_under_skin(body, coarse.grid.spacing)
    front = body & (np.arange(body.shape[1])[:, None] < rays.axis.midline[:, None, None])
    return (_from_zero(coarse.values) / fat.level)[front], depth[front]


def _fat(coarse: Image, body: np.ndarray, depth: np.ndarray, rays: Rays, sign: int) -> FatLevel:
    """The brightness of fat before the expected wall; the breast is what is in front of the breastbone."""
    spacing = coarse.grid.spacing
    before = body & ~rays.within(expected_wall(rays, spacing) + 5.0)
    in_front = np.arange(body.shape[1])[:, None] < rays.axis.midline[:, None, None] - 5.0 / spacing[1]
    breast = before & in_front if (before & in_front & (depth > 10.0)).any() else before
    return fat_level(_from_zero(coarse.values), before, breast, depth, spacing, sign=sign)


def _from_zero(values: np.ndarray) -> np.ndarray:
    return np.maximum(values - np.percentile(values, 1), 0).astype(np.float32)


def _regions(rays: Rays, body: np.ndarray, depth: np.ndarray, wall: np.ndarray, back: np.ndarray) -> Regions:
    """Body, muscle and thorax: whatever of the body is behind the thorax belongs to it."""
    inside, thorax = rays.within(wall), rays.within(back)
    thorax = np.maximum.accumulate(thorax, axis=1) & (body | inside)
    muscle = inside & ~thorax & (depth > GLAND_DEPTH_MM)
    shut_in = body & ~muscle & ~thorax & ~largest_part(body & ~muscle & ~thorax)
    ahead = np.arange(body.shape[1])[:, None] < _behind(rays, rays.grid)[:, None, None]
    return Regions(body | thorax, muscle | shut_in, thorax, depth, np.broadcast_to(ahead, body.shape))


def _behind(rays: Rays, grid: Grid) -> np.ndarray:
    """Row (nz,) of each slice behind which there is no gland."""
    rows = np.interp(np.arange(grid.shape[0]), rays.slices, rays.midline_rows)
    return rows + GLAND_BEHIND_MM / grid.spacing[1]


def _gland(image: Image, regions: Regions, sign: int) -> np.ndarray:
    """Probability (nz, ny, nx) float32: 0.5 half way from fat to gland."""
    spacing = image.grid.spacing[::-1]
    before = ndimage.binary_dilation(
        regions.muscle | regions.thorax, iterations=max(round(GLAND_BEFORE_MM / spacing[1]), 1)
    )
    breast = regions.ahead & regions.breast & ~before
    I = _from_zero(image.values)
    under_skin = breast & (regions.depth > SHELL_MM[0])
    even = _averaged(I, under_skin, DARK_FAT_SMOOTHING_MM / spacing)
    level = joint_level(even, under_skin, regions.depth, image.grid, sign)
    bright_skin = max(BRIGHT_SKIN_MM, 2.01 * float(spacing.min()))  # and the voxels that it fills in part
    where = breast & (regions.depth > (GLAND_DEPTH_MM if sign < 0 else bright_skin))
    smoothing_mm = DARK_FAT_SMOOTHING_MM if sign > 0 else STRAND_MM / 2
    if sign > 0:
        level *= skin_glow(even / level, under_skin, regions.depth, image.grid)
    differs = _averaged(sign * (I / level - 1), where, smoothing_mm / spacing)
    deep = where & (regions.depth > DEEP_MM)
    noise = _spread(differs[deep])
    clear = differs[deep & (differs > max(LEAST_CONTRAST, SPREADS * noise))]
    half = max(float(np.median(clear)) / 2 if len(clear) else LEAST_CONTRAST, LEAST_CONTRAST / 2)
    return np.where(where, np.clip(differs / (2 * half), 0, 1), 0).astype(np.float32)


def _averaged(values: np.ndarray, where: np.ndarray, sigma: np.ndarray) -> np.ndarray:
    """Gaussian means (nz, ny, nx) over a region (bool) alone: skin and muscle beside it add nothing."""
    total, weight = (
        ndimage.gaussian_filter(each.astype(np.float32), sigma) for each in (where * values, where)
    )
    mean: np.ndarray = total / np.maximum(weight, 1e-3)
    return mean


def _spread(differs: np.ndarray) -> float:
    """Standard deviation of fat, from what lies on the other side of it than gland."""
    other = differs[differs < 0]
    return 1.4826 * float(np.median(-other)) if len(other) else 0.0


def _labels(regions: Regions, p: np.ndarray, spacing: np.ndarray) -> np.ndarray:
    """Labels (nz, ny, nx) uint8 of the regions and of the probability of gland."""
    labels = np.full(p.shape, Label.AIR, np.uint8)
    breast = regions.breast
    gland = _large_parts(p > 0.5, LEAST_GLAND_MM3 / float(np.prod(spacing)))
    labels[regions.body] = Label.THORAX
    labels[breast] = Label.ADIPOSE
    labels[gland & breast] = Label.GLANDULAR
    labels[regions.muscle] = Label.MUSCLE
    labels[breast & outermost(regions.depth, spacing)] = Label.SKIN
    return labels


def outermost(depth: np.ndarray, spacing: np.ndarray) -> np.ndarray:
    """Skin (nz, ny, nx) bool of a depth mm: SKIN_MM, at least a voxel in two directions."""
    return (depth > 0) & (depth <= max(SKIN_MM, 1.01 * float(np.median(spacing))))


def _large_parts(region: np.ndarray, least: float) -> np.ndarray:
    """Parts of a region (bool) of at least so many voxels, joined over corners."""
    parts, n = ndimage.label(region, np.ones((3, 3, 3)))
    size = np.bincount(parts.ravel())
    size[0] = 0
    return (size >= least)[parts] if n else region
