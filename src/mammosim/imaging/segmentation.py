"""Tissue labels of an image: from a few strokes by classifier, speed image and active contour, else without.

Without strokes they are those of `imaging.unsupervised`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from scipy import ndimage

from mammosim.core.errors import ConfigurationError, SegmentationError
from mammosim.core.labels import Label
from mammosim.core.progress import progress
from mammosim.core.rng import generator
from mammosim.core.volume import Image, LabelMap
from mammosim.imaging.features import NAMES, features
from mammosim.imaging.markers import find_markers
from mammosim.imaging.outline import body_mask, coarsened, fill_axial, largest_part, spread
from mammosim.imaging.unsupervised import outermost, unsupervised

# scikit-learn is imported where it is used: it takes half a second that most stages of images need not.
if TYPE_CHECKING:
    from sklearn.base import ClassifierMixin

# ASSUME: a voxel of which the classifier is sure by 90 % is a seed, as the strokes are.
SURE = 0.9


def speed(p: np.ndarray) -> np.ndarray:
    """S = 2 p - 1 in [-1, 1] of a probability: outward where the tissue is likely, inward elsewhere."""
    return 2 * p - 1


def grow(p: np.ndarray, seeds: np.ndarray, *, within: np.ndarray, smoothing: int) -> np.ndarray:
    """Region (nz, ny, nx) bool that a contour reaches from seeds where S > 0, smoothed by curvature.

    p, seeds, within: (nz, ny, nx); smoothing: number of curvature steps.
    Each step is threshold dynamics (Merriman, Bence & Osher 1992; with a data term Esedoglu & Tsai 2006),
    u <- [G * (2 u - 1) + S > 0] with a Gaussian G of one voxel: the front moves by its curvature and by S.
    """
    S = np.where(within, speed(p), -1.0).astype(np.float32)
    start = (seeds | (p >= SURE)) & (S > 0)
    u = ndimage.binary_propagation(start, mask=S > 0)
    for _ in range(smoothing):
        u = (ndimage.gaussian_filter(2 * u.astype(np.float32) - 1, 1.0, truncate=3.0) + S > 0) & within
    return u


TISSUES = (Label.AIR, Label.ADIPOSE, Label.GLANDULAR, Label.SKIN, Label.MUSCLE, Label.THORAX)
SOFT = (Label.ADIPOSE, Label.GLANDULAR, Label.SKIN, Label.MUSCLE)
# ASSUME: the thorax is at least 6 mm from the air, behind skin, fat and muscle.
LEAST_COVER_MM = 6.0
SKIN_MM = 3.0
# ASSUME: under the outermost layer a voxel is skin where the classifier is sure of it by 60 %; before fat the
# body is a voxel larger where skin is likely by 15 %: the skin, thinner than a voxel, is half air there.
# Both by six scans of the digital volunteers (docs/decisions/segmentation.md).
SURE_SKIN, LEAST_SKIN = 0.6, 0.15
LEAST_POINTS = 3
# What must be painted; air is known round the body.
NEEDED = tuple(label.tissue for label in TISSUES if label is not Label.AIR)
AIR_POINTS = 300
MARKER_MM = 7.0
AT_ONCE = 200_000


@dataclass(frozen=True)
class Settings:
    """How an image is segmented.

    classifier: of CLASSIFIERS, with so many trees; neighbourhood_mm: half width of what a voxel is compared
    with; smoothing: curvature steps; seed: of the classifier; voxel_mm: of the images, to which finer ones
    are averaged.
    Raises ConfigurationError for a value out of its limits.
    """

    classifier: str = "random_forest"
    trees: int = 60
    neighbourhood_mm: float = 4.0
    smoothing: int = 2
    seed: int = 0
    # ASSUME: tissues are told apart on voxels of about 1.5 mm that finer images are averaged to.
    voxel_mm: float = 1.5

    def __post_init__(self) -> None:
        if self.classifier not in CLASSIFIERS:
            raise ConfigurationError(
                f"unknown classifier {self.classifier!r}; choose one of: {', '.join(CLASSIFIERS)}"
            )
        if self.trees < 1 or self.smoothing < 0 or not 0 < self.neighbourhood_mm <= 20:
            raise ConfigurationError(
                f"trees = {self.trees}, smoothing = {self.smoothing}, neighbourhood_mm = "
                f"{self.neighbourhood_mm:g} must be at least 1, 0, and in (0, 20]: was it given in cm?"
            )
        if not 0 < self.voxel_mm <= 20:
            raise ConfigurationError(f"voxel_mm = {self.voxel_mm:g} must be in (0, 20]: was it given in cm?")


@dataclass(frozen=True)
class Segmentation:
    """labels of core.labels.Label; probability (0..1) that a voxel is glandular, as the classifier saw it."""

    labels: LabelMap
    probability: Image


def _forest(settings: Settings) -> "ClassifierMixin":
    from sklearn.ensemble import RandomForestClassifier

    return RandomForestClassifier(
        settings.trees, min_samples_leaf=2, class_weight="balanced", random_state=settings.seed, n_jobs=2
    )


def _boosting(settings: Settings) -> "ClassifierMixin":
    from sklearn.ensemble import HistGradientBoostingClassifier

    return HistGradientBoostingClassifier(
        max_iter=settings.trees, min_samples_leaf=5, class_weight="balanced", random_state=settings.seed
    )


CLASSIFIERS: Mapping[str, Callable[[Settings], "ClassifierMixin"]] = {
    "random_forest": _forest,
    "gradient_boosting": _boosting,
}


def segment(image: Image, strokes: pd.DataFrame | None = None, *, settings: Settings) -> Segmentation:
    """Label every voxel of an image, from strokes (x_mm, y_mm, z_mm, tissue) painted in it where given.

    settings: classifier, neighbourhood in mm, smoothing, seed. Returns labels (nz, ny, nx) and the
    probability of gland, on the image's grid.
    The tissue that moves is one piece without cavities: the thorax behind it, the air around, skin between.
    Raises SegmentationError: a missing column, an unknown tissue, a tissue without strokes, a point outside;
    without strokes, no body at the midline.
    """
    coarse = coarsened(image, settings.voxel_mm)
    if strokes is None:
        labels, gland = unsupervised(coarse, _free(coarse))
    else:
        labels, gland = _learnt(coarse, strokes, settings)
    return Segmentation(
        LabelMap(image.grid, spread(labels, image.grid, settings.voxel_mm)),
        Image(image.grid, spread(gland, image.grid, settings.voxel_mm)),
    )


def _learnt(image: Image, strokes: pd.DataFrame, settings: Settings) -> tuple[np.ndarray, np.ndarray]:
    """Labels (nz, ny, nx) uint8 and probability of gland float32 by a classifier that learns from strokes."""
    voxels, classes = _training(image, strokes)
    body = body_mask(image)
    X = features(image, neighbourhood_mm=settings.neighbourhood_mm)
    examples, answers = _with_air(voxels, classes, body, settings.seed)
    classifier = CLASSIFIERS[settings.classifier](settings).fit(X[tuple(examples.T)], answers)
    p = _probabilities(classifier, X, ndimage.binary_dilation(body, iterations=2))
    behind = X[..., NAMES.index("behind_fat_mm")]
    _limit_muscle(p, behind, behind[tuple(voxels[classes == Label.MUSCLE].T)].max())
    seeds = np.zeros(image.grid.shape, np.uint8)
    seeds[tuple(voxels.T)] = classes
    return _contours(Evidence(p, seeds, settings.smoothing), image), p[Label.GLANDULAR]


@dataclass(frozen=True)
class Evidence:
    """What contours follow: probabilities (nz, ny, nx), seeds (nz, ny, nx) of labels, curvature steps."""

    p: Mapping[Label, np.ndarray]
    seeds: np.ndarray
    smoothing: int

    def contour(self, inner: tuple[Label, ...], outer: tuple[Label, ...], within: np.ndarray) -> np.ndarray:
        """Region (nz, ny, nx) bool of the inner tissues against the outer, grown from the inner strokes."""
        a, b = (np.sum([self.p[label] for label in side], axis=0) for side in (inner, outer))
        share = a / np.maximum(a + b, 1e-6)
        return grow(share, np.isin(self.seeds, inner), within=within, smoothing=self.smoothing)


def _training(image: Image, strokes: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
    """Voxel indices (n, 3) in order (k, j, i) and labels (n,) uint8 of the strokes; markers count as air."""
    if missing := {"x_mm", "y_mm", "z_mm", "tissue"} - set(strokes):
        raise SegmentationError(f"the strokes lack {sorted(missing)}; give columns x_mm, y_mm, z_mm, tissue")
    known = {label.tissue: label for label in TISSUES} | {Label.MARKER.tissue: Label.AIR}
    if unknown := set(strokes["tissue"]) - set(known):
        raise SegmentationError(
            f"unknown tissue {sorted(unknown)} in the strokes; choose of: {', '.join(known)}"
        )
    classes = np.array([known[tissue] for tissue in strokes["tissue"]], np.uint8)
    if absent := [name for name in NEEDED if np.count_nonzero(strokes["tissue"] == name) < LEAST_POINTS]:
        raise SegmentationError(f"fewer than {LEAST_POINTS} points of {', '.join(absent)}; paint some")
    points = strokes[["x_mm", "y_mm", "z_mm"]].to_numpy(float)
    voxels = np.round(image.grid.indices(points)).astype(int)
    outside = np.flatnonzero(((voxels < 0) | (voxels >= image.grid.shape)).any(axis=1))
    if len(outside):
        raise SegmentationError(
            f"{len(outside)} stroke points lie outside the image, first {points[outside[0]].round(1)} mm; "
            "were they painted in another position's image?"
        )
    return voxels, classes


def _with_air(
    voxels: np.ndarray, classes: np.ndarray, body: np.ndarray, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """The strokes (n, 3) and (n,) and, as further strokes of air, some of the two voxels round the body."""
    # ASSUME: voxels just outside the outline are air; nobody paints them, and they decide the surface.
    rim = np.argwhere(ndimage.binary_dilation(body, iterations=2) & ~body)
    some = generator(seed, "segmentation", "air").choice(len(rim), min(len(rim), AIR_POINTS), replace=False)
    return np.vstack([voxels, rim[some]]), np.concatenate([classes, np.full(len(some), Label.AIR, np.uint8)])


def _probabilities(
    classifier: "ClassifierMixin", X: np.ndarray, region: np.ndarray
) -> dict[Label, np.ndarray]:
    """Probability (nz, ny, nx) float32 of each tissue."""
    classifier.set_params(
        **({"n_jobs": 1} if "n_jobs" in classifier.get_params() else {})
    )  # sums in one order
    where = np.flatnonzero(region)
    rows = X.reshape(-1, X.shape[-1])
    starts = range(0, len(where), AT_ONCE)
    found = [
        classifier.predict_proba(rows[where[start : start + AT_ONCE]]).astype(np.float32)
        for start in progress(starts, label="probability", total=len(starts))
    ]
    p = {label: np.zeros(region.shape, np.float32) for label in TISSUES}
    p[Label.AIR][...] = 1.0
    for column, label in enumerate(classifier.classes_):
        p[Label(label)].flat[where] = np.concatenate([part[:, column] for part in found])
    return p


def _limit_muscle(p: dict[Label, np.ndarray], behind_fat_mm: np.ndarray, deepest_mm: float) -> None:
    """Give the muscle's share to the thorax where no stroke says that muscle reaches so deep."""
    # ASSUME: the muscle reaches no deeper behind the fat than the deepest stroke painted in it, but for 1 mm.
    deeper = behind_fat_mm > deepest_mm + 1.0
    p[Label.THORAX][deeper] += p[Label.MUSCLE][deeper]
    p[Label.MUSCLE][deeper] = 0


def _contours(evidence: Evidence, image: Image) -> np.ndarray:
    """Labels (nz, ny, nx) uint8: body in air, tissue that moves before the thorax, muscle, gland, skin."""
    spacing = image.grid.spacing[::-1]
    body = _body(evidence, image)
    depth = ndimage.distance_transform_edt(body, sampling=spacing)
    thorax = _thorax(evidence, body, depth > LEAST_COVER_MM)
    soft = largest_part(body & ~thorax)
    muscle = _muscle(evidence, soft, thorax)
    breast = soft & ~muscle
    gland = evidence.contour((Label.GLANDULAR,), (Label.ADIPOSE, Label.SKIN), breast)
    # ASSUME: skin is the outermost layer of voxels, in the directions in which they are small, and what looks
    # like it within 3 mm of air.
    sure = (depth < SKIN_MM) & (evidence.p[Label.SKIN] > SURE_SKIN)
    skin = breast & (outermost(depth, spacing) | sure)
    labels = np.full(body.shape, Label.AIR, np.uint8)
    labels[body] = Label.THORAX
    labels[breast] = Label.ADIPOSE
    labels[gland] = Label.GLANDULAR
    labels[muscle] = Label.MUSCLE
    labels[skin] = Label.SKIN
    return labels


def _body(evidence: Evidence, image: Image) -> np.ndarray:
    """All that is not air, without markers, in one part without holes."""
    free = _free(image)
    body = _covered(largest_part(evidence.contour(TISSUES[1:], (Label.AIR,), free)), evidence.p, free)
    return np.stack([fill_axial(axial) for axial in body])


def _covered(body: np.ndarray, p: Mapping[Label, np.ndarray], free: np.ndarray) -> np.ndarray:
    """A body (nz, ny, nx) bool with the skin before what looks like fat or gland and yet borders on air."""
    bare = body & ~ndimage.binary_erosion(body, border_value=1)
    bare &= p[Label.ADIPOSE] + p[Label.GLANDULAR] > p[Label.SKIN]
    return body | (ndimage.binary_dilation(bare) & (p[Label.SKIN] > LEAST_SKIN) & free)


def _free(image: Image) -> np.ndarray:
    """Where no marker is (nz, ny, nx) bool."""
    free = np.ones(image.grid.shape, bool)
    found = find_markers(image, diameter_mm=MARKER_MM)
    points = image.grid.centres() if len(found) else np.empty((0, 3))
    for centre in found:
        near = np.linalg.norm(points - centre, axis=1) < MARKER_MM / 2 + image.grid.spacing.max() / 2
        free.flat[near] = False
    return free


def _thorax(evidence: Evidence, body: np.ndarray, deep: np.ndarray) -> np.ndarray:
    """What does not move, in one part without islands, in the deep part of the body."""
    thorax = largest_part(deep & ~evidence.contour(SOFT, (Label.THORAX, Label.AIR), deep))
    # ASSUME: whatever of the body lies straight behind the thorax belongs to it.
    return np.maximum.accumulate(np.stack([fill_axial(axial) for axial in thorax]) & deep, axis=1) & body


def _muscle(evidence: Evidence, soft: np.ndarray, thorax: np.ndarray) -> np.ndarray:
    """The muscle on the thorax; what it shuts in from the breast belongs to it."""
    likely = evidence.contour((Label.MUSCLE,), SOFT[:-1], soft)
    on_thorax = ndimage.binary_dilation(thorax) & soft
    muscle = ndimage.binary_propagation(on_thorax & likely, mask=likely)
    return soft & ~largest_part(soft & ~muscle)
