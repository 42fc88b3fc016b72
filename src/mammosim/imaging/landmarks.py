"""The rigid motion of four markers whose correspondence is not known."""

from itertools import permutations

import numpy as np
from scipy.spatial import cKDTree

from mammosim.core.errors import FiducialError
from mammosim.core.rigid import RigidTransform
from mammosim.imaging.markers import require_four

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
