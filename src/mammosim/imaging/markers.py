"""Markers on the skin: bright balls in contact with the body from outside, found to a part of a voxel."""

import numpy as np
from scipy import ndimage

from mammosim.core.errors import FiducialError
from mammosim.core.fiducials import Fiducials
from mammosim.core.volume import Grid, Image
from mammosim.imaging.outline import body_mask, bright_level, coarsened

# ASSUME: a marker's blob response exceeds half the brightness of fat; corners of fat itself reach 0.37 of it.
LEAST_RESPONSE = 0.5
# ASSUME: it has the stated size: where it is, a ball one and a half times as large answers less.
SIZES = (1.0, 1.5)
# ASSUME: it stands out of the skin: of a sphere 2.5 mm and half a voxel around it more than half is air
# (three quarters where it touches a plane in one point); and it touches the body, so that not all of it is.
BESIDE_MM, AIR_ROUND, DIRECTIONS = 2.5, (0.5, 0.97), 200
# ASSUME: it is sharp: on the air's part of that sphere the image is less than 0.35 times as bright as it.
LEFT_BESIDE = 0.35
FINEST_MM = 1.5  # markers of 7 mm are seen in such voxels; their centres are taken from the image's own
# ASSUME: a blob within 10 mm of a listed breast marker or nipple is that one, not a chest marker.
LISTED_WITHIN_MM = 10.0
# Four points are collinear when their smaller spread is below this part of the larger one, or below 10 mm.
LEAST_SPREAD, LEAST_SPREAD_MM = 0.1, 10.0
N_CHEST = 4
SHOWN = 8


def find_markers(image: Image, *, diameter_mm: float = 7.0) -> np.ndarray:
    """Centres (n, 3) mm of the markers, the most superior first; n may be 0: most images have none.

    A marker is a bright ball of its diameter, on the skin, and out of it.
    """
    coarse = coarsened(image, FINEST_MM)
    h = coarse.grid.spacing[::-1]
    response, larger = (blob_response(coarse, size * diameter_mm) for size in SIZES)
    largest = ndimage.maximum_filter(response, [_odd(voxels) for voxels in diameter_mm / h])
    peak = (response == largest) & (response > np.maximum(LEAST_RESPONSE, larger))
    body = body_mask(coarse)
    peaks = coarse.grid.points(np.argwhere(peak).astype(float))
    starts = [start for start in peaks if _stands_out(coarse, body, start, diameter_mm)]
    level = bright_level(coarse) / 2
    centres = [_centre(image, start, diameter_mm, level) for start in starts]
    found = np.array(centres).reshape(-1, 3)
    return found[np.argsort(-found[:, 2], kind="stable")]


def _stands_out(image: Image, body: np.ndarray, centre: np.ndarray, diameter_mm: float) -> bool:
    """Whether a ball around a centre (3,) touches the body (nz, ny, nx) from outside, and is sharp."""
    radius = diameter_mm / 2 + BESIDE_MM + image.grid.spacing.max() / 2
    at = np.vstack([centre, centre + radius * _sphere(DIRECTIONS)])
    voxels = np.round(image.grid.indices(at)).astype(int)
    voxels = voxels[((voxels >= 0) & (voxels < image.grid.shape)).all(axis=1)]
    values, air = image.values[tuple(voxels.T)], ~body[tuple(voxels.T)]
    low, high = AIR_ROUND
    if not low < air[1:].mean() < high:
        return False
    dark = np.percentile(image.values[~body], 50) if not body.all() else 0.0
    return bool(np.median(values[1:][air[1:]]) - dark < LEFT_BESIDE * (values[0] - dark))


def _sphere(n: int) -> np.ndarray:
    """n directions (n, 3), almost evenly spread: a Fibonacci lattice."""
    k = np.arange(n)
    z, phi = 1 - (2 * k + 1) / n, k * np.pi * (3 - np.sqrt(5))
    r = np.sqrt(1 - z**2)
    return np.column_stack([r * np.cos(phi), r * np.sin(phi), z])


def chest_markers(image: Image, listed: Fiducials, *, diameter_mm: float = 7.0) -> Fiducials:
    """The list with its chest markers replaced by the four blobs that are none of its other points.

    They are named chest_1..4 from superior to inferior; their names do not correspond between images.
    Raises FiducialError when not exactly four remain, or when they are collinear.
    """
    found = find_markers(image, diameter_mm=diameter_mm)
    other = np.array([kind != "chest" for kind in listed.kinds], bool)
    known = listed.points[other].reshape(-1, 3)
    distance = np.linalg.norm(found[:, None] - known[None], axis=2)
    chest = found[~(distance < LISTED_WITHIN_MM).any(axis=1)]
    require_four(chest)
    names = [name for name, keep in zip(listed.names, other) if keep]
    kinds = [kind for kind, keep in zip(listed.kinds, other) if keep]
    return Fiducials(
        (*(f"chest_{k + 1}" for k in range(N_CHEST)), *names),
        (*["chest"] * N_CHEST, *kinds),
        np.vstack([chest, known]),
    )


def worn_on_chest(listed: Fiducials, image: Image | None) -> Fiducials:
    """The list with its four chest markers, as found in the image where one is given; or with none.

    There are none where the list has none, and not four are found. Raises FiducialError: a list that has
    some has not four, or collinear ones, or they are not found.
    """
    worn = len(listed.of_kind("chest")) > 0
    if image is not None:
        try:
            return chest_markers(image, listed)
        except FiducialError:
            if worn:
                raise
    if worn:
        require_four(listed.of_kind("chest"))
    return listed


def require_four(chest: np.ndarray) -> None:
    """Raises FiducialError unless chest (n, 3) mm are four points that fix a rigid motion."""
    places = "; ".join(f"({x:.1f}, {y:.1f}, {z:.1f})" for x, y, z in chest[:SHOWN]) or "nowhere"
    if len(chest) != N_CHEST:
        raise FiducialError(
            f"{len(chest)} chest markers at {places} mm, {N_CHEST} are needed; list chest_1 to "
            f"chest_{N_CHEST} by hand (chest_markers: listed), or list the missing breast markers"
        )
    along, across, _ = np.linalg.svd(chest - chest.mean(axis=0), compute_uv=False)
    if across < max(LEAST_SPREAD * along, LEAST_SPREAD_MM):
        raise FiducialError(
            f"the {N_CHEST} chest markers at {places} mm are collinear: they spread {along:.0f} mm along "
            f"a line and {across:.1f} mm across, at least {LEAST_SPREAD_MM:g} mm and {LEAST_SPREAD:.0%} are "
            "needed to fix a rotation; correct the list, or place a marker beside the line"
        )


def blob_response(image: Image, diameter_mm: float) -> np.ndarray:
    """-sigma^2 laplace(G_sigma * I) / I_fat (nz, ny, nx): how much a voxel is the middle of a bright ball.

    A ball of radius R answers most at sigma = R / sqrt(3) (Lindeberg, Int J Comput Vis 30:79, 1998).
    """
    h = image.grid.spacing[::-1]
    sigma = np.maximum(diameter_mm / 2 / np.sqrt(3), 0.5 * h)
    smooth = ndimage.gaussian_filter(image.values, sigma / h)
    response = np.zeros_like(smooth)
    for axis, (s, d) in enumerate(zip(sigma, h)):
        response -= ndimage.correlate1d(smooth, [1, -2, 1], axis) * (s / d) ** 2
    return response / bright_level(image)


def _centre(image: Image, start: np.ndarray, diameter_mm: float, level: float) -> np.ndarray:
    """Centroid (3,) of what exceeds a level within a marker's reach, from a start (3,)."""
    reach = diameter_mm / 2 + 1.5
    points, values = _near(image, start, reach + diameter_mm)
    centre = start
    for _ in range(2):
        w = np.maximum(values - level, 0) * (np.linalg.norm(points - centre, axis=1) < reach)
        centre = w @ points / w.sum() if w.any() else centre
    return centre


def _near(image: Image, point: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n, 3) and values (n,) of the voxels in a box round a point."""
    middle = image.grid.indices(point[None])[0]
    steps = reach / image.grid.spacing[::-1]
    low = np.maximum(np.floor(middle - steps), 0).astype(int)
    high = np.minimum(np.ceil(middle + steps) + 1, image.grid.shape).astype(int)
    box = tuple(slice(a, b) for a, b in zip(low, high))
    sub = Grid(
        tuple(high - low),
        image.grid.spacing,
        image.grid.points(low[None].astype(float))[0],
        image.grid.direction,
    )
    return sub.centres(), image.values[box].ravel()


def _odd(voxels: float) -> int:
    return max(int(voxels) // 2 * 2 + 1, 3)
