"""A published model beside the truth of a digital volunteer. Only scoring may call this."""

import numpy as np
import pandas as pd

from mammosim.core.mesh import TetMesh
from mammosim.core.rigid import RigidTransform
from mammosim.meshing.distance import surface_distance
from mammosim.study.models.rows import AXES


def score(shape: TetMesh | None, truth: TetMesh, *, motion: RigidTransform) -> dict[str, float]:
    """stress_free_mean_mm, stress_free_median_mm: of the nodes of the skin from the true skin, NaN of None.

    At the rim of the body, beyond which the truth has no skin, all are some millimetres off, in any model.
    motion: from the body frame, in which the truth is kept, into the frame of the shape.
    """
    if shape is None:
        return {"stress_free_mean_mm": np.nan, "stress_free_median_mm": np.nan}
    d = surface_distance(shape, truth.moved_to(motion(truth.points)))
    return {"stress_free_mean_mm": float(d.mean()), "stress_free_median_mm": float(np.median(d))}


def nipple_away_mm(row: pd.Series, true: np.ndarray, *, motion: RigidTransform) -> float:
    """Of the model's upright nipple from the true one (3,); motion: from its frame to the model's."""
    found = row[[f"nipple_upright_{axis}_mm" for axis in AXES]].to_numpy(dtype=float)
    return float(np.linalg.norm(found - motion(true[None])[0]))
