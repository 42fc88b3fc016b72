"""Rigid registration of two positions: the chest markers first, then the image inside the rib cage.

Without markers the rib cage alone registers: imaging.unmarked.
"""

from dataclasses import dataclass
from itertools import permutations

import numpy as np
import pandas as pd
import SimpleITK as sitk
from scipy.spatial import cKDTree

from mammosim.core.errors import ConfigurationError, FiducialError, ImageError
from mammosim.core.rigid import RigidTransform
from mammosim.core.volume import Grid, Image, LabelMap
from mammosim.imaging.markers import require_four
from mammosim.imaging.outline import body_mask, coarsened, torso_depth
from mammosim.io.images import itk_volume
from mammosim.io.transforms import itk_transform, rigid_of

# ASSUME: between two positions the chest turns by at most 45 degrees in the patient frame.
LARGEST_TURN_DEG = 45.0
# ASSUME: markers on the fixed chest keep their mutual places within 15 mm; beyond, one is lost or confused.
LARGEST_RESIDUAL_MM = 15.0
ITERATIONS = 50


def kabsch(moving: np.ndarray, fixed: np.ndarray) -> RigidTransform:
    """The R, t that minimise sum |R m_i + t - f_i|^2 over rotations, for points m, f (n, 3), mm.

    R = V diag(1, 1, det(V U^T)) U^T with sum (m - mean m)(f - mean f)^T = U S V^T (Kabsch 1976).
    """
    m0, f0 = moving.mean(axis=0), fixed.mean(axis=0)
    U, _, Vt = np.linalg.svd((moving - m0).T @ (fixed - f0))
    D = np.diag([1.0, 1.0, np.sign(np.linalg.det(Vt.T @ U.T))])
    R = Vt.T @ D @ U.T
    return RigidTransform(R, f0 - R @ m0)


def residual(transform: RigidTransform, moving: np.ndarray, fixed: np.ndarray) -> np.ndarray:
    """Distances (n,) mm of the moved points to the nearest fixed ones."""
    return cKDTree(fixed).query(transform(moving))[0]


def match(moving: np.ndarray, fixed: np.ndarray) -> RigidTransform:
    """The motion of the best of all 24 correspondences, points (4, 3) mm; reflections are no rotations.

    Raises FiducialError when either set does not fix a motion, or none fits within the limits.
    """
    for points in (moving, fixed):
        require_four(points)
    motions = [kabsch(moving, fixed[list(order)]) for order in permutations(range(len(fixed)))]
    worst = [
        np.linalg.norm(motion(moving) - fixed[list(order)], axis=1).max()
        for motion, order in zip(motions, permutations(range(len(fixed))))
    ]
    plausible = [k for k, motion in enumerate(motions) if motion.angle_deg <= LARGEST_TURN_DEG]
    best = min(plausible, key=lambda k: worst[k], default=None)
    if best is None or worst[best] > LARGEST_RESIDUAL_MM:
        raise FiducialError(
            f"the chest markers of the two images do not match: at best one is {min(worst):.1f} mm off, the "
            f"limits are {LARGEST_RESIDUAL_MM:g} mm and a turn of {LARGEST_TURN_DEG:g} degrees: check them"
        )
    return motions[best]


def icp(moving: np.ndarray, fixed: np.ndarray, start: RigidTransform) -> tuple[RigidTransform, int]:
    """Iterated closest points (Besl & McKay 1992) from a start, and the iterations done; points (n, 3) mm."""
    tree, nearest, motion = cKDTree(fixed), np.empty(0, int), start
    for iteration in range(1, ITERATIONS + 1):
        found = tree.query(motion(moving))[1]
        if np.array_equal(found, nearest):
            return motion, iteration
        nearest, motion = found, kabsch(moving, fixed[found])
    return motion, ITERATIONS


# ASSUME: the rib cage begins 20 mm under the torso's skin: skin, fat and pectoral muscle lie in front of it.
WALL_MM = 20.0
# ASSUME: an image refinement that moves a chest marker by more than 10 mm has gone astray.
LARGEST_MOVE_MM = 10.0
SMALLEST_VOXELS = 1000
LARGEST_STEP_MM, SMALLEST_STEP_MM = 1.0, 0.005


@dataclass(frozen=True)
class Settings:
    """How images are registered.

    voxel_mm: of the images, to which finer ones are averaged; those cost memory, and move the result by less
    than the markers' error. smoothing_mm: of the levels, coarse to fine; 0 takes the images as they are.
    iterations: largest, of a level; samples: voxels that are compared, about.
    """

    voxel_mm: float = 1.5
    smoothing_mm: tuple[float, ...] = (4.0, 2.0, 0.0)
    iterations: int = 100
    samples: int = 100_000

    def __post_init__(self) -> None:
        if not self.smoothing_mm or min(self.smoothing_mm) < 0:
            raise ConfigurationError(
                f"smoothing_mm = {list(self.smoothing_mm)} of the registration: give at least one level, "
                "none below 0"
            )
        if not 0 < self.voxel_mm <= 20 or self.iterations < 1 or self.samples < 100:
            raise ConfigurationError(
                f"voxel_mm = {self.voxel_mm:g}, iterations = {self.iterations}, samples = {self.samples} "
                "of the registration must be in (0, 20], at least 1, at least 100: was a length given in cm?"
            )


DEFAULT = Settings()
COLUMNS = (
    *("step", "marker_residual_mm", "marker_residual_max_mm", "correlation", "iterations", "used"),
    *("method", "error_95_mm", "error_95_deg"),
)


@dataclass(frozen=True)
class Registration:
    """Motions of points of the moving position into the fixed frame, mm.

    landmark: from the markers, or the first guess without them; refined: from the image, or the landmark
        motion where that was no better.
    table: one row per step, of COLUMNS: step, marker_residual_mm (root mean square), marker_residual_max_mm,
        correlation (of the intensities inside the rib cage), iterations, used, method (markers or rib cage),
        and what errors exceed in 5 of 100 registrations by the rib cage: error_95_mm at the worst place of
        the chest wall, error_95_deg. NaN for what a method does not tell.
    """

    landmark: RigidTransform
    refined: RigidTransform
    table: pd.DataFrame


def register(
    fixed: Image,
    moving: Image,
    fixed_markers: np.ndarray,
    moving_markers: np.ndarray,
    *,
    settings: Settings = DEFAULT,
) -> Registration:
    """Register `moving` on `fixed` by their chest markers, and then by the images inside the rib cage.

    fixed_markers, moving_markers: (4, 3) mm, in any order, each in the frame of its image; settings: levels,
    iterations, samples. Returns both motions, of points of the moving frame into the fixed one, and a row per
    step. Kabsch 1976, then correlation by regular steps.
    Raises FiducialError when the markers do not match, ImageError when no rib cage is in the fixed image.
    """
    fixed, moving = coarsened(fixed, settings.voxel_mm), coarsened(moving, settings.voxel_mm)
    landmark, icp_iterations = icp(moving_markers, fixed_markers, match(moving_markers, fixed_markers))
    inside = rib_cage(fixed)
    refined, iterations = refine((fixed, moving), inside, landmark, settings)
    r = [correlation(fixed, moving, inside, motion) for motion in (landmark, refined)]
    moved = np.linalg.norm(refined(moving_markers) - landmark(moving_markers), axis=1).max()
    better = r[1] >= r[0] and moved <= LARGEST_MOVE_MM
    off = [residual(motion, moving_markers, fixed_markers) for motion in (landmark, refined)]
    table = pd.DataFrame(
        {
            "step": ["landmarks", "image"],
            "marker_residual_mm": [np.sqrt(np.mean(d**2)) for d in off],
            "marker_residual_max_mm": [d.max() for d in off],
            "correlation": r,
            "iterations": [icp_iterations, iterations],
            "used": [not better, better],
            "method": "markers",
            "error_95_mm": np.nan,
            "error_95_deg": np.nan,
        }
    )
    return Registration(landmark, refined if better else landmark, table)


def resample(image: Image, transform: RigidTransform, grid: Grid) -> Image:
    """The image after the motion, on a grid of the fixed frame: out(y) = image(T^-1 y), linear, 0 outside."""
    reference = sitk.Image([int(n) for n in grid.shape[::-1]], sitk.sitkUInt8)
    reference.CopyInformation(itk_volume(grid, np.empty(grid.shape, np.uint8)))
    volume = itk_volume(image.grid, image.values)
    moved = sitk.Resample(volume, reference, itk_transform(transform.inverse()), sitk.sitkLinear, 0.0)
    return Image(grid, sitk.GetArrayFromImage(moved).astype(np.float32))


def transform_error(estimated: RigidTransform, true: RigidTransform, points: np.ndarray) -> dict[str, float]:
    """How far an estimate is off at points (n, 3) of the moving position: mean_mm, max_mm, rotation_deg."""
    off = np.linalg.norm(estimated(points) - true(points), axis=1)
    turn = estimated.after(true.inverse())
    return {"mean_mm": float(off.mean()), "max_mm": float(off.max()), "rotation_deg": turn.angle_deg}


def rib_cage(image: Image) -> LabelMap:
    """1 (nz, ny, nx) inside the rib cage, estimated from the body's outline alone; the same in every slice.

    Raises ImageError when less than a usable number of voxels remains.
    """
    depth = torso_depth(body_mask(image), image.grid.spacing)
    inside = np.broadcast_to(depth > WALL_MM, image.grid.shape).astype(np.uint8)
    if inside.sum() < SMALLEST_VOXELS:
        raise ImageError(
            f"{inside.sum()} voxels lie inside the rib cage, {SMALLEST_VOXELS} are needed to register; "
            "take an image that shows the chest at least 40 mm deep"
        )
    return LabelMap(image.grid, inside)


def correlation(fixed: Image, moving: Image, inside: LabelMap, motion: RigidTransform) -> float:
    """Pearson's correlation of fixed and moved intensities where `inside` is 1 and both images reach."""
    moved = resample(moving, motion, fixed.grid).values
    reached = resample(Image(moving.grid, np.ones_like(moving.values)), motion, fixed.grid).values
    both = (inside.values == 1) & (reached > 0.999)
    return float(np.corrcoef(fixed.values[both], moved[both])[0, 1])


def refine(
    images: tuple[Image, Image], inside: LabelMap, start: RigidTransform, settings: Settings
) -> tuple[RigidTransform, int]:
    """Maximise the normalised cross-correlation of two images; and the iterations of all levels.

    ITK asks where a point of the fixed image comes from: it works on the inverse of the motion.
    """
    method = _method(inside, settings)
    iterations = [0]
    method.AddCommand(sitk.sitkIterationEvent, lambda: iterations.append(iterations[-1] + 1))
    initial = sitk.VersorRigid3DTransform()
    centre = inside.grid.points(np.argwhere(inside.values).mean(axis=0)[None])[0]
    back = start.inverse()
    initial.SetCenter(centre.tolist())
    initial.SetMatrix(back.R.ravel().tolist(), 1e-6)
    initial.SetTranslation((back(centre[None])[0] - centre).tolist())
    method.SetInitialTransform(initial, inPlace=True)
    method.Execute(*(itk_volume(each.grid, each.values.astype(np.float32, copy=False)) for each in images))
    return rigid_of(initial).inverse(), iterations[-1]


def _method(inside: LabelMap, settings: Settings) -> sitk.ImageRegistrationMethod:
    """Correlation in the mask; regular steps, halved whenever the gradient turns; the same on every run."""
    method = sitk.ImageRegistrationMethod()
    method.SetNumberOfThreads(1)  # sums in another order would end elsewhere
    method.SetMetricAsCorrelation()
    method.SetMetricFixedMask(itk_volume(inside.grid, inside.values))
    method.SetMetricSamplingStrategy(method.REGULAR)
    method.SetMetricSamplingPercentage(min(1.0, settings.samples / int(inside.values.sum())), 1)
    method.SetInterpolator(sitk.sitkLinear)
    method.SetOptimizerAsRegularStepGradientDescent(LARGEST_STEP_MM, SMALLEST_STEP_MM, settings.iterations)
    method.SetOptimizerScalesFromPhysicalShift()
    method.SetShrinkFactorsPerLevel(
        [max(1, round(s / h)) for s in settings.smoothing_mm for h in [inside.grid.spacing.min()]]
    )
    method.SetSmoothingSigmasPerLevel(list(settings.smoothing_mm))
    method.SmoothingSigmasAreSpecifiedInPhysicalUnitsOn()
    return method
