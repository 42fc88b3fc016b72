"""What may be requested of a beam: each tally by the estimator that suits it, to its own uncertainty.

A request for dose computes no image, one for scatter no dose; without a request no photon is run.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from mammosim.core.errors import XrayError
from mammosim.core.volume import Grid
from mammosim.xray.blocks import Goal, Limits, relative, run_blocks
from mammosim.xray.exposure_setup import ExposureSetup
from mammosim.xray.geometry import Geometry
from mammosim.xray.phantom import AIR, Phantom
from mammosim.xray.projector import path_lengths
from mammosim.xray.regional import kept_fraction, primary_given, scattered_block
from mammosim.xray.scattering import Setting, scatter_block
from mammosim.xray.tally_result import (
    Estimate,
    MapResult,
    MaterialsResult,
    RegionsResult,
    ScatterResult,
    TallyResult,
)
from mammosim.xray.tracking import map_block, track_block
from mammosim.xray.traversal import longest_path

BLOCK = 10_000
SCATTER_BLOCK = 2_000  # histories that are several photons each
UNBIASED = 0.3  # share of the energies drawn from the spectrum itself: low ones matter where the body is thin
NEAR_MM = 35.0  # from a region's shadow, a few free paths: where most photons start that scatter into it
RAYS, REPLICATES = 16, 8  # per axis of a region's shadow, and repetitions for the standard error
MAP_BLOCK = 50_000  # histories; adding up a map costs as much as some ten thousand


class TallyRequest(Protocol):
    """A quantity, and how well it is wanted."""

    def result(self, setup: ExposureSetup, *, seed: int, limits: Limits) -> TallyResult:
        """The quantity. Raises XrayError when the limits do not suffice, and says what would."""
        ...


def results(
    setup: ExposureSetup, requests: Sequence[TallyRequest], *, seed: int, limits: Limits | None = None
) -> list[TallyResult]:
    """The result of each request, each within the limits."""
    return [request.result(setup, seed=seed, limits=limits or Limits()) for request in requests]


def require_error(relative_error: float) -> None:
    """Raises XrayError when a wanted relative error is not in (0, 1)."""
    if not 0 < relative_error < 1:
        raise XrayError(f"relative_error = {relative_error} is outside (0, 1); 0.01 is one percent")


@dataclass(frozen=True)
class EnergyIn:
    """Energy in each material (n_material,), that of material `index` to `relative_error`: plain transport.

    Raises XrayError when the error is not in (0, 1), or no voxel is of that material.
    """

    index: int
    relative_error: float

    def __post_init__(self) -> None:
        require_error(self.relative_error)

    def result(self, setup: ExposureSetup, *, seed: int, limits: Limits) -> MaterialsResult:
        """As the class says."""
        require_material(setup, self.index)
        whole = setup.geometry.detector
        beam = setup.beam(whole)._replace(
            per_mm=1 / (2 * max(whole.size_mm))
        )  # one cell: no image was requested
        shapes = ((len(setup.phantom.materials),), (0,), (3, 1, 1), (2,))
        parts = (setup.body, setup.matter, beam, np.zeros((0, 6)))

        def kernel(b: int, *rows: np.ndarray) -> None:
            track_block(*parts, b, BLOCK, seed, *rows)

        def error(found: list[Estimate]) -> float:
            return relative(found[0].value[[self.index]], found[0].error[[self.index]])

        goal = Goal(f"the energy in material {self.index}", error, self.relative_error)
        run = run_blocks(kernel, shapes, goal, block=BLOCK, limits=limits)
        return MaterialsResult(run.estimates[0], run.histories, setup.photons_per_mas)


@dataclass(frozen=True)
class EnergyInRegions:
    """Energy in each of some boxes (n_region,): corners (n_region, 2, 3) low and high in (x, y, z), mm.

    The primary's share follows from rays through each box, which leaves only the scattered photons to chance.
    Raises XrayError when the error is not in (0, 1), or a box has no volume or is in no tissue.
    """

    corners: np.ndarray
    relative_error: float

    def __post_init__(self) -> None:
        require_error(self.relative_error)
        if self.corners.ndim != 3 or self.corners.shape[1:] != (2, 3):
            raise XrayError(f"corners {self.corners.shape} must be (n_region, 2, 3)")
        if not np.all(self.corners[:, 0] < self.corners[:, 1]):
            raise XrayError("the lower corner of each region must be below its higher one along x, y and z")

    def result(self, setup: ExposureSetup, *, seed: int, limits: Limits) -> RegionsResult:
        """As the class says."""
        boxes = np.ascontiguousarray(self.corners.reshape(-1, 6), dtype=float)
        primary = _primary_in(setup, boxes, seed)
        shadows = np.array([_shadow(setup.geometry, box) for box in boxes])
        near = np.where([True, False] * 2, shadows.min(axis=0) - NEAR_MM, shadows.max(axis=0) + NEAR_MM)
        parts = (setup.body, setup.matter, setup.beam(setup.geometry.detector), boxes, near)

        def kernel(b: int, *rows: np.ndarray) -> None:
            scattered_block(*parts, b, BLOCK, seed, *rows)

        def total(found: list[Estimate]) -> Estimate:
            return Estimate(primary.value + found[1].value, np.hypot(primary.error, found[1].error))

        def error(found: list[Estimate]) -> float:
            whole = total(found)
            return relative(whole.value, whole.error)

        shapes = ((len(setup.phantom.materials),), (len(boxes),))
        goal = Goal("the energy in the regions", error, self.relative_error)
        run = run_blocks(kernel, shapes, goal, block=BLOCK, limits=limits)
        return RegionsResult(total(run.estimates), run.histories, setup.photons_per_mas)


@dataclass(frozen=True)
class ScatterImage:
    """Scatter on cells of about cell_mm; behind material `behind` their errors, of themselves, are
    `relative_error` in the mean square. Cells behind it: those with half of the longest way through it.

    Raises XrayError when the error is not in (0, 1), or no voxel is of that material.
    """

    behind: int
    relative_error: float
    cell_mm: float = 5.0

    def __post_init__(self) -> None:
        require_error(self.relative_error)

    def result(self, setup: ExposureSetup, *, seed: int, limits: Limits) -> ScatterResult:
        """As the class says."""
        require_material(setup, self.behind)
        detector = setup.geometry.detector.binned(self.cell_mm)
        lengths = path_lengths(setup.phantom, Geometry(setup.geometry.source, detector))
        requested = lengths[..., self.behind] > lengths[..., self.behind].max() / 2
        p, q = _energies(setup, lengths[requested])
        setting = Setting(setup.body, setup.matter, setup.beam(detector, q), p / q, requested)
        steps = longest_path(setup.body)

        def kernel(b: int, cells: np.ndarray) -> None:
            scatter_block(setting, steps, b, SCATTER_BLOCK, seed, cells)

        def error(found: list[Estimate]) -> float:
            value, error = found[0].value[0][requested], found[0].error[0][requested]
            return float(np.sqrt(np.mean((error / value) ** 2))) if np.all(value > 0) else np.inf

        goal = Goal("the scatter per cell", error, self.relative_error)
        run = run_blocks(kernel, ((2, *detector.shape),), goal, block=SCATTER_BLOCK, limits=limits)
        values, errors = run.estimates[0].value, run.estimates[0].error
        scatter, squared = (Estimate(values[i], errors[i]) for i in range(2))
        return ScatterResult(scatter, squared, detector, requested, run.histories, setup.photons_per_mas)


def require_material(setup: ExposureSetup, index: int) -> None:
    """Raises XrayError when no voxel has the index, or it is the air's."""
    if index == AIR or not np.any(setup.phantom.index == index):
        raise XrayError(f"no voxel has index {index}, whose energy or shadow is requested; 0 is the air")


def _energies(setup: ExposureSetup, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The spectrum p, and the probabilities q ~ p E T of drawing its energies; T: mean transmission through
    lengths (n, n_material). Both (n_energy,), adding to one."""
    E, p = setup.spectrum.energies_kev, setup.spectrum.fluence / setup.spectrum.fluence.sum()
    T = np.exp(-lengths @ setup.attenuations()[..., 0].T).mean(axis=0)
    q = p * E * T / np.sum(p * E * T)
    return p, (1 - UNBIASED) * q + UNBIASED * p


def _primary_in(setup: ExposureSetup, boxes: np.ndarray, seed: int) -> Estimate:
    """keV per photon that primary photons give to boxes (n_region, 6)."""
    geometry, E = setup.geometry, setup.spectrum.energies_kev
    beam, mu, steps = setup.beam(geometry.detector), setup.attenuations(), longest_path(setup.body)
    f = kept_fraction(setup.matter, E, mu)
    p = setup.spectrum.fluence / setup.spectrum.fluence.sum()
    found = np.empty((REPLICATES, len(boxes)))
    for j, box in enumerate(boxes):
        window = _shadow(geometry, box)
        area = (window[1] - window[0]) * (window[3] - window[2])
        for i in range(REPLICATES):
            rays = (window, RAYS, steps, seed + 1 + i + REPLICATES * j)
            per_energy = primary_given(setup.body, mu, f, beam, box[None], *rays)
            found[i, j] = (p * E) @ per_energy * area / geometry.solid_angle()
    return Estimate(found.mean(axis=0), found.std(axis=0, ddof=1) / np.sqrt(REPLICATES))


def _shadow(geometry: Geometry, box: np.ndarray) -> np.ndarray:
    """Low and high along u, then v, mm, of the shadow that a box casts on the detector.

    Raises XrayError when it casts none.
    """
    corners = np.array([[box[i], box[j], box[k]] for i in (0, 3) for j in (1, 4) for k in (2, 5)])
    uv = geometry.project(corners)
    low, high = (
        np.clip(uv.min(axis=0), 0, geometry.detector.size_mm),
        np.clip(uv.max(axis=0), 0, geometry.detector.size_mm),
    )
    if not np.all(low < high):
        raise XrayError(f"the region {box} mm casts no shadow on the detector; no primary reaches it")
    return np.array([low[0], high[0], low[1], high[1]])


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
