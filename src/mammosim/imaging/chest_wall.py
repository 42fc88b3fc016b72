"""The chest wall: where breast ends and muscle begins, a radius r(z, theta) round an axis through the thorax.

Along each ray from the axis the wall is an edge between muscle and the fat before it, near an ellipse that
the body's outline gives, and almost as far from the axis as on the rays beside it. Thus it is closed: no way
leads from the breast to what lies behind. Such surfaces are usual for it (Gallego-Ortiz & Martel, Med Phys
39:6886, 2012; Wu et al., Med Phys 40:042301, 2013).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from mammosim.core.errors import SegmentationError
from mammosim.core.volume import Grid
from mammosim.imaging.depth_field import depth_field

# Rays: every 3 degrees, to 120 degrees on either side of straight ahead; samples of 1.5 mm; slices of 4 mm.
STEP_DEG, LARGEST_DEG, STEP_MM, SLICE_MM = 3.0, 120.0, 1.5, 4.0
# ASSUME: the muscle begins 18 mm behind the skin over the breastbone and 25 mm under that of the flanks, give
# or take 45 mm; the axis is as far behind the breastbone as 0.8 of half the torso's width; the wall is
# at most 1.2 times that.
FRONT_MM, FLANK_MM, WITHIN_MM, AXIS_SHARE, WIDEST = 18.0, 25.0, 45.0, 0.8, 1.2
# ASSUME: an image less than 230 mm wide shows one breast; the midline is at the border with more of the body.
ONE_BREAST_MM = 230.0
# ASSUME: 6 mm of muscle are compared with 6 mm of fat before it.
LAYER_MM = 6.0
# ASSUME: skin and its glow are 4 mm thick, and 4 mm of tissue at least lie over the muscle.
SKIN_MM, SMOOTH_MM, LEAST_COVER_MM = 4.0, 2.0, 4.0
# ASSUME: intensities relative to fat beyond these are vessels, gland or air.
CLIPPED = (0.2, 1.3)
# Costs, in standard deviations of the contrast.
PENALTY, UNSEEN, FORBIDDEN = 0.3, 1.0, 20.0
SMOOTH_WALL = (5.0, 2.0)  # slices and angles: 20 mm and 6 degrees
# ASSUME: muscle is at least 4 mm thick.
LEAST_MUSCLE_MM = 4.0
# ASSUME: an edge is at least a quarter of the standard deviation of the contrast.
LEAST_EDGE = 0.25
AHEAD_DEG = 60.0  # there the wall is not beside the arms, and seldom outside the image


@dataclass(frozen=True)
class Axis:
    """Voxel column and row (x, y) of the axis, half the torso's width mm; midline: row (nz,) of its skin."""

    x: float
    y: float
    half_width_mm: float
    midline: np.ndarray


def thorax_axis(body: np.ndarray, spacing: np.ndarray) -> Axis:
    """The axis of the thorax in a body (nz, ny, nx), spacing (3,) mm in (x, y, z).

    Raises SegmentationError where there is hardly any body, or no slice has one at the midline.
    """
    nz, _, nx = body.shape
    dx, dy, _ = spacing
    share = body.mean(axis=(0, 1))
    columns = np.flatnonzero(share > 0.02)
    if not len(columns):
        raise SegmentationError("hardly any body is seen; give an image of both breasts or of one")
    first, last = int(columns[0]), int(columns[-1])
    one = nx * dx < ONE_BREAST_MM
    more = share[first : first + 5].mean() > share[last - 4 : last + 1].mean()
    x = float(first if more else last) if one else _symmetric(body, first, last)
    reach = max(round(12.0 / dx), 1)
    near = body[:, :, max(round(x) - reach, 0) : round(x) + reach + 1]
    there = near.any(axis=(1, 2))
    if not there.any():
        raise SegmentationError(
            "no body is seen at the image's midline; give an image of both breasts or of one"
        )
    front = np.where(near.any(axis=1), near.argmax(axis=1), -1).max(axis=1).astype(float)
    front = np.interp(np.arange(nz), np.flatnonzero(there), front[there])
    front = ndimage.gaussian_filter1d(ndimage.median_filter(front, 5, mode="nearest"), 3.0, mode="nearest")
    half = (last - first) * dx / (1 if one else 2)
    y = float(np.median(front)) + AXIS_SHARE * min(half, 180.0) / dy  # behind an image that is cut there
    return Axis(x, y, float(half), front)


def _symmetric(body: np.ndarray, first: int, last: int) -> float:
    """Column about which the foremost rows (nx,) of the body are most alike, 20 voxels from its middle."""
    shape = body.mean(axis=0)
    middle = (first + last) / 2
    best = [(_unlike(shape, c), c) for c in np.arange(middle - 20, middle + 20.5, 0.5)]
    return float(min(best)[1])


def _unlike(shape: np.ndarray, c: float) -> float:
    nx = shape.shape[1]
    mirrored = np.round(2 * c - np.arange(nx)).astype(int)
    both = (mirrored >= 0) & (mirrored < nx)
    return float(np.abs(shape[:, both] - shape[:, mirrored[both]]).mean())


@dataclass(frozen=True)
class Rays:
    """Where rays from the axis are sampled: slices (n,), angles in radians from straight ahead, radii in mm.

    midline_rows: row (n,) of the breastbone's skin in those slices.
    """

    grid: Grid
    axis: Axis
    slices: np.ndarray
    angles: np.ndarray
    radii: np.ndarray
    midline_rows: np.ndarray

    def on(self, grid: Grid) -> "Rays":
        """The same rays for a grid of the same field with other voxels."""
        n = self.grid.spacing / grid.spacing
        slices, rows = ((at + 0.5) * k - 0.5 for at, k in ((self.slices, n[2]), (self.midline_rows, n[1])))
        x, y = ((at + 0.5) * k - 0.5 for at, k in ((self.axis.x, n[0]), (self.axis.y, n[1])))
        axis = replace(self.axis, x=x, y=y)
        return replace(self, grid=grid, axis=axis, slices=slices, midline_rows=rows)

    @property
    def two_sided(self) -> bool:
        """Whether both sides of the body are seen."""
        return self.grid.shape[2] * self.grid.spacing[0] >= ONE_BREAST_MM

    @classmethod
    def of(cls, grid: Grid, axis: Axis) -> "Rays":
        """Over a whole grid."""
        step = max(round(SLICE_MM / grid.spacing[2]), 1)
        angles = np.radians(np.arange(-LARGEST_DEG, LARGEST_DEG + 0.5, STEP_DEG))
        reach = float(np.hypot(axis.y * grid.spacing[1], axis.half_width_mm)) + 30.0
        slices = np.arange(0, grid.shape[0], step)
        return cls(grid, axis, slices, angles, np.arange(STEP_MM, reach, STEP_MM), axis.midline[slices])

    def sampled(self, values: np.ndarray, outside: float | None = None) -> np.ndarray:
        """Values (nz, ny, nx) along the rays (slice, angle, radius), linear between voxels.

        outside: the value outside the image; without it, that of the border.
        """
        radii = np.broadcast_to(self.radii, (len(self.slices), len(self.angles), len(self.radii)))
        return self.read(values, radii, outside)

    def read(self, values: np.ndarray, radii: np.ndarray, outside: float | None = None) -> np.ndarray:
        """Values (nz, ny, nx) in the nearest slice at radii (slice, angle, any number) mm, as `sampled`."""
        dx, dy, _ = self.grid.spacing
        i = self.axis.x + np.sin(self.angles)[:, None] * radii / dx
        j = self.axis.y - np.cos(self.angles)[:, None] * radii / dy
        border = {"mode": "nearest"} if outside is None else {"mode": "constant", "cval": outside}
        nearest = np.clip(np.round(self.slices).astype(int), 0, self.grid.shape[0] - 1)
        return np.stack(
            [
                ndimage.map_coordinates(values[k], at, order=1, **border)
                for k, at in zip(nearest, np.stack([j, i], axis=1))
            ]
        ).astype(np.float32)

    def within(self, wall_mm: np.ndarray) -> np.ndarray:
        """Voxels (nz, ny, nx) bool nearer to the axis than a radius (slice, angle), or behind all rays."""
        nz, ny, nx = self.grid.shape
        dx, dy, _ = self.grid.spacing
        y, x = np.meshgrid(
            (np.arange(ny) - self.axis.y) * dy, (np.arange(nx) - self.axis.x) * dx, indexing="ij"
        )
        at = (np.arctan2(x, -y) - self.angles[0]) / np.radians(STEP_DEG)
        r, last = np.hypot(x, y), len(self.angles) - 1
        inside = np.empty(self.grid.shape, bool)
        for k in range(nz):
            row = np.interp(k, self.slices, np.arange(len(self.slices)))
            low = int(row)
            high = min(low + 1, len(self.slices) - 1)
            wall = wall_mm[low] + (row - low) * (wall_mm[high] - wall_mm[low])
            inside[k] = r < np.interp(np.clip(at, 0, last), np.arange(last + 1), wall)
        return inside


def expected_wall(rays: Rays, spacing: np.ndarray) -> np.ndarray:
    """Radius (slice, angle) mm of an ellipse behind the breastbone's skin and within the flanks."""
    ahead = (rays.axis.y - rays.midline_rows) * spacing[1] - FRONT_MM
    aside = np.minimum(rays.axis.half_width_mm - FLANK_MM, WIDEST * ahead)
    s, c = np.sin(rays.angles), np.cos(rays.angles)
    return 1 / np.sqrt((s / aside[:, None]) ** 2 + (c / np.maximum(ahead, 30.0)[:, None]) ** 2)


def layer_contrast(along: np.ndarray, step_mm: float, layer_mm: float) -> np.ndarray:
    """Mean of a layer nearer to the axis less that of one farther away, at each radius (last axis)."""
    n = max(round(layer_mm / step_mm), 1)
    # Each mean is of n // 2 samples before its place to (n - 1) // 2 after it.
    mean = ndimage.uniform_filter1d(along, n, axis=-1, mode="nearest")
    return np.roll(mean, 1 + (n - 1) // 2, axis=-1) - np.roll(mean, -1 - n // 2, axis=-1)


@dataclass(frozen=True)
class Seen:
    """Along rays (slice, angle, radius): contrast of layers in standard deviations, depth mm under skin."""

    rays: Rays
    contrast: np.ndarray
    depth: np.ndarray

    @classmethod
    def of(cls, rays: Rays, relative: np.ndarray, depth: np.ndarray) -> "Seen":
        """Of intensities (nz, ny, nx) relative to fat, and depth mm under the skin."""
        even = np.where(depth > SKIN_MM, np.clip(relative, *CLIPPED), 1)
        even = ndimage.gaussian_filter(even.astype(np.float32), SMOOTH_MM / rays.grid.spacing[::-1])
        along = ndimage.gaussian_filter(rays.sampled(even), [0.7, 0.7, 0.0])
        contrast = layer_contrast(along, STEP_MM, LAYER_MM)
        below = rays.sampled(depth, SKIN_MM)  # not seen outside
        seen = below > SKIN_MM
        return cls(rays, np.where(seen, contrast / np.std(contrast[seen]), 0).astype(np.float32), below)

    def wall(self, sign: float, expected: np.ndarray, within_mm: float, weight: float) -> np.ndarray:
        """Radius (slice, angle) mm of most sign * contrast within a distance of the expected one."""
        away = (self.rays.radii - expected[..., None]) / within_mm
        cost = np.clip(-sign * self.contrast, -3, 3) + weight * away**2
        # Under the skin an edge to something brighter may be the skin's own.
        unseen = SKIN_MM + (LAYER_MM / 2 if sign > 0 else 1.0)
        cost = np.where(self.depth < unseen, UNSEEN + weight * away**2, cost)
        cost[(np.abs(away) > 1) | (self.depth < LEAST_COVER_MM)] = FORBIDDEN
        radius: np.ndarray = self.rays.radii[depth_field(cost, penalty=PENALTY)]
        return radius

    def evidence(self, sign: float, wall: np.ndarray) -> np.ndarray:
        """sign * contrast (slice, angle) on a wall."""
        at = np.searchsorted(self.rays.radii, wall).clip(0, len(self.rays.radii) - 1)
        return sign * np.take_along_axis(self.contrast, at[..., None], 2)[..., 0]


def depth_under_skin(body: np.ndarray, spacing: np.ndarray) -> np.ndarray:
    """Depth (nz, ny, nx) mm of each voxel of the body; at the borders of the image it goes on."""
    padded = np.pad(body, 1, mode="edge")
    inner: np.ndarray = ndimage.distance_transform_edt(padded, sampling=spacing[::-1])[1:-1, 1:-1, 1:-1]
    return inner.astype(np.float32)


def symmetric_wall(wall: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Smooth mean (slice, angle) of a wall and its mirror image, both weighted by evidence (slice, angle)."""
    w = np.maximum(weight, 0.1)
    sums = (each + each[:, ::-1] for each in (w * wall, w))
    weighted, weights = (ndimage.gaussian_filter(each, SMOOTH_WALL, mode="nearest") for each in sums)
    mean: np.ndarray = weighted / weights
    return mean


def chest_wall(seen: Seen, sign: float) -> np.ndarray:
    """Radius (slice, angle) mm of the front of the muscle: near an ellipse, then near what both sides show.

    sign: 1 where muscle is brighter than the tissue before it, -1 where it is darker.
    """
    expected = expected_wall(seen.rays, seen.rays.grid.spacing)
    rough = seen.wall(sign, expected, WITHIN_MM, 0.5)
    both = symmetric_wall(rough, seen.evidence(sign, rough)) if seen.rays.two_sided else rough
    return smoothed(seen.wall(sign, both, WITHIN_MM / 2, 1.0))


def sign_of_muscle(seen: Seen) -> float:
    """1 where muscle is brighter than the fat before it, -1 where it is darker.

    Ribs and lungs behind the muscle are darker than fat. Bright muscle therefore has its brighter edge in
    front of the darkest one, by its thickness; before dark muscle, whose front is the darkest edge, nothing
    gets brighter.
    """
    ahead = np.abs(seen.rays.angles) < np.radians(AHEAD_DEG)
    brighter = chest_wall(seen, 1.0)
    in_front = (brighter - chest_wall(seen, -1.0) > LEAST_MUSCLE_MM)[:, ahead]
    edge = seen.evidence(1.0, brighter)[:, ahead][in_front]
    return 1.0 if in_front.mean() > 0.5 and edge.mean() > LEAST_EDGE else -1.0


def smoothed(wall: np.ndarray) -> np.ndarray:
    """A wall (slice, angle) without single outliers."""
    smooth: np.ndarray = ndimage.gaussian_filter(
        ndimage.median_filter(wall, 3, mode="nearest"), 0.7, mode="nearest"
    )
    return smooth
