"""Where one chest lies over another without any marker: by their skins, then by all shifts at once.

Breasts hang or spread, and a table flattens a back, so that only a part of one skin ever lies on the other:

    skin:        sum of the KEPT smallest d(T p)^2, d the signed distance from the fixed skin, p points of the
                 moving one (trimmed closest points: Chetverikov et al., Image Vis Comput 23:299, 2005)
    brightness:  r(t), Pearson's correlation inside both rib cages for every shift t, by Fourier transforms
                 of masked images (Padfield, IEEE Trans Image Process 21:2706, 2012)

The skin of a torso is nearly a cylinder: it says how the torso lies, and not how far along. The correlation
says that, for the turn of the skin, its neighbours, and a grid of others, should the skin mislead.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from scipy import fft, ndimage
from scipy.spatial.transform import Rotation
from skimage.measure import marching_cubes

from mammosim.core.rigid import RigidTransform, rotation
from mammosim.core.volume import Grid, Image
from mammosim.imaging.outline import body_mask, coarsened, spread_linearly

# ASSUME: between two positions the chest turns by at most 20 degrees about each axis of the patient frame.
TURNS_DEG = (-20.0, -10.0, 0.0, 10.0, 20.0)
NEAR_TURNS_DEG = (-5.0, 0.0, 5.0)  # about the turn of the skin
# ASSUME: at least half of the smaller of the two rib cages in view is in both images.
LEAST_SHARED = 0.5
SEARCH_VOXEL_MM = 12.0
# ASSUME: three fifths of the skin, of the sides and the breastbone, stay as they are against the rib cage.
KEPT = 0.6
SKIN_POINTS, SKIN_STEPS = 3000, 30
# ASSUME: a coil's sensitivity changes over more than this, and the organs of a chest over less.
EVEN_MM, EVEN_VOXEL_MM = 40.0, 8.0
DARKEST = 1e-3  # of the brightest surroundings: what is darker is no signal
# Two starts are the same one when the middle of the rib cage is brought to places as near as this.
APART_MM = 20.0


@dataclass(frozen=True)
class Chest:
    """An image as it is aligned: brightness relative to that around, 0 in air; the body; the rib cage."""

    image: Image
    body: np.ndarray
    inside: np.ndarray

    @property
    def middle(self) -> np.ndarray:
        """Centre (3,) mm of the rib cage in view."""
        middle: np.ndarray = self.image.grid.points(np.argwhere(self.inside).mean(axis=0)[None])[0]
        return middle


@dataclass(frozen=True)
class Start:
    """A motion from the moving into the fixed frame, and the correlation at voxels of SEARCH_VOXEL_MM."""

    motion: RigidTransform
    correlation: float


def evened(image: Image, body: np.ndarray) -> Image:
    """I / (G * I), the means over the body around within EVEN_MM: without what a coil's sensitivity does."""
    grid, weight = image.grid, body.astype(np.float32)
    light, near = (coarsened(Image(grid, v), EVEN_VOXEL_MM) for v in (image.values * weight, weight))
    sigma = EVEN_MM / near.grid.spacing[::-1]
    sums = [ndimage.gaussian_filter(each.values, sigma, truncate=2.0) for each in (light, near)]
    mean = spread_linearly(sums[0] / np.maximum(sums[1], 1e-3), grid, EVEN_VOXEL_MM)
    bright = np.where(body, image.values / np.maximum(mean, DARKEST * mean.max()), 0)
    return replace(image, values=bright.astype(np.float32))


def starts(fixed: Chest, moving: Chest) -> tuple[Start, ...]:
    """The best shift for each turn, the best of all first; none nearer than APART_MM to a better one."""
    skin = aligned_skins(fixed, moving)
    near = (rotation(np.array(turn)) @ skin.R for turn in product(NEAR_TURNS_DEG, repeat=3))
    far = (rotation(np.array(turn)) for turn in product(TURNS_DEG, repeat=3))
    found = sorted(_best_shifts(fixed, moving, (*near, *far)), key=lambda start: -start.correlation)
    kept: list[Start] = []
    for start in found:
        places = [each.motion(moving.middle[None])[0] for each in kept]
        if all(np.linalg.norm(start.motion(moving.middle[None])[0] - at) > APART_MM for at in places):
            kept.append(start)
    return tuple(kept)


def aligned_skins(fixed: Chest, moving: Chest) -> RigidTransform:
    """The motion that lays most of the moving skin on the fixed one, from rib cages over each other."""
    grid, distance = _skin_distance(fixed)
    slopes = np.stack(np.gradient(distance, *grid.spacing[::-1])[::-1], axis=-1)
    points = skin_points(moving)
    motion = RigidTransform(np.eye(3), fixed.middle - moving.middle)
    for _ in range(SKIN_STEPS):
        step = _skin_step(grid, distance, slopes, motion(points))
        motion = orthonormal(step.after(motion))
        if step.angle_deg < 0.01 and np.linalg.norm(step(fixed.middle[None])[0] - fixed.middle) < 0.02:
            break
    return motion


def skin_points(chest: Chest) -> np.ndarray:
    """About SKIN_POINTS points (n, 3) mm of the skin, none where the image ends."""
    body = ndimage.gaussian_filter(chest.body.astype(np.float32), 1.0, mode="nearest")
    vertices, _, _, _ = marching_cubes(body, 0.5)
    whole = np.all((vertices > 1.5) & (vertices < np.array(body.shape) - 2.5), axis=1)
    vertices = vertices[whole]
    points: np.ndarray = chest.image.grid.points(
        vertices[:: max(1, len(vertices) // SKIN_POINTS)].astype(float)
    )
    return points


def _skin_distance(chest: Chest) -> tuple[Grid, np.ndarray]:
    """Signed distance (nz, ny, nx) mm from the skin, negative inside; where the image ends is no skin."""
    h = chest.image.grid.spacing[::-1]
    inside, outside = (ndimage.distance_transform_edt(part, sampling=h) for part in (chest.body, ~chest.body))
    return chest.image.grid, outside - inside


def _skin_step(grid: Grid, distance: np.ndarray, slopes: np.ndarray, x: np.ndarray) -> RigidTransform:
    """One Gauss-Newton step for moved points x (n, 3): (J^T J + 1e-3 D) (u, w) = -J^T d, J = (n, x x n)."""
    at = grid.indices(x).T
    seen = np.all((at.T > 0.5) & (np.array(distance.shape) - 1.5 > at.T), axis=1)
    d = np.where(seen, ndimage.map_coordinates(distance, at, order=1, mode="nearest"), np.inf)
    kept = np.argsort(np.abs(d), kind="stable")[: int(KEPT * len(x))]
    kept = kept[np.isfinite(d[kept])]
    n = np.stack([ndimage.map_coordinates(slopes[..., k], at[:, kept], order=1) for k in range(3)], axis=1)
    n = n @ grid.direction.T
    middle = x[kept].mean(axis=0)
    J = np.hstack([n, np.cross(x[kept] - middle, n)])
    # What the skin does not fix, as the shift along a cylinder, stays as it is.
    damping = 1e-3 * len(kept) * np.repeat([1.0, 10.0], 3)
    u = -np.linalg.solve(J.T @ J + np.diag(damping), J.T @ d[kept])
    R = Rotation.from_rotvec(u[3:]).as_matrix()
    return RigidTransform(R, middle - R @ middle + u[:3])


def orthonormal(motion: RigidTransform) -> RigidTransform:
    """The same without what rounding adds to a product of rotations."""
    U, _, Vt = np.linalg.svd(motion.R)
    return RigidTransform(U @ Vt, motion.t)


def _best_shifts(fixed: Chest, moving: Chest, turns: tuple[np.ndarray, ...]) -> Iterator[Start]:
    """For each turn the shift of highest correlation; none where all shifts leave too little in common."""
    still = _turned(fixed, np.eye(3))
    spectra = None
    for R in turns:
        turned = _turned(moving, R)
        shape = tuple(a + b - 1 for a, b in zip(still.values.shape, turned.values.shape))
        if spectra is None or spectra.shape != shape:
            spectra = _Spectra.of(still, shape)
        found = spectra.best(turned)
        if found is None:
            continue
        shift, r = found
        yield Start(RigidTransform(R, still.low + SEARCH_VOXEL_MM * shift - turned.low), r)


@dataclass(frozen=True)
class _Turned:
    """Values and mask (nz, ny, nx) on voxels of SEARCH_VOXEL_MM along the axes of the patient frame.

    low (3,) mm: R p of the first voxel, for p in the chest's own frame.
    """

    values: np.ndarray
    mask: np.ndarray
    low: np.ndarray


def _turned(chest: Chest, R: np.ndarray) -> _Turned:
    """The rib cage of a chest turned about the origin."""
    voxels = np.argwhere(chest.inside)
    grid = chest.image.grid
    ends = np.array(list(product(*zip(voxels.min(axis=0), voxels.max(axis=0)))), float)
    corners = grid.points(ends) @ R.T
    low = corners.min(axis=0)
    nx, ny, nz = (np.ceil((corners.max(axis=0) - low) / SEARCH_VOXEL_MM).astype(int) + 1).tolist()
    coarse = Grid((nz, ny, nx), np.full(3, SEARCH_VOXEL_MM), low)
    at = grid.indices(coarse.centres() @ R).T
    values, mask = (
        ndimage.map_coordinates(part, at, order=1, output=np.float32).reshape(coarse.shape)
        for part in (chest.image.values, chest.inside.astype(np.float32))
    )
    return _Turned(values, mask > 0.5, low)


@dataclass(frozen=True)
class _Spectra:
    """Fourier transforms of mask m, m f and m f^2 of the fixed image, by the shape (3,) of all shifts."""

    shape: tuple[int, ...]
    parts: tuple[np.ndarray, ...]
    size: tuple[int, ...]
    voxels: int

    @classmethod
    def of(cls, still: _Turned, shape: tuple[int, ...]) -> "_Spectra":
        """Padded to a size that transforms fast."""
        size = tuple(fft.next_fast_len(n, real=True) for n in shape)
        parts = tuple(fft.rfftn(part, size) for part in _moments(still))
        return cls(shape, parts, size, int(still.mask.sum()))

    def best(self, turned: _Turned) -> tuple[np.ndarray, float] | None:
        """The shift (3,) (x, y, z) in voxels of highest correlation, and that."""
        m, mf, mff = self.parts
        n, ng, ngg = (np.conj(fft.rfftn(part, self.size)) for part in _moments(turned))
        N, F, FF, G, GG, FG = (
            fft.irfftn(part, self.size) for part in (m * n, mf * n, mff * n, m * ng, m * ngg, mf * ng)
        )
        both = np.rint(N)
        N = np.maximum(both, 1)
        spread = np.maximum(FF - F**2 / N, 1e-6) * np.maximum(GG - G**2 / N, 1e-6)
        enough = both >= LEAST_SHARED * min(self.voxels, int(turned.mask.sum()))
        r = np.where(enough, (FG - F * G / N) / np.sqrt(spread), -1)
        if not enough.any():
            return None
        at = np.array(np.unravel_index(r.argmax(), r.shape))
        first = np.array(turned.values.shape)  # shifts below 0 stand at the end
        shift = np.where(at > np.array(self.size) - first, at - np.array(self.size), at)
        return shift[::-1].astype(float), float(r.max())


def _moments(image: _Turned) -> tuple[np.ndarray, ...]:
    """m, m f and m f^2 of a mask m and values f."""
    m = image.mask.astype(np.float64)
    return m, m * image.values, m * image.values.astype(np.float64) ** 2


def chest_of(image: Image, inside: np.ndarray) -> Chest:
    """A chest as it is aligned, of an image and its rib cage (nz, ny, nx)."""
    body = body_mask(image)
    return Chest(evened(image, body), body, inside.astype(bool))
