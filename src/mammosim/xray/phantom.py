"""The patient as voxels of materials."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.core.labels import Label
from mammosim.core.volume import Grid, LabelMap
from mammosim.xray.attenuation import Material

AIR = 0


@dataclass(frozen=True)
class Phantom:
    """Voxels of materials in air.

    grid: axis-aligned, mm.
    index: (nz, ny, nx) uint8, the place of each voxel's material in `materials`.
    materials: (n_material,); materials[0] is the air that also fills everything outside the grid.

    Raises XrayError when the phantom is empty, has an index without material, is not uint8, or is turned.
    """

    grid: Grid
    index: np.ndarray
    materials: tuple[Material, ...]

    def __post_init__(self) -> None:
        if self.index.shape != tuple(self.grid.shape):
            raise XrayError(
                f"index {self.index.shape} does not fit the grid {tuple(self.grid.shape)} (nz, ny, nx)"
            )
        if self.index.dtype != np.uint8:
            raise XrayError(
                f"index must be uint8, not {self.index.dtype}: give each voxel the number of its material"
            )
        if not np.allclose(self.grid.direction, np.eye(3), atol=1e-6):
            raise XrayError("the grid of a phantom must follow the axes x, y, z; resample it first")
        if not np.all(np.isfinite([*self.grid.origin, *self.grid.spacing])):
            raise XrayError(
                f"the grid's origin {self.grid.origin} and spacing {self.grid.spacing} must be finite"
            )
        if int(self.index.max()) >= len(self.materials):
            raise XrayError(
                f"voxels have index {self.index.max()}, but there are {len(self.materials)} materials"
            )
        if not self.index.any():
            raise XrayError("the phantom is empty: every voxel is air")

    @property
    def low(self) -> np.ndarray:
        """Lower corner (3,) of the grid in (x, y, z), mm."""
        return self.grid.origin - self.grid.spacing / 2

    @property
    def high(self) -> np.ndarray:
        """Upper corner (3,) of the grid in (x, y, z), mm."""
        high: np.ndarray = self.low + self.grid.spacing * self.grid.shape[::-1]
        return high

    def volume_mm3(self, index: int) -> float:
        """Volume of the voxels of one material."""
        return float(np.count_nonzero(self.index == index) * self.grid.voxel_volume)

    def mass_g(self, index: int) -> float:
        """Mass of the voxels of one material; none for an index without material."""
        if index >= len(self.materials):
            return 0.0
        return self.materials[index].density_g_cm3 * self.volume_mm3(index) / 1e3


def phantom_of_labels(labels: LabelMap, materials: Mapping[Label, Material]) -> Phantom:
    """The phantom of a label map; voxels keep their label as index: index Label.GLANDULAR is the gland.

    materials: of AIR and of each label in the map; labels that are not in the map need none.
    Raises XrayError when a label of the map has no material.
    """
    present = [Label(label) for label in np.unique(labels.values)]
    if missing := [label.tissue for label in (Label.AIR, *present) if label not in materials]:
        known = ", ".join(label.tissue for label in materials)
        raise XrayError(f"no material for {', '.join(missing)}; the table has: {known}")
    air = materials[Label.AIR]
    listed = tuple(materials.get(label, air) for label in Label)
    return Phantom(labels.grid, labels.values.astype(np.uint8), listed)
