"""Whether points can be meant: markers and nipples lie on the skin of the image in which they were marked."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from mammosim.core.errors import FiducialError
from mammosim.core.fiducials import NIPPLES, Fiducials
from mammosim.core.volume import Grid, Image
from mammosim.imaging.outline import body_mask, coarsened

VOXEL_MM = 3.0  # the outline needs no finer voxels
# ASSUME: the middle of a marker, or a nipple that the outline smooths away, is within 8 mm of the skin, and
# half a voxel by which the outline itself is off. Right lists of digital volunteers are within 3 mm, at 4 mm.
REACH_MM = 8.0
# ASSUME: nobody marks a point at exactly 0 0 0, where programs leave what was never placed, but for one on
# the skin to 3 mm.
ZERO_MM = 3.0
# ASSUME: markers and nipples of a chest span at least 50 mm, and less than a metre.
SPANS_MM = (50.0, 1000.0)
# ASSUME: no two markers are glued on one place; points nearer than that are one, marked or copied twice.
SAME_PLACE_MM = 1.0
SHOWN = 3


@dataclass(frozen=True)
class Skin:
    """Where the body of an image ends. distance (nz, ny, nx) mm of voxel centres to it, negative inside."""

    grid: Grid
    distance: np.ndarray

    @classmethod
    def of(cls, image: Image) -> "Skin":
        """By the outline on voxels of about VOXEL_MM. Raises ImageError when no body is in the image."""
        coarse = coarsened(image, VOXEL_MM)
        body = body_mask(coarse)
        h = coarse.grid.spacing[::-1]
        half = h.min() / 2  # voxel centres are half a voxel from the outline between them, or more
        outside, inside = (ndimage.distance_transform_edt(part, sampling=h) for part in (~body, body))
        return cls(coarse.grid, np.where(body, half - inside, outside - half))

    @property
    def limit_mm(self) -> float:
        """How far from it a point can be meant to lie on it."""
        return REACH_MM + float(self.grid.spacing.mean()) / 2

    def at(self, points: np.ndarray) -> np.ndarray:
        """Distance (n,) mm of points (n, 3) to the skin, negative inside the body; NaN outside the image."""
        kji = self.grid.indices(points)
        found: np.ndarray = ndimage.map_coordinates(self.distance, kji.T, order=1, mode="nearest")
        return np.where(self.holds(points), found, np.nan)

    def holds(self, points: np.ndarray) -> np.ndarray:
        """Whether points (n, 3) lie in the image (n,)."""
        kji = self.grid.indices(points)
        within: np.ndarray = np.all((kji >= -0.5) & (kji <= np.array(self.grid.shape) - 0.5), axis=1)
        return within

    def ends(self) -> str:
        """Where the image ends, in words."""
        nz, ny, nx = self.grid.shape
        corners = self.grid.points(
            np.array(
                [[k, j, i] for k in (-0.5, nz - 0.5) for j in (-0.5, ny - 0.5) for i in (-0.5, nx - 0.5)]
            )
        )
        low, high = corners.min(axis=0), corners.max(axis=0)
        return ", ".join(f"{axis} {a:.0f} to {b:.0f}" for axis, a, b in zip("xyz", low, high)) + " mm"


def mirrored(*axes: int) -> Callable[[np.ndarray, Grid], np.ndarray]:
    """Points (n, 3) mirrored about the middle of a grid, along those of its axes that are next to x, y, z."""

    def of(points: np.ndarray, grid: Grid) -> np.ndarray:
        kji = grid.indices(points)
        for axis in axes:
            along = 2 - int(np.argmax(np.abs(grid.direction[axis])))
            kji[:, along] = grid.shape[along] - 1 - kji[:, along]
        return grid.points(kji)

    return of


# What may be wrong with all points at once: in words, what it does to them, and the next step.
Mistake = tuple[str, Callable[[np.ndarray, Grid], np.ndarray], str]
MISTAKES: tuple[Mistake, ...] = (
    (
        "with the signs of x and y reversed",
        lambda p, _: p * [-1, -1, 1],
        "they are RAS and called LPS: state RAS in the list, or reverse the signs",
    ),
    ("multiplied by 1000", lambda p, _: p * 1000, "given in metres? give mm"),
    ("multiplied by 10", lambda p, _: p * 10, "given in cm? give mm"),
    ("divided by 1000", lambda p, _: p / 1000, "given in um? give mm"),
    (
        "in metres, with the signs of x and y reversed",
        lambda p, _: p * [-1000, -1000, 1000],
        "give mm, and LPS",
    ),
    (
        "taken as voxel numbers",
        lambda p, grid: grid.points(p[:, ::-1]),
        "give mm in the patient's frame, not voxels",
    ),
    (
        "mirrored head to feet",
        mirrored(2),
        "the image or the list is upside down: correct the image's orientation",
    ),
    (
        "mirrored front to back",
        mirrored(1),
        "the image or the list is the wrong way round: correct the image's orientation",
    ),
    ("mirrored left to right", mirrored(0), "the image or the list is mirrored: correct its orientation"),
)


def mistake(
    points: np.ndarray, grid: Grid, fits: Callable[[np.ndarray], int], *, at_least: int
) -> tuple[str, str, int] | None:
    """Of MISTAKES that after whose correction most points (n, 3) fit: its words, next step, how many fit.

    fits: how many of corrected points fit; None where never at_least do.
    """
    counts = [fits(correct(points, grid)) for _, correct, _ in MISTAKES]
    best = int(np.argmax(counts))
    words, _, step = MISTAKES[best]
    return (words, step, counts[best]) if counts[best] >= at_least else None


def require_plausible(listed: Fiducials, image: Image) -> None:
    """Raise FiducialError, a line without the file, where points cannot be meant in the image they go with.

    That is: most would lie on its skin in another frame or unit; one lies outside the image, in the air, deep
    in the body or where programs leave what was not placed; two lie at one place; left is not left.
    """
    skin = Skin.of(image)
    off = skin.at(listed.points)
    bad = ~(np.abs(off) <= skin.limit_mm)
    unplaced = np.all(listed.points == 0, axis=1) & ~(np.abs(off) <= ZERO_MM)
    if np.count_nonzero(bad) > 1 or not _spans(listed.points):
        _require_no_mistake(listed, skin, int(np.count_nonzero(bad)))
    if unplaced.any():
        name = listed.names[int(np.argmax(unplaced))]
        raise FiducialError(f"{name} {_place(off[unplaced][0])}, at 0 0 0: was it placed? mark it again")
    if bad.any():
        raise FiducialError(_off_the_skin(listed, skin, off, bad))
    _require_apart(listed)
    if not _left_is_left(listed.points, listed.names):
        x = [listed.point(name)[0] for name in NIPPLES]
        raise FiducialError(
            f"nipple_left lies to the right of nipple_right, at x = {x[0]:.0f} and {x[1]:.0f} mm, and x "
            "grows to her left; exchange their names, unless the image is mirrored"
        )


def _require_no_mistake(listed: Fiducials, skin: Skin, n_bad: int) -> None:
    """Raise FiducialError where one mistake explains almost all points that are off."""
    n, span = len(listed.names), float(np.ptp(listed.points, axis=0).max())

    def fits(points: np.ndarray) -> int:
        meant = _left_is_left(points, listed.names) and _spans(points)
        return int(np.count_nonzero(np.abs(skin.at(points)) <= skin.limit_mm)) if meant else 0

    least = n - n // 8 if not _spans(listed.points) else max(n - n_bad + 2, n - n // 8)
    if found := mistake(listed.points, skin.grid, fits, at_least=least):
        words, step, count = found
        raise FiducialError(
            f"{n} points span {span:.3g} mm, {n_bad} of them far from the skin of the image; {words}, "
            f"{count} of {n} lie on it: {step}"
        )


def _require_apart(listed: Fiducials) -> None:
    """Raise FiducialError where two points lie at one place."""
    apart = np.linalg.norm(listed.points[:, None] - listed.points[None], axis=2)
    apart[np.tril_indices(len(apart))] = np.inf
    if (apart < SAME_PLACE_MM).any():
        a, b = np.unravel_index(np.argmin(apart), apart.shape)
        raise FiducialError(
            f"{listed.names[a]} and {listed.names[b]} lie at one place, {apart[a, b]:.2g} mm apart; mark one "
            "anew"
        )


def _spans(points: np.ndarray) -> bool:
    """Whether points are as far apart as markers and nipples are; nothing is known of one."""
    least, most = SPANS_MM
    return len(points) < 2 or bool(least <= np.ptp(points, axis=0).max() < most)


def _left_is_left(points: np.ndarray, names: tuple[str, ...]) -> bool:
    """Whether the left nipple has the larger x, where both are listed."""
    if not set(NIPPLES) <= set(names):
        return True
    left, right = (points[names.index(name)] for name in NIPPLES)
    return bool(left[0] > right[0])


def _off_the_skin(listed: Fiducials, skin: Skin, off: np.ndarray, bad: np.ndarray) -> str:
    """Which points are off, where, and what may be the reason."""
    names = [name for name, wrong in zip(listed.names, bad) if wrong]
    places = [f"{name} {_place(d)}" for name, d in zip(names, off[bad])]
    more = f" and {len(places) - SHOWN} more" if len(places) > SHOWN else ""
    if np.isnan(off[bad]).all():
        why = f"the image ends at {skin.ends()}: give the image in which they were marked, or mark them again"
    elif len(names) > 1 and not any(name.startswith("chest") for name in names):
        why = "were they marked in the image of another position? give the list of this one"
    else:
        why = "mark anew in this image, or give the list of this position"
    usual = f"markers and nipples lie within {skin.limit_mm:.0f} mm of it"
    return f"{', '.join(places[:SHOWN])}{more}; {usual}; {why}"


def _place(distance: float) -> str:
    """Where a point is that is so far from the skin."""
    if np.isnan(distance):
        return "is outside the image"
    return f"is {abs(distance):.0f} mm {'under' if distance < 0 else 'from'} the skin" + (
        "" if distance < 0 else ", in the air"
    )
