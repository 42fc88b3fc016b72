"""One breast as its images gave it, before anything is modelled."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mammosim.core.fiducials import Fiducials
from mammosim.core.mesh import TetMesh
from mammosim.core.rigid import RigidTransform
from mammosim.core.volume import LabelMap
from mammosim.meshing.body import ElementSize, crop_body, mesh_body


@dataclass(frozen=True)
class Breast:
    """labels and fiducials in the scanner frame; to_reference: from there into the common frame.

    gravity (3,): unit vector of the measured position, common frame; side: left or right.
    """

    labels: LabelMap
    fiducials: Fiducials
    to_reference: RigidTransform
    gravity: np.ndarray
    side: str

    @property
    def nipple(self) -> np.ndarray:
        """Where its nipple was measured (3,) mm, scanner frame."""
        return self.fiducials.point(f"nipple_{self.side}")


def scanned_mesh(labels: LabelMap, chest: np.ndarray, settings: Mapping[str, Any]) -> TetMesh:
    """Quadratic tetrahedra of segmented tissue, cut relative to the chest markers (n, 3), scanner frame.

    settings: element_mm {breast, chest}, behind_markers_mm and beyond_markers_mm.
    """
    beyond = settings["beyond_markers_mm"]
    cropped = crop_body(
        labels,
        posterior_limit_mm=chest[:, 1].min() + settings["behind_markers_mm"],
        height_limits_mm=(chest[:, 2].min() - beyond, chest[:, 2].max() + beyond),
    )
    size = settings["element_mm"]
    return mesh_body(cropped, size=ElementSize(size["breast"], size["chest"]))
