"""Named points on a volunteer: markers and nipples, in mm, in the patient frame LPS."""

from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import FiducialError

KINDS = ("chest", "breast", "nipple")


@dataclass(frozen=True)
class Fiducials:
    """names (n,) unique; kinds (n,) of KINDS; points (n, 3) mm.

    Names: chest_1..4, breast_1..6 (an unmatched detection is numbered as found), nipple_left, nipple_right.
    """

    names: tuple[str, ...]
    kinds: tuple[str, ...]
    points: np.ndarray

    def __post_init__(self) -> None:
        if not len(self.names) == len(self.kinds) == len(self.points):
            raise FiducialError(
                f"{len(self.names)} names, {len(self.kinds)} kinds and {len(self.points)} points differ"
            )
        if unknown := set(self.kinds) - set(KINDS):
            raise FiducialError(f"unknown kind {sorted(unknown)}; choose one of: {', '.join(KINDS)}")
        if len(set(self.names)) < len(self.names):
            raise FiducialError("fiducial names must be unique")

    def of_kind(self, kind: str) -> np.ndarray:
        """Points (m, 3) of one kind, in the order of the list."""
        return self.points[[k == kind for k in self.kinds]]

    def point(self, name: str) -> np.ndarray:
        """One point (3,). Raises FiducialError when the list has no such name."""
        if name not in self.names:
            raise FiducialError(f"no fiducial {name!r}; the list has: {', '.join(self.names)}")
        x: np.ndarray = self.points[self.names.index(name)]
        return x
