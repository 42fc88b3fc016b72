"""One breast as it was measured: labels, markers and gravity, before anything is modelled."""

from dataclasses import dataclass

import numpy as np

from mammosim.core.fiducials import Fiducials
from mammosim.core.rigid import RigidTransform
from mammosim.core.volume import LabelMap


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
