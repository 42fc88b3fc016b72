"""What the scanner finds at each point of its grid: the material of a volunteer lying in it."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mammosim.core.fiducials import Fiducials
from mammosim.core.labels import Label
from mammosim.core.rigid import RigidTransform
from mammosim.core.volume import Grid
from mammosim.digital.anatomy import Anatomy
from mammosim.digital.markers import skin_normals, skin_points
from mammosim.digital.thorax import organs_at


class Body(Protocol):
    """A volunteer in the scanner: materials are codes of core.labels.Label and thorax.ORGANS."""

    def materials(self, grid: Grid) -> np.ndarray:
        """Material (nz, ny, nx) uint8 at the voxel centres of a scanner grid, without markers."""

    def fiducials(self) -> Fiducials:
        """Markers and nipples on the outer face of the skin, scanner frame, mm."""

    def normals(self) -> np.ndarray:
        """Outward unit normals (n, 3) of the skin at the fiducials, scanner frame."""


@dataclass(frozen=True)
class AtRest:
    """The stress-free body, moved rigidly into the scanner."""

    anatomy: Anatomy
    moved: RigidTransform

    def materials(self, grid: Grid) -> np.ndarray:
        """See Body."""
        points = self.moved.inverse()(grid.centres())
        return materials_of(self.anatomy, points, self.anatomy.labels_at(points)).reshape(grid.shape)

    def fiducials(self) -> Fiducials:
        """See Body."""
        listed = skin_points(self.anatomy)
        return Fiducials(listed.names, listed.kinds, self.moved(listed.points))

    def normals(self) -> np.ndarray:
        """See Body."""
        return skin_normals(self.anatomy, skin_points(self.anatomy).points) @ self.moved.R.T


def materials_of(anatomy: Anatomy, points: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """Labels (n,) of stress-free points (n, 3), with the thorax resolved into its organs."""
    materials = labels.astype(np.uint8)
    thorax = np.flatnonzero(labels == Label.THORAX)
    materials[thorax] = organs_at(anatomy, points[thorax])
    return materials
