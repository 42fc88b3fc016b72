"""Where the energy of a beam goes: plain photon Monte Carlo, run until the requested uncertainty is met."""

from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.xray.blocks import FEWEST_BLOCKS, Goal, Limits, relative, run_blocks
from mammosim.xray.exposure_setup import ExposureSetup
from mammosim.xray.geometry import Geometry
from mammosim.xray.phantom import Phantom
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.tally_result import Estimate, Tallies, tallies
from mammosim.xray.tracking import track_block


@dataclass(frozen=True)
class Accuracy:
    """Stop when the energy in material `index` is known to `relative_error` (one standard error).

    Raises XrayError when the error is not in (0, 1) or the largest number of histories is too small.
    """

    index: int
    relative_error: float
    max_histories: int = 200_000_000
    block: int = 10_000

    def __post_init__(self) -> None:
        if not 0 < self.relative_error < 1:
            raise XrayError(f"relative_error = {self.relative_error} is outside (0, 1); 0.01 is one percent")
        if self.block < 1 or self.max_histories < FEWEST_BLOCKS * self.block:
            raise XrayError(
                f"max_histories = {self.max_histories} is less than {FEWEST_BLOCKS} blocks of {self.block}; "
                "allow more"
            )


def transport(
    phantom: Phantom,
    geometry: Geometry,
    spectrum: Spectrum,
    *,
    accuracy: Accuracy,
    seed: int,
    regions: np.ndarray | None = None,
    cell_mm: float = 10.0,
) -> Tallies:
    """Photons from a point source, collimated to the detector, through the phantom in air.

    Any number of threads gives the same tallies.
    regions: (n_region, 2, 3) lower and upper corners in (x, y, z), mm, of boxes to tally, too;
    cell_mm: width of the cells that the detector's pixels are gathered in.
    Raises XrayError when source or detector are inside the body, or max_histories do not reach the accuracy.
    """
    # ASSUME: the detector absorbs what reaches it; nothing is scattered back from it.
    if not np.any(phantom.index == accuracy.index):
        raise XrayError(
            f"no voxel has index {accuracy.index}, whose energy is requested to {accuracy.relative_error:g}"
        )
    detector = geometry.detector.binned(cell_mm)
    boxes = np.zeros((0, 2, 3)) if regions is None else np.asarray(regions, float).reshape(-1, 2, 3)
    setup = ExposureSetup(phantom, geometry, spectrum)
    parts = (setup.body, setup.matter, setup.beam(detector), boxes.reshape(-1, 6))

    def kernel(b: int, *rows: np.ndarray) -> None:
        track_block(*parts, b, accuracy.block, seed, *rows)

    def error(estimates: list[Estimate]) -> float:
        energy = estimates[0]
        return relative(energy.value[[accuracy.index]], energy.error[[accuracy.index]])

    shapes = ((len(phantom.materials),), (len(boxes),), (3, *detector.shape), (2,))
    goal = Goal(f"the energy in material {accuracy.index}", error, accuracy.relative_error)
    run = run_blocks(kernel, shapes, goal, block=accuracy.block, limits=Limits(accuracy.max_histories))
    return tallies(run.estimates, run.histories, setup.photons_per_mas, detector)
