"""One breast as it was measured: labels, markers and gravity, before anything is modelled."""

from dataclasses import dataclass

import numpy as np

from mammosim.chain.labelled import between_breasts_mm
from mammosim.core.fiducials import Fiducials, midline_of
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

    @property
    def midline_mm(self) -> float:
        """x of the midline in the common frame; infinite where nothing is beyond it, as of a lone breast."""
        x = self.to_reference(self.fiducials.of_kind("nipple"))[:, 0]
        if len(x) == 0:
            return 0.0
        if len(x) == 2:
            middle = float(x.mean())
        else:
            between = between_breasts_mm(self.labels, self.nipple)
            middle = float(self.to_reference(np.array([[between, *self.nipple[1:]]]))[0, 0])
        if np.isnan(middle):
            return -np.inf if self.side == "left" else np.inf
        return midline_of(middle)
