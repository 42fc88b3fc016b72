"""Where the energy of a beam goes: photon Monte Carlo, run until the asked uncertainty is met.

Each block of histories has its own random stream, and blocks are added in their order, so that any number of
threads gives the same tallies.
"""

import logging
from dataclasses import dataclass

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.xray.beam import body_of, field_of, require_outside
from mammosim.xray.geometry import Geometry
from mammosim.xray.interactions import matter
from mammosim.xray.phantom import Phantom
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.tallies import Estimate, Sums, Tallies, tallies
from mammosim.xray.tracking import track_blocks

log = logging.getLogger(__name__)
FEWEST_BLOCKS = 32  # below, the standard error itself is uncertain by more than 1/sqrt(2 * 31) = 13 percent
HOPELESS = 2.0  # give up at once when this many times the allowed histories would be needed


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

    regions: (n_region, 2, 3) lower and upper corners in (x, y, z), mm, of boxes to tally, too;
    cell_mm: width of the cells that the detector's pixels are gathered in.
    Raises XrayError when source or detector are inside the body, or max_histories do not reach the accuracy.
    """
    # ASSUME: the detector absorbs what reaches it; nothing is scattered back from it.
    if not np.any(phantom.index == accuracy.index):
        raise XrayError(
            f"no voxel has index {accuracy.index}, whose energy was asked to {accuracy.relative_error:g}"
        )
    detector = geometry.detector.binned(cell_mm)
    boxes = np.zeros((0, 2, 3)) if regions is None else np.asarray(regions, float).reshape(-1, 2, 3)
    require_outside(phantom, geometry, detector)
    tables = matter(phantom.materials, float(spectrum.energies_kev[-1]))
    body = body_of(phantom, tables, boxes)
    beam = field_of(geometry.source, detector, spectrum)
    shapes = ((len(phantom.materials),), (len(boxes),), (3, *detector.shape), (2,))
    sums, reached = Sums(), np.inf
    while reached > accuracy.relative_error:
        n = _next_blocks(sums.blocks, reached, accuracy)
        rows = [np.zeros((n, *shape)) for shape in shapes]
        track_blocks(body, tables, beam, sums.blocks, accuracy.block, seed, *rows)
        sums.add(np.concatenate([row.reshape(n, -1) for row in rows], axis=1) / accuracy.block)
        reached = _relative_error(sums.estimate(), accuracy.index)
        log.info("%d histories, dose known to %.2f %%", sums.blocks * accuracy.block, 100 * reached)
    solid_angle = geometry.solid_angle()
    photons = float(spectrum.fluence.sum() * spectrum.distance_mm**2 * solid_angle)
    return tallies(sums, accuracy.block, photons, detector, shapes)


def _relative_error(estimate: Estimate, index: int) -> float:
    """Standard error of the energy in material `index`, of itself; infinite while nothing was deposited."""
    value, error = estimate.value[index], estimate.error[index]
    return float(error / value) if value > 0 and error > 0 else np.inf


def _next_blocks(done: int, reached: float, accuracy: Accuracy) -> int:
    """Blocks of the next round: what is needed by error ~ 1/sqrt(n), at most as many as were done.

    Raises XrayError when the largest number of histories is used up, or will clearly not do.
    """
    if done == 0:
        return FEWEST_BLOCKS
    most = accuracy.max_histories // accuracy.block
    needed = done * (reached / accuracy.relative_error) ** 2 if np.isfinite(reached) else 2 * done
    if done >= most or needed > HOPELESS * most:
        n, asked = done * accuracy.block, accuracy.relative_error
        raise XrayError(
            f"the energy in material {accuracy.index} is known to {reached:.2g} after {n} histories; "
            f"relative_error = {asked:g} needs about {needed * accuracy.block:.2g}, but max_histories = "
            f"{accuracy.max_histories}; raise it, or accept a larger error"
        )
    return int(min(max(needed - done + 1, FEWEST_BLOCKS // 2), done, most - done))
