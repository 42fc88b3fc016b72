"""The map of the energy given to a body, a request as those of `tally_request`."""

from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.core.volume import Grid
from mammosim.xray.blocks import Goal, Limits, run_blocks
from mammosim.xray.exposure_setup import ExposureSetup
from mammosim.xray.mapping import map_block
from mammosim.xray.phantom import Phantom
from mammosim.xray.tallies import Estimate
from mammosim.xray.tally_request import require_error
from mammosim.xray.tally_result import MapResult

MAP_BLOCK = 50_000  # histories; adding up a map costs as much as some ten thousand


@dataclass(frozen=True)
class EnergyMap:
    """Energy in cells of about cell_mm, of whole voxels, by plain transport, until the errors of all cells
    together, |error|/|value|, are `relative_error`.

    Raises XrayError when the error is not in (0, 1), or the cells are not at least a voxel.
    """

    cell_mm: float
    relative_error: float

    def __post_init__(self) -> None:
        require_error(self.relative_error)

    def result(self, setup: ExposureSetup, *, seed: int, limits: Limits) -> MapResult:
        """As the class says."""
        grid = self._cells(setup.phantom)
        per_mm = (1 / grid.spacing[0], 1 / grid.spacing[1], 1 / grid.spacing[2])
        parts = (setup.body, setup.matter, setup.beam(setup.geometry.detector), per_mm)

        def kernel(b: int, cells: np.ndarray) -> None:
            map_block(*parts, b, MAP_BLOCK, seed, cells)

        def error(found: list[Estimate]) -> float:
            norm = float(np.linalg.norm(found[0].value))
            return float(np.linalg.norm(found[0].error)) / norm if norm > 0 else np.inf

        goal = Goal("the map of the energy", error, self.relative_error)
        run = run_blocks(kernel, (tuple(grid.shape),), goal, block=MAP_BLOCK, limits=limits)
        return MapResult(run.estimates[0], grid, run.histories, setup.photons_per_mas)

    def _cells(self, phantom: Phantom) -> Grid:
        """The grid of the cells, which starts at the phantom's lower corner."""
        spacing, shape = phantom.grid.spacing, np.array(phantom.grid.shape)
        if not self.cell_mm >= spacing.min():
            raise XrayError(f"cell_mm = {self.cell_mm:g} is less than a voxel of {spacing} mm; enlarge it")
        size = np.maximum(np.round(self.cell_mm / spacing), 1).astype(int)  # voxels along x, y, z
        cell = size * spacing
        nz, ny, nx = map(int, -(-shape // size[::-1]))
        return Grid((nz, ny, nx), cell, phantom.low + cell / 2)
