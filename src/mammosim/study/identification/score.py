"""How near the estimates come to the truth of a digital volunteer; only scoring may call this."""

import numpy as np
import pandas as pd

from mammosim.core.mesh import TetMesh
from mammosim.core.rigid import RigidTransform
from mammosim.meshing.distance import surface_distance


def registration_error(
    estimated: RigidTransform, true_moving: RigidTransform, true_fixed: RigidTransform, points: np.ndarray
) -> dict[str, float]:
    """Error of a motion from the moving into the fixed scanner frame, at points (n, 3) of the moving one.

    true_moving, true_fixed: motions from the body frame into each scanner frame. T = fixed o moving^-1;
    rotation_error_deg is the angle of estimated o T^-1, error_*_mm are |estimated(p) - T(p)|.
    """
    true = true_fixed.after(true_moving.inverse())
    distance = np.linalg.norm(estimated(points) - true(points), axis=1)
    return {
        "rotation_error_deg": estimated.after(true.inverse()).angle_deg,
        "error_mean_mm": float(distance.mean()),
        "error_max_mm": float(distance.max()),
        "rotation_true_deg": true.angle_deg,
        "motion_mean_mm": float(np.linalg.norm(true(points) - points, axis=1).mean()),
    }


def shape_error(estimate: TetMesh, truth: TetMesh, *, motion: RigidTransform) -> dict[str, float]:
    """Distance of the estimated skin from the true skin, in mm, over the nodes of the estimate's skin.

    motion: from the body frame, in which the truth is kept, into the frame of the estimate.
    """
    return distances(surface_distance(estimate, truth.moved_to(motion(truth.points))))


def distances(d: np.ndarray) -> dict[str, float]:
    """Mean, 95th percentile and largest of distances (n,) in mm, and how many."""
    return {
        "mean_mm": float(d.mean()),
        "p95_mm": float(np.percentile(d, 95)),
        "max_mm": float(d.max()),
        "nodes": len(d),
    }


def score_row(volunteer: str, what: dict[str, str], error: dict[str, float]) -> pd.DataFrame:
    """A table of one row: volunteer, what was scored (e.g. position or method), and its errors."""
    return pd.DataFrame([{"volunteer": volunteer, **what, **error}])
