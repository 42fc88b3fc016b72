"""Whether labels were drawn in the image that is given with them, and the same way round.

Labels that are mirrored under a right header still lie in the body. Two measures tell, for the labels as they
are, and mirrored along one axis or more, or with the signs of x and y reversed, as RAS taken for LPS:

    d: mean distance of the foremost labelled voxel of each row along y from the skin that the image shows
    R2 = 1 - sum_l n_l var_l / (n var): the part of the variance of its brightness that the tissues l explain

over the voxels of soft tissue. In 14 label maps of 8 series (digital volunteers, Duke 001, a made one) d was
1.0 to 2.2 mm as given and 1.9 to 30 mm mirrored, R2 1.6 to 10 times as large as given as mirrored. Moved
along an axis, those of Duke 001 and of digital volunteers had d of 3.2 to 8.2 mm by 10 mm, and 5.9 to
15.7 mm by 20 mm; R2 was 0.06 to 0.64 and 0.09 to 0.41 of that as given.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from mammosim.core.errors import ImageError
from mammosim.core.labels import DEFORMABLE, Label
from mammosim.core.volume import Grid, Image, LabelMap
from mammosim.imaging.outline import coarsened
from mammosim.imaging.plausible_points import VOXEL_MM, Skin, mirrored

# ASSUME: labels that were drawn in an image have half of their tissue, or more, in the body that it shows,
# and half of their front, or more, on its skin.
LEAST_IN_BODY = 0.5
MOST_COMPARED, MOST_EXPLAINED = 5000, 200_000  # voxels
AXES = ("left to right", "front to back", "head to feet")
# Distances count up to this, that of labels beyond the image, too.
FAR_MM = 30.0
# ASSUME: labels are mirrored where that explains a quarter more of the brightness and the skin fits better,
# or, of a single tissue, which explains none, where their skin fits by a quarter better.
BETTER = 1.25
# ASSUME: labels lie elsewhere than drawn where their skin is 3 mm off or more, and, in steps of 10 mm,
# a place is found where it fits half as well again, and so does the brightness; of a single tissue, the skin
# twice as well.
NEAR_MM, STEP_MM, MOST_STEPS = 3.0, 10.0, 4
CLEARLY, TWICE = 1.5, 2.0
STEPS = [n * STEP_MM * axis for n in range(-MOST_STEPS, MOST_STEPS + 1) if n for axis in np.eye(3)]
WITHIN = tuple(label for label in Label if label not in (Label.AIR, Label.MARKER))

Correction = Callable[[np.ndarray, Grid], np.ndarray]


# What may be wrong, in words, and what undoes it: each is its own inverse.
TURNED: tuple[tuple[str, Correction], ...] = (
    ("with the signs of x and y reversed", lambda points, _: points * [-1, -1, 1]),
    *(
        (f"mirrored {' and '.join(AXES[axis] for axis in axes)}", mirrored(*axes))
        for count in (1, 2, 3)
        for axes in combinations(range(3), count)
    ),
)


@dataclass(frozen=True)
class _Fit:
    """d: distance mm of their skin from that of the image; R2: part of the brightness explained, or NaN."""

    d: float
    R2: float

    def is_better(self, given: "_Fit") -> bool:
        """Whether this is so much better than the labels as given that they cannot be meant so."""
        if np.isnan(given.R2):
            return self.d * BETTER < given.d
        return self.d < given.d and self.R2 > BETTER * given.R2

    def is_where(self, given: "_Fit") -> bool:
        """Whether labels that were moved fit so much better that they cannot be meant as given."""
        if np.isnan(given.R2):
            return self.d * TWICE < given.d
        return self.d * CLEARLY < given.d and self.R2 > CLEARLY * given.R2

    def __str__(self) -> str:
        explained = "" if np.isnan(self.R2) else f", and they explain {100 * self.R2:.0f} % of the brightness"
        return f"their skin is {self.d:.1f} mm from that of the image{explained}"


def require_drawn_in(labels: LabelMap, image: Image) -> None:
    """Raise ImageError, a line without the files, where labels cannot have been drawn in an image.

    That is: most of their tissue is outside the body, or most of their front is off its skin, or they fit it
    better mirrored, turned round or moved.
    """
    skin = Skin.of(image)
    _require_in_body(labels, skin)
    compared = _Compared.of(labels, image, skin)
    given = compared.fit(lambda points, _: points)
    turned = [(words, compared.fit(correct)) for words, correct in TURNED]
    words, best = min(turned, key=lambda each: each[1].d)
    shift, there = _moved(compared, given)
    if there.d < best.d and there.d <= skin.limit_mm / 2 and there.is_where(given):
        raise ImageError(
            f"the labels lie elsewhere than in the image: as given {given}; moved by {shift} mm (left, "
            f"back, up) {there}; give both of one series, or export both again from one program"
        )
    if best.d <= skin.limit_mm and best.is_better(given):
        raise ImageError(
            f"the labels are oriented otherwise than the image: as given {given}; {words} {best}; export "
            "both again from one program, or correct the orientation of one of them"
        )
    _require_on_skin(compared.front(lambda points, _: points), skin)


def _moved(compared: "_Compared", given: _Fit) -> tuple[str, _Fit]:
    """By how much labels fit best, in words, and how well: step by step, where they are far enough off."""
    best, shift = given, np.zeros(3)
    for _ in range(MOST_STEPS if given.d >= NEAR_MM else 0):
        tried = [shift + step for step in STEPS]
        fits = [compared.moved(each).fit(lambda points, _: points) for each in tried]
        n = int(np.argmin([fit.d for fit in fits]))
        if fits[n].d >= best.d:
            break
        best, shift = fits[n], tried[n]
    return " ".join(f"{step:.0f}" for step in shift), best


def _require_in_body(labels: LabelMap, skin: Skin) -> None:
    voxels = np.argwhere(np.isin(labels.values, DEFORMABLE)).astype(float)
    points = labels.grid.points(voxels[:: 1 + len(voxels) // MOST_COMPARED])
    share = np.mean(skin.at(points) <= skin.limit_mm)
    if share < LEAST_IN_BODY:
        raise ImageError(
            f"{100 * share:.0f} % of the labelled tissue lie in the body that the image shows, at least "
            f"{100 * LEAST_IN_BODY:.0f} % should; the image ends at {skin.ends()}: give both of one position "
            "and in one frame (LPS, mm)"
        )


def _require_on_skin(front: np.ndarray, skin: Skin) -> None:
    share = np.mean(np.abs(skin.at(front)) <= skin.limit_mm)
    if share < LEAST_IN_BODY:
        raise ImageError(
            f"{100 * share:.0f} % of the front of the labelled tissue lie within {skin.limit_mm:.0f} mm of "
            f"the skin that the image shows, at least {100 * LEAST_IN_BODY:.0f} % should; the image ends at "
            f"{skin.ends()}: give both of one position and in one frame (LPS, mm)"
        )


@dataclass(frozen=True)
class _Compared:
    """Labels with an image: ends (2, n, 3) mm, their first and last voxels along y; centres (m, 3) of its.

    brightness (m,): of these, the brightest hundredth cut off.
    """

    labels: LabelMap
    skin: Skin
    ends: np.ndarray
    centres: np.ndarray
    brightness: np.ndarray

    @classmethod
    def of(cls, labels: LabelMap, image: Image, skin: Skin) -> "_Compared":
        image = coarsened(image, VOXEL_MM)
        I = image.values.ravel()
        some = slice(None, None, 1 + len(I) // MOST_EXPLAINED)
        bright = np.minimum(I, np.percentile(I, 99))
        return cls(labels, skin, _ends(labels), image.grid.centres()[some], bright[some])

    def moved(self, shift: np.ndarray) -> "_Compared":
        """With the labels moved by (3,) mm."""
        grid = replace(self.labels.grid, origin=self.labels.grid.origin + shift)
        return replace(self, labels=replace(self.labels, grid=grid), ends=self.ends + shift)

    def front(self, correct: Correction) -> np.ndarray:
        """Those ends (n, 3) mm that lie in front after a correction."""
        ends = (correct(end, self.labels.grid) for end in self.ends)
        return min(ends, key=lambda points: float(points[:, 1].mean()))

    def fit(self, correct: Correction) -> _Fit:
        """How well they fit after a correction that is its own inverse."""
        grid = self.labels.grid
        d = np.abs(self.skin.at(self.front(correct)))
        kji = np.rint(grid.indices(correct(self.centres, grid))).astype(int)
        there = np.all((kji >= 0) & (kji < grid.shape), axis=1)
        label = self.labels.values[tuple(kji[there].T)]
        inside = np.isin(label, DEFORMABLE)
        d = np.minimum(np.where(np.isnan(d), FAR_MM, d), FAR_MM)
        return _Fit(float(d.mean()), _explained(self.brightness[there][inside], label[inside]))


def _ends(labels: LabelMap) -> np.ndarray:
    """Centres (2, n, 3) of the first and last labelled voxel of rows along y, of about MOST_COMPARED rows."""
    body = np.isin(labels.values, WITHIN)
    k, i = (at[:: 1 + len(at) // MOST_COMPARED] for at in np.nonzero(body.any(axis=1)))
    first, last = body.argmax(axis=1)[k, i], body.shape[1] - 1 - body[:, ::-1].argmax(axis=1)[k, i]
    rows = (np.stack([k, j, i], axis=1).astype(float) for j in (first, last))
    return np.array([labels.grid.points(voxels) for voxels in rows])


def _explained(brightness: np.ndarray, label: np.ndarray) -> float:
    """R2 of the brightness (n,) by labels (n,), NaN where there is one label, or nothing to explain."""
    n = np.bincount(label)
    total = float(brightness.var()) * len(brightness) if len(brightness) else 0.0
    if np.count_nonzero(n) < 2 or total == 0:
        return float("nan")
    mean = np.bincount(label, brightness) / np.maximum(n, 1)
    return 1 - float(np.sum((brightness - mean[label]) ** 2)) / total
