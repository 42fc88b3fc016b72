"""Markers on the skin: bright balls in contact with the body from outside, found to a part of a voxel."""

import numpy as np
from scipy import ndimage

from mammosim.core.errors import FiducialError
from mammosim.core.fiducials import Fiducials
from mammosim.core.volume import Grid, Image
from mammosim.imaging.outline import body_mask, bright_level, coarsened

# ASSUME: a marker's blob response exceeds half the brightness of fat; corners of fat itself reach 0.37 of it.
LEAST_RESPONSE = 0.5
FINEST_MM = 1.0  # markers of 7 mm need no smaller voxels
# ASSUME: a blob within 10 mm of a listed breast marker or nipple is that one, not a chest marker.
LISTED_WITHIN_MM = 10.0
# Four points are collinear when their smaller spread is below this part of the larger one, or below 10 mm.
LEAST_SPREAD, LEAST_SPREAD_MM = 0.1, 10.0
N_CHEST = 4
SHOWN = 8


def find_markers(image: Image, *, diameter_mm: float = 7.0) -> np.ndarray:
    """Centres (n, 3) mm of the markers, the most superior first; n may be 0."""
    image = coarsened(image, FINEST_MM)
    # ASSUME: a marker's centre is less than its diameter and one voxel from the air; vessels lie deeper.
    h = image.grid.spacing[::-1]
    response = blob_response(image, diameter_mm)
    largest = ndimage.maximum_filter(response, [_odd(voxels) for voxels in diameter_mm / h])
    depth = ndimage.distance_transform_edt(body_mask(image), sampling=h)
    peak = (response == largest) & (response > LEAST_RESPONSE) & (depth < diameter_mm + h.max())
    starts = image.grid.points(np.argwhere(peak).astype(float))
    centres = np.array([_centre(image, p, diameter_mm) for p in starts]).reshape(-1, 3)
    return centres[np.argsort(-centres[:, 2], kind="stable")]


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


def _centre(image: Image, start: np.ndarray, diameter_mm: float) -> np.ndarray:
    """Centroid (3,) of what exceeds half the brightness of fat within a marker's reach, from a start (3,)."""
    level, reach = bright_level(image) / 2, diameter_mm / 2 + 1.5
    points, values = _near(image, start, reach + diameter_mm)
    centre = start
    for _ in range(2):
        w = np.maximum(values - level, 0) * (np.linalg.norm(points - centre, axis=1) < reach)
        centre = w @ points / w.sum()
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
