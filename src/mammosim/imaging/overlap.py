"""How well a label map agrees with the truth, tissue by tissue."""

import numpy as np
import pandas as pd

from mammosim.core.errors import SegmentationError
from mammosim.core.labels import DEFORMABLE, Label
from mammosim.core.volume import LabelMap


def dice(labels: LabelMap, truth: LabelMap) -> pd.DataFrame:
    """One row per tissue of either map: tissue, dice = 2 |A B| / (|A| + |B|), volume_mm3, truth_volume_mm3.

    The row 'deformable' takes all of core.labels.DEFORMABLE together. Markers count as air, which is what a
    reconstruction makes of them. Raises SegmentationError when the maps lie on different grids.
    """
    if not labels.grid.same_as(truth.grid):
        raise SegmentationError(
            f"labels have grid {labels.grid.shape} of {labels.grid.spacing} mm, the truth {truth.grid.shape} "
            f"of {truth.grid.spacing} mm; compare maps of one image"
        )
    a, b = (np.where(m.values == Label.MARKER, Label.AIR, m.values) for m in (labels, truth))
    tissues = np.union1d(np.unique(a), np.unique(b))
    rows = [_row(Label(t).tissue, a == t, b == t) for t in tissues]
    frame = pd.DataFrame([*rows, _row("deformable", np.isin(a, DEFORMABLE), np.isin(b, DEFORMABLE))])
    frame[["volume_mm3", "truth_volume_mm3"]] *= truth.grid.voxel_volume
    return frame


def _row(tissue: str, a: np.ndarray, b: np.ndarray) -> dict[str, str | float]:
    A, B, both = (float(np.count_nonzero(x)) for x in (a, b, a & b))
    value = 2 * both / (A + B) if A + B else 1.0
    return {"tissue": tissue, "dice": value, "volume_mm3": A, "truth_volume_mm3": B}
