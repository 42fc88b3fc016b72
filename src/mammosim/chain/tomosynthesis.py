"""Tomosynthesis of a compressed breast: views over an arc with their noise and scatter, and slices."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from mammosim.chain.image_chain import Acquisition, Equipment
from mammosim.chain.mammogram import RING_MM, View, scatter_behind, xray_phantom
from mammosim.chain.phantom import healthy
from mammosim.core.errors import XrayError
from mammosim.core.labels import Label
from mammosim.core.settings import require_positive, require_within
from mammosim.core.volume import Grid, Image, LabelMap, grid_around
from mammosim.xray.detector import Scatter, expose, on_pixels
from mammosim.xray.geometry import Detector, Geometry
from mammosim.xray.observer import cnr
from mammosim.xray.projector import primary
from mammosim.xray.reconstruction import Slices, line_integrals
from mammosim.xray.spectrum import Spectrum
from mammosim.xray.systems import System
from mammosim.xray.views import tomosynthesis_geometries

# Shadows of less than this share of the signal without a body are taken as this: noise leaves no logarithm.
LEAST_TRANSMISSION = 1e-4
Reconstruction = Callable[[Sequence[np.ndarray], Sequence[Geometry], Grid], Slices]


@dataclass(frozen=True)
class ScanSettings:
    """`xray.tomosynthesis`: system, pixels, slices, iterations of SART, views in which scatter is simulated.

    exposure_share: of the mAs of the mammogram, for all views together.
    """

    system: str
    pixel_mm: float
    slice_mm: float
    iterations: int
    exposure_share: float
    scatter_views: int

    def __post_init__(self) -> None:
        require_positive(self, "pixel_mm", "slice_mm", "exposure_share")
        require_within("iterations", self.iterations, 1, 1000)
        require_within("scatter_views", self.scatter_views, 1, 1000)


@dataclass(frozen=True)
class ScatterAt:
    """Scatter per mAs (nv, nu) on the cells of a coarse detector, for a source at angle_deg."""

    angle_deg: float
    cells: Detector
    scatter: Scatter

    def on(self, pixels: Detector) -> Scatter:
        """Linear between the centres of the cells, on the pixels of another detector in the same place."""
        parts = (self.scatter.signal, self.scatter.signal_squared)
        return Scatter(*(on_pixels(part, self.cells, pixels) for part in parts))


def between(known: Sequence[ScatterAt], angle_deg: float, pixels: Detector) -> Scatter:
    """The scatter at an angle, linear between the two known ones around it."""
    # ASSUME: scatter is linear in the angle between those at which it was simulated.
    angles = [each.angle_deg for each in known]
    high = int(np.clip(np.searchsorted(angles, angle_deg), 1, len(known) - 1)) if len(known) > 1 else 0
    low = max(high - 1, 0)
    width = angles[high] - angles[low]
    share = float(np.clip((angle_deg - angles[low]) / width, 0, 1)) if width else 0.0
    a, b = known[low].on(pixels), known[high].on(pixels)
    return Scatter(
        (1 - share) * a.signal + share * b.signal,
        (1 - share) * a.signal_squared + share * b.signal_squared,
    )


@dataclass(frozen=True)
class Arc:
    """A system's views of a breast; equipment, seed and steps of their images: chain.image_chain."""

    system: System
    geometries: tuple[Geometry, ...]
    middle_mm: float
    spectrum: Spectrum
    equipment: Equipment
    steps: tuple[str, ...]
    seed: int = 0

    @classmethod
    def of(
        cls, labels: LabelMap, system: System, spectrum: Spectrum, *, chest_y_mm: float, pixel_mm: float,
        equipment: Equipment, steps: Sequence[str], seed: int = 0,
    ) -> "Arc":  # fmt: skip
        """Raises XrayError when the breast leaves the field of a view."""
        # ASSUME: tomosynthesis is taken without an anti-scatter grid.
        phantom = xray_phantom(labels)
        geometries = tomosynthesis_geometries(phantom, system, chest_wall_y_mm=chest_y_mm, pixel_mm=pixel_mm)
        body = labels.grid.shape[0] * labels.grid.spacing[2] / 2
        names = tuple(name for name in steps if name != "grid")
        middle_mm = system.support_to_detector_mm + body
        return cls(system, geometries, middle_mm, spectrum, equipment, names, seed)

    def scattered(
        self, labels: LabelMap, views: int, *, relative_error: float, seed: int
    ) -> tuple[ScatterAt, ...]:
        """Scatter by Monte Carlo in so many views, evenly over the arc, on cells that are the pixels."""
        numbers = np.unique(np.linspace(0, self.system.views - 1, views).round().astype(int))
        found = []
        for n in numbers:
            geometry, angle = self.geometries[n], float(self.system.angles_deg[n])
            run = scatter_behind(
                labels, geometry, self.spectrum,
                relative_error=relative_error, cell_mm=geometry.detector.pixel_mm, seed=seed + int(n),
            )  # fmt: skip
            parts = (run.per_mas(tally).value for tally in (run.scatter, run.scatter_squared))
            found.append(ScatterAt(angle, run.detector, Scatter(*parts)))
        return tuple(found)

    def integrals(
        self, labels: LabelMap, *, mas: float, scatter: Sequence[ScatterAt], rng: np.random.Generator
    ) -> list[np.ndarray]:
        """-ln(I / I0) of every view, each with its part of the mAs."""
        phantom, share, found = xray_phantom(labels), mas / self.system.views, []
        for geometry, angle in zip(self.geometries, self.system.angles_deg):
            seen = between(scatter, angle, geometry.detector) if scatter else None
            acquisition = Acquisition(geometry, self.middle_mm, self.equipment, self.seed)
            view = View(acquisition, self.spectrum, self.steps, seen)
            image = primary(phantom, geometry, self.spectrum, response=view.chain.response)
            pixel = geometry.detector.pixel_mm
            shot = expose(
                image, view.scatter_seen, mas=share, pixel_mm=pixel, rng=rng, steps=view.chain.steps
            )
            bright = image.unobstructed * pixel**2 * share
            found.append(line_integrals(np.maximum(shot.image, LEAST_TRANSMISSION * bright), bright))
        return found


def slices_grid(labels: LabelMap, *, voxel_mm: float, slice_mm: float) -> Grid:
    """Voxels over the whole compressed breast."""
    inside = labels.grid.points(np.argwhere(labels.values != Label.AIR).astype(float))
    half = labels.grid.spacing / 2
    return grid_around(
        inside.min(axis=0) - half, inside.max(axis=0) + half, np.array([voxel_mm, voxel_mm, slice_mm])
    )


@dataclass(frozen=True)
class Masks:
    """Lesion and a ring of breast around it (ny, nx) bool; slice: the number of that through its middle."""

    lesion: np.ndarray
    ring: np.ndarray
    slice: int

    @classmethod
    def of(cls, labels: LabelMap, grid: Grid) -> "Masks":
        """Of the labels' lesion on the grid of slices. Raises XrayError when there is no lesion."""
        inside = labels.grid.points(np.argwhere(labels.values == Label.LESION).astype(float))
        if len(inside) == 0:
            raise XrayError("no voxel is lesion; insert one before the views are taken")
        middle = inside.mean(axis=0)
        radius = float(np.cbrt(3 / (4 * np.pi) * len(inside) * labels.grid.voxel_volume))
        k = int(np.clip(np.rint(grid.indices(middle[None])[0, 0]), 0, grid.shape[0] - 1))
        j, i = np.indices(grid.shape[1:])
        points = grid.points(np.stack([np.full(j.size, k), j.ravel(), i.ravel()], axis=1).astype(float))
        r = np.hypot(*(points - middle)[:, :2].T).reshape(j.shape)
        at = np.rint(labels.grid.indices(points)).astype(int)
        at = np.clip(at, 0, np.array(labels.grid.shape) - 1)
        breast = (labels.values[tuple(at.T)] != Label.AIR).reshape(j.shape)
        return cls(r <= radius, (r >= radius + RING_MM[0]) & (r <= radius + RING_MM[1]) & breast, k)

    def row(self, slices: Image) -> dict[str, float]:
        """CNR of the lesion in its slice, with its standard error."""
        found = cnr(slices.values[self.slice], self.lesion, self.ring)
        return {"cnr": found.cnr, "cnr_se": found.standard_error}

    def profile(self, lesion: Image) -> pd.DataFrame:
        """height_mm of every slice over the lesion's, and there what the lesion adds, less around it, 1/mm.

        lesion: slices with the lesion less slices without it.
        """
        V = lesion.values
        height = lesion.grid.spacing[2] * (np.arange(len(V)) - self.slice)
        difference = V[:, self.lesion].mean(axis=1) - V[:, self.ring].mean(axis=1)
        return pd.DataFrame({"height_mm": height, "difference_per_mm": difference})


def lesion_alone(arc: Arc, labels: LabelMap, grid: Grid, reconstructed: Reconstruction) -> Image:
    """What a lesion adds to the slices: those of exact views with it less those without, free of noise."""
    bare = replace(arc, steps=())
    rng = np.random.default_rng(0)  # nothing is drawn from it
    views = (bare.integrals(body, mas=1.0, scatter=(), rng=rng) for body in (labels, healthy(labels)))
    with_it, without = (reconstructed(b, arc.geometries, grid).image.values for b in views)
    return Image(grid, with_it - without)
